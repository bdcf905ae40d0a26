// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import * as three from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';

const INSIDE = 0x5a4541;

/** As the file has it; three.js takes blanks out of names. */
function nameOf(mesh: three.Mesh): string {
  return String(mesh.userData['name'] ?? mesh.name);
}

export interface Part {
  name: string;
  color: string;
  /** What of it is shown: 0 nothing, 1 all. */
  show(opacity: number): void;
}

/** The model of the GLB in the CT's frame and millimetres, skin and structures to be shown or not. */
export class Body {
  readonly group = new three.Group();
  readonly parts: Part[] = [];
  readonly skin: three.Mesh;
  readonly box = new three.Box3();
  private readonly materials: three.Material[] = [];
  private readonly skinColors: { lit: three.Material; flat: three.Material };

  static async load(glb: ArrayBuffer): Promise<Body> {
    const loaded = await new GLTFLoader().parseAsync(glb, '');
    return new Body(loaded.scene);
  }

  private constructor(scene: three.Group) {
    // From glTF's metres with y up to the CT's millimetres with z to the head.
    scene.rotation.x = Math.PI / 2;
    scene.scale.setScalar(1000);
    scene.updateMatrixWorld(true);
    const meshes: three.Mesh[] = [];
    scene.traverse((node) => {
      if (node instanceof three.Mesh) meshes.push(node);
    });
    for (const mesh of meshes) {
      mesh.geometry.applyMatrix4(mesh.matrixWorld);
      mesh.position.set(0, 0, 0);
      mesh.rotation.set(0, 0, 0);
      mesh.scale.setScalar(1);
      mesh.removeFromParent();
      this.group.add(mesh);
    }
    this.skin = meshes[0]!;
    this.skin.geometry.computeBoundingBox();
    this.box.copy(this.skin.geometry.boundingBox!);
    this.skinColors = this.addSkin(this.skin);
    for (const mesh of meshes.slice(1)) this.addStructure(mesh);
  }

  /** Whether light is put on the skin, or it is shown as the camera saw it. */
  light(on: boolean): void {
    this.skin.material = on ? this.skinColors.lit : this.skinColors.flat;
  }

  /** Where all planes cut, nothing is shown. */
  cut(planes: three.Plane[]): void {
    for (const material of this.materials) {
      material.clippingPlanes = planes;
      material.clipIntersection = true;
      material.needsUpdate = true;
    }
  }

  private addSkin(mesh: three.Mesh): { lit: three.Material; flat: three.Material } {
    const source = mesh.material as three.MeshStandardMaterial;
    const map = source.map;
    if (map) map.anisotropy = 8;
    const look = { map, color: map ? new three.Color(0xffffff) : source.color };
    const lit = new three.MeshLambertMaterial(look);
    const flat = new three.MeshBasicMaterial(look);
    // The skin's inner side, where the CT ends or the body is cut open.
    const inside = new three.MeshBasicMaterial({ color: INSIDE, side: three.BackSide });
    // Laid first into the depth alone, so that of a see-through skin only the front is seen.
    const depth = new three.MeshBasicMaterial({ colorWrite: false });
    const inner = new three.Mesh(mesh.geometry, inside);
    const front = new three.Mesh(mesh.geometry, depth);
    front.renderOrder = 10;
    mesh.renderOrder = 11;
    mesh.material = lit;
    this.group.add(inner, front);
    this.materials.push(lit, flat, inside, depth);
    this.parts.push({
      name: nameOf(mesh),
      color: map ? '#c9a48f' : `#${source.color.getHexString()}`,
      show(opacity) {
        mesh.visible = opacity > 0;
        inner.visible = opacity >= 1;
        front.visible = opacity > 0 && opacity < 1;
        for (const material of [lit, flat]) {
          material.transparent = opacity < 1;
          material.opacity = opacity;
          material.needsUpdate = true;
        }
      },
    });
    return { lit, flat };
  }

  private addStructure(mesh: three.Mesh): void {
    const { color } = mesh.material as three.MeshStandardMaterial;
    const material = new three.MeshLambertMaterial({ color, side: three.DoubleSide });
    mesh.material = material;
    this.materials.push(material);
    this.parts.push({
      name: nameOf(mesh),
      color: `#${color.getHexString()}`,
      show(opacity) {
        mesh.visible = opacity > 0;
        material.transparent = opacity < 1;
        material.depthWrite = opacity >= 1;
        material.opacity = opacity;
        material.needsUpdate = true;
      },
    });
  }
}
