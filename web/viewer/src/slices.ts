// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import * as three from 'three';
import type { VolumeInfo } from './case_data';

export type SlicePlane = 'axial' | 'coronal' | 'sagittal';
export const PLANES: readonly SlicePlane[] = ['axial', 'coronal', 'sagittal'];
const AXIS: Record<SlicePlane, number> = { sagittal: 0, coronal: 1, axial: 2 };

const VERTEX = `
  uniform mat4 texture_from_ct;
  out vec3 place;
  void main() {
    vec4 ct = modelMatrix * vec4(position, 1.0);
    place = (texture_from_ct * ct).xyz;
    gl_Position = projectionMatrix * viewMatrix * ct;
  }`;

const FRAGMENT = `
  precision highp float;
  precision highp sampler3D;
  uniform sampler3D codes;
  uniform vec4 code_knots;
  uniform vec4 hu_knots;
  uniform float level;
  uniform float window;
  in vec3 place;
  out vec4 color;
  void main() {
    if (any(lessThan(place, vec3(0.0))) || any(greaterThan(place, vec3(1.0)))) discard;
    float code = texture(codes, place).r * 255.0;
    if (code < 0.5 * code_knots.x) discard;
    float hu = hu_knots.x;
    for (int i = 0; i < 3; ++i) {
      float share = clamp((code - code_knots[i]) / (code_knots[i + 1] - code_knots[i]), 0.0, 1.0);
      hu += share * (hu_knots[i + 1] - hu_knots[i]);
    }
    float gray = clamp((hu - level) / window + 0.5, 0.0, 1.0);
    color = vec4(vec3(gray), 1.0);
  }`;

/** Grey CT slices through the body, along the CT frame's axes. */
export class Slices {
  readonly group = new three.Group();
  private readonly shown: Record<SlicePlane, boolean> = { axial: false, coronal: false, sagittal: false };
  private readonly sheets = new Map<SlicePlane, three.Mesh>();
  private readonly uniforms;

  constructor(info: VolumeInfo, codes: ArrayBuffer, private readonly box: three.Box3) {
    const texture = new three.Data3DTexture(new Uint8Array(codes), ...info.size);
    texture.format = three.RedFormat;
    texture.minFilter = texture.magFilter = three.LinearFilter;
    texture.unpackAlignment = 1;
    texture.needsUpdate = true;
    const knots = (i: 0 | 1): three.Vector4 => new three.Vector4(...info.codes.map((knot) => knot[i]));
    this.uniforms = {
      codes: { value: texture },
      texture_from_ct: { value: textureFromCt(info) },
      code_knots: { value: knots(0) },
      hu_knots: { value: knots(1) },
      level: { value: 40 },
      window: { value: 400 },
    };
    for (const plane of PLANES) this.addSheet(plane);
  }

  show(plane: SlicePlane, on: boolean): void {
    this.shown[plane] = on;
    this.sheets.get(plane)!.visible = on;
  }

  get any(): boolean {
    return PLANES.some((plane) => this.shown[plane]);
  }

  /** 0..1 through the body: feet to head, front to back, right to left. */
  move(plane: SlicePlane, share: number): void {
    const axis = AXIS[plane];
    const low = this.box.min.getComponent(axis);
    const high = this.box.max.getComponent(axis);
    this.sheets.get(plane)!.position.setComponent(axis, low + share * (high - low));
  }

  /** What of the body's box a plane's position is, in mm of the CT. */
  place(plane: SlicePlane): number {
    return this.sheets.get(plane)!.position.getComponent(AXIS[plane]);
  }

  setWindow(level: number, window: number): void {
    this.uniforms.level.value = level;
    this.uniforms.window.value = window;
  }

  /**
   * What to cut away so that the slices are seen: the camera's side; where the camera looks along a
   * slice, the head's, front's or left side.
   * @param towards from the body to the camera
   */
  cuts(towards: three.Vector3): three.Plane[] {
    const direction = towards.clone().normalize();
    return PLANES.filter((plane) => this.shown[plane]).map((plane) => {
      const axis = AXIS[plane];
      const normal = new three.Vector3();
      const place = this.place(plane);
      const share = direction.getComponent(axis);
      const isAlong = Math.abs(share) < 0.2;
      const side = (isAlong ? plane !== 'coronal' : share > 0) ? -1 : 1;
      normal.setComponent(axis, side);
      return new three.Plane(normal, -side * place + 0.01);
    });
  }

  private addSheet(plane: SlicePlane): void {
    const size = this.box.getSize(new three.Vector3());
    const sheet = new three.Mesh(
      new three.PlaneGeometry(1, 1),
      new three.ShaderMaterial({
        glslVersion: three.GLSL3, vertexShader: VERTEX, fragmentShader: FRAGMENT,
        uniforms: this.uniforms, side: three.DoubleSide,
      }));
    this.box.getCenter(sheet.position);
    const spare = 1.1;  // The skin is smoother than the voxels.
    if (plane === 'axial') sheet.scale.set(size.x * spare, size.y * spare, 1);
    if (plane === 'coronal') {
      sheet.rotation.x = Math.PI / 2;
      sheet.scale.set(size.x * spare, size.z * spare, 1);
    }
    if (plane === 'sagittal') {
      sheet.rotation.y = Math.PI / 2;
      sheet.scale.set(size.z * spare, size.y * spare, 1);
    }
    sheet.visible = false;
    this.sheets.set(plane, sheet);
    this.group.add(sheet);
  }
}

/** Voxel (0, 0, 0)'s centre is half a voxel inside of the texture's corner. */
function textureFromCt(info: VolumeInfo): three.Matrix4 {
  const axis = (i: 0 | 1 | 2): three.Vector3 => new three.Vector3(...info.axes[i]);
  const ctFromGrid = new three.Matrix4().makeBasis(axis(0), axis(1), axis(2))
    .setPosition(...info.origin_mm);
  const [sx, sy, sz] = info.spacing_mm;
  const [nx, ny, nz] = info.size;
  return new three.Matrix4().makeScale(1 / (sx * nx), 1 / (sy * ny), 1 / (sz * nz))
    .multiply(new three.Matrix4().makeTranslation(sx / 2, sy / 2, sz / 2))
    .multiply(ctFromGrid.invert());
}
