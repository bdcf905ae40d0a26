// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import * as three from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { h, setText } from '../../src/dom';
import type { Body } from './body';
import type { Marks } from './marks';
import type { SlicePlane, Slices } from './slices';

export type StandardView = 'front' | 'back' | 'left' | 'right' | 'head' | 'feet';

/** From the body to the camera; the CT's x goes to the left, y to the back, z to the head. */
const DIRECTIONS: Record<StandardView, [number, number, number]> = {
  front: [0, -1, 0], back: [0, 1, 0], left: [1, 0, 0], right: [-1, 0, 0],
  head: [0, -0.001, 1], feet: [0, -0.001, -1],
};
/** From where a slice is seen well together with what is left of the body. */
const ONTO: Record<SlicePlane, [number, number, number]> = {
  axial: [0.15, -1, 0.85], coronal: [0.15, -1, 0.2], sagittal: [1, -0.55, 0.2],
};
const LETTERS = [['R', 'L'], ['A', 'P'], ['F', 'H']] as const;
const FLY_MS = 450;

/** The picture: draws when something has changed, and only then. */
export class Stage {
  readonly element: HTMLElement;
  cutOpen = true;

  private readonly renderer = new three.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
  private readonly scene = new three.Scene();
  private readonly camera = new three.PerspectiveCamera(28, 1, 10, 20000);
  private readonly controls: OrbitControls;
  private readonly lamp = new three.DirectionalLight(0xffffff, 2.1);
  private readonly letters = ['left', 'right', 'top', 'bottom'].map((side) =>
    h('span', { class: `letter at-${side}`, 'aria-hidden': 'true' }));
  private readonly center = new three.Vector3();
  private readonly radius: number;
  private isPlanned = false;
  private flight: { from: three.Vector3; to: three.Vector3; target: [three.Vector3, three.Vector3]; start: number } | undefined;

  constructor(private readonly body: Body, private readonly slices: Slices | undefined,
    private readonly marks: Marks) {
    this.renderer.localClippingEnabled = true;
    this.renderer.setClearColor(0x0e1216, 1);
    this.scene.add(body.group, marks.group, new three.HemisphereLight(0xffffff, 0xb8c2cc, 1.15), this.lamp);
    if (slices) this.scene.add(slices.group);
    body.box.getCenter(this.center);
    this.radius = 0.5 * body.box.getSize(new three.Vector3()).length();
    this.camera.up.set(0, 0, 1);
    this.camera.near = this.radius / 50;
    this.camera.far = this.radius * 30;
    this.element = h('section', { class: 'stage', 'aria-label': 'Body' },
      this.renderer.domElement, marks.element, ...this.letters);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.rotateSpeed = 0.8;
    this.controls.minDistance = this.radius * 0.25;
    this.controls.maxDistance = this.radius * 12;
    this.controls.addEventListener('change', () => this.plan());
    this.controls.addEventListener('start', () => (this.flight = undefined));
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  /** Draws before the browser's next picture. */
  plan(): void {
    if (this.isPlanned) return;
    this.isPlanned = true;
    requestAnimationFrame((now) => {
      this.isPlanned = false;
      this.draw(now);
    });
  }

  look(view: StandardView, quick = false): void {
    const direction = new three.Vector3(...DIRECTIONS[view]);
    this.flyTo(direction, this.center, this.fitDistance(direction), quick);
  }

  /** Looks at a place on the body from outside. */
  lookAt(place: three.Vector3, normal: three.Vector3 | undefined): void {
    const direction = normal?.clone() ?? this.camera.position.clone().sub(place).normalize();
    direction.z = three.MathUtils.clamp(direction.z, -0.7, 0.7);
    direction.normalize();
    this.flyTo(direction, place, Math.min(this.fitDistance(direction), this.radius * 1.9), false);
  }

  /** Turns so that a slice is seen, where it is seen edge on. */
  lookOnto(plane: SlicePlane): void {
    const direction = this.camera.position.clone().sub(this.controls.target).normalize();
    const onto = new three.Vector3(...ONTO[plane]).normalize();
    const axis = { sagittal: direction.x, coronal: direction.y, axial: direction.z }[plane];
    if (Math.abs(axis) < 0.5) this.flyTo(onto, this.center, this.fitDistance(onto), false);
  }

  private flyTo(direction: three.Vector3, target: three.Vector3, distance: number, quick: boolean): void {
    const to = target.clone().addScaledVector(direction, distance);
    this.flight = {
      from: this.camera.position.clone(), to, target: [this.controls.target.clone(), target.clone()],
      start: quick ? -Infinity : performance.now(),
    };
    this.plan();
  }

  /** From where all of the body is seen, looking in a direction. */
  private fitDistance(direction: three.Vector3): number {
    const half = Math.tan(three.MathUtils.degToRad(this.camera.fov) / 2);
    const size = this.body.box.getSize(new three.Vector3()).multiplyScalar(0.5);
    const along = Math.abs(direction.z);
    const depth = along * size.z + (1 - along) * Math.max(size.x, size.y);
    const height = along * size.y + (1 - along) * size.z;
    const width = Math.max(size.x, size.y);
    return 1.12 * Math.max(height / half, width / (half * this.camera.aspect)) + depth;
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.plan();
  }

  private fly(now: number): void {
    if (!this.flight) return;
    const { from, to, target, start } = this.flight;
    const share = Math.min(1, (now - start) / FLY_MS);
    const eased = share * share * (3 - 2 * share);
    // Around the body, not through it.
    this.controls.target.lerpVectors(...target, eased);
    const offset = new three.Vector3().lerpVectors(
      from.clone().sub(target[0]).normalize(), to.clone().sub(target[1]).normalize(), eased);
    if (offset.lengthSq() < 1e-6) offset.set(1, 0, 0);
    const distance = three.MathUtils.lerp(from.distanceTo(target[0]), to.distanceTo(target[1]), eased);
    this.camera.position.copy(this.controls.target).addScaledVector(offset.normalize(), distance);
    if (share >= 1) {
      this.camera.position.copy(to);
      this.flight = undefined;
    }
    this.controls.update();
    this.plan();
  }

  private draw(now: number): void {
    this.fly(now);
    this.lamp.position.copy(this.camera.position);
    this.body.cut(this.slices && this.cutOpen ? this.slices.cuts(this.camera.position.clone().sub(this.controls.target)) : []);
    this.renderer.render(this.scene, this.camera);
    this.camera.updateMatrixWorld();
    this.marks.update(this.camera, this.element.clientWidth, this.element.clientHeight);
    this.showLetters();
  }

  /** Which way of the body the picture's sides are. */
  private showLetters(): void {
    const right = new three.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 0);
    const up = new three.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 1);
    const sides = [right.clone().negate(), right, up, up.clone().negate()];
    sides.forEach((direction, i) => setText(this.letters[i]!, lettersOf(direction)));
  }
}

/** "L", or "LA" between left and front: the larger share first. */
export function lettersOf(direction: three.Vector3): string {
  return direction.toArray()
    .map((share, axis) => ({ size: Math.abs(share), letter: LETTERS[axis]![share > 0 ? 1 : 0] }))
    .filter(({ size }) => size > 0.38)
    .sort((a, b) => b.size - a.size)
    .map(({ letter }) => letter)
    .join('');
}
