// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import * as three from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { h } from '../dom';
import { surface, type Check } from './api';
import { Latest } from './latest';

const SKIN = 0xd9b8a2;
const INSIDE = 0x5a4541;
const DOUBTFUL = 0xff961e;
const CUT_OPACITY = 0.6;

/** The skin to be turned, with what was cut off in its colours. */
export class BodyPane {
  readonly element: HTMLElement;
  private readonly renderer = new three.WebGLRenderer({ antialias: true });
  private readonly scene = new three.Scene();
  private readonly camera = new three.PerspectiveCamera(28, 1, 10, 20000);
  private readonly controls: OrbitControls;
  private readonly lamp = new three.DirectionalLight(0xffffff, 2.2);
  private readonly frame: HTMLElement;
  private readonly group = new three.Group();
  private readonly cutKey: HTMLButtonElement;
  private showsCut = true;
  private isPlanned = false;
  private isPlaced = false;
  private readonly loading = new Latest<Check>((check) => this.load(check));

  constructor(private readonly onProblem: (error: unknown) => void) {
    this.renderer.setClearColor(0x0e1216, 1);
    this.scene.add(this.group, new three.HemisphereLight(0xffffff, 0xb8c2cc, 0.9), this.lamp);
    this.camera.up.set(0, 0, 1);
    this.frame = h('div', { class: 'picture turnable' }, this.renderer.domElement);
    this.cutKey = h('button', { type: 'button', class: 'key', 'aria-pressed': 'true',
      onclick: () => this.toggleCut() }, 'What is cut');
    this.element = h('section', { class: 'pane body', 'aria-label': 'Skin, to be turned' }, this.frame,
      h('div', { class: 'views' }, ...(['Front', 'Left', 'Back', 'Right'] as const).map((side, i) =>
        h('button', { type: 'button', class: 'key', onclick: () => this.look(i) }, side)), this.cutKey));
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.rotateSpeed = 0.8;
    this.controls.addEventListener('change', () => this.plan());
    new ResizeObserver(() => this.resize()).observe(this.frame);
  }

  show(check: Check): void {
    this.loading.ask(check);
  }

  private async load(check: Check): Promise<void> {
    try {
      const cut = check.parts.map((part, i) => ({ part, i })).filter(({ part }) => !part.kept);
      const [skin, doubtful, ...parts] = await Promise.all(
        [surface('skin'), surface('doubtful'), ...cut.map(({ i }) => surface(i))]);
      for (const child of [...this.group.children]) {
        (child as three.Mesh).geometry.dispose();
        child.removeFromParent();
      }
      const geometry = geometryOf(skin!);
      this.group.add(new three.Mesh(geometry, new three.MeshLambertMaterial({ color: SKIN })),
        new three.Mesh(geometry, new three.MeshBasicMaterial({ color: INSIDE, side: three.BackSide })));
      // In front of the skin that it is a part of.
      this.group.add(new three.Mesh(geometryOf(doubtful!), new three.MeshLambertMaterial({
        color: DOUBTFUL, polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -1 })));
      parts.forEach((part, i) => {
        const mesh = new three.Mesh(geometryOf(part), new three.MeshLambertMaterial({
          color: cut[i]!.part.color, transparent: true, opacity: CUT_OPACITY, side: three.DoubleSide,
          depthWrite: false }));
        mesh.userData['isCut'] = true;
        mesh.visible = this.showsCut;
        this.group.add(mesh);
      });
      if (!this.isPlaced) {
        this.isPlaced = true;
        this.look(0);
      }
      this.plan();
    } catch (error) {
      this.onProblem(error);
    }
  }

  private toggleCut(): void {
    this.showsCut = !this.showsCut;
    this.cutKey.setAttribute('aria-pressed', String(this.showsCut));
    for (const child of this.group.children) {
      if (child.userData['isCut']) child.visible = this.showsCut;
    }
    this.plan();
  }

  /** From the front, or by quarter turns to the body's left from there. */
  private look(quarter: number): void {
    const skin = this.group.children[0];
    if (!skin) return;
    const box = new three.Box3().setFromObject(skin);
    const center = box.getCenter(new three.Vector3());
    const radius = 0.5 * box.getSize(new three.Vector3()).length();
    const angle = (quarter * Math.PI) / 2;
    const distance = (0.8 * radius) / Math.sin(three.MathUtils.degToRad(this.camera.fov / 2)) /
      Math.min(1, this.camera.aspect);
    this.camera.near = radius / 50;
    this.camera.far = radius * 30;
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(center);
    this.controls.minDistance = radius * 0.3;
    this.controls.maxDistance = radius * 12;
    this.camera.position.copy(center)
      .add(new three.Vector3(Math.sin(angle), -Math.cos(angle), 0).multiplyScalar(distance));
    this.controls.update();
    this.plan();
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.frame;
    if (clientWidth < 2 || clientHeight < 2) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(clientWidth, clientHeight);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.plan();
  }

  private plan(): void {
    if (this.isPlanned) return;
    this.isPlanned = true;
    requestAnimationFrame(() => {
      this.isPlanned = false;
      this.lamp.position.copy(this.camera.position);
      this.lamp.target.position.copy(this.controls.target);
      this.lamp.target.updateMatrixWorld();
      this.renderer.render(this.scene, this.camera);
    });
  }
}

function geometryOf({ positions, indices }: { positions: Float32Array; indices: Uint32Array }): three.BufferGeometry {
  const geometry = new three.BufferGeometry();
  geometry.setAttribute('position', new three.BufferAttribute(positions, 3));
  geometry.setIndex(new three.BufferAttribute(indices, 1));
  geometry.computeVertexNormals();
  return geometry;
}
