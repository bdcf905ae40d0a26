// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import * as three from 'three';
import { Line2 } from 'three/examples/jsm/lines/Line2.js';
import { LineGeometry } from 'three/examples/jsm/lines/LineGeometry.js';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import type { Point3 } from '../../src/api';
import { h } from '../../src/dom';
import { lengthWords, type Finding } from './case_data';

const COLOR = 0xffc14d;
const LIFT_MM = 0.8;

/** A way of at most a few hundred places, its ends kept. */
function thinned(way: Point3[]): Point3[] {
  const step = Math.ceil(way.length / 300);
  return way.filter((_place, i) => i % step === 0 || i === way.length - 1);
}

interface Pin {
  element: HTMLElement;
  place: three.Vector3;
  /** Out of the skin; none: inside of the body. */
  normal: three.Vector3 | undefined;
}

/** The findings on the body: numbered pins, and the ways of measurements with their lengths. */
export class Marks {
  readonly group = new three.Group();
  readonly element = h('div', { class: 'marks' });
  private readonly pins: Pin[] = [];
  private readonly lines: LineMaterial[] = [];

  constructor(findings: Finding[], private readonly skin: three.Mesh, onPress: (finding: Finding) => void) {
    for (const finding of findings) {
      finding.points.forEach((point, i) => {
        const pin = h('button',
          { type: 'button', class: 'pin', 'data-id': finding.id, onclick: () => onPress(finding) },
          i === 0 ? h('span', {}, finding.id) : h('span', { class: 'end' }));
        this.addPin(pin, point.ct_mm, point.on_skin);
      });
      this.addWay(finding);
    }
  }

  /** Where a finding is, and the way out of the body there. */
  placeOf(finding: Finding): { place: three.Vector3; normal: three.Vector3 | undefined } | undefined {
    const pin = this.pins.find(({ element }) => element.dataset['id'] === finding.id);
    return pin && { place: pin.place, normal: pin.normal };
  }

  select(id: string | undefined): void {
    for (const { element } of this.pins) {
      element.classList.toggle('chosen', id !== undefined && element.dataset['id'] === id);
    }
  }

  update(camera: three.PerspectiveCamera, width: number, height: number): void {
    for (const line of this.lines) line.resolution.set(width, height);
    const view = new three.Vector3();
    for (const { element, place, normal } of this.pins) {
      view.copy(place).project(camera);
      element.hidden = view.z > 1 || Math.abs(view.x) > 1.1 || Math.abs(view.y) > 1.1;
      element.style.transform =
        `translate(${((view.x + 1) / 2) * width}px, ${((1 - view.y) / 2) * height}px)`;
      const isBehind = normal !== undefined && normal.dot(view.subVectors(camera.position, place)) < 0;
      element.classList.toggle('behind', isBehind);
    }
  }

  private addPin(element: HTMLElement, ct_mm: Point3, onSkin: boolean): void {
    const place = new three.Vector3(...ct_mm);
    this.pins.push({ element, place, normal: onSkin ? this.normalAt(place) : undefined });
    if (!onSkin) element.classList.add('inside');
    this.element.append(element);
  }

  private addWay(finding: Finding): void {
    const way = thinned(finding.path_ct_mm.length > 1 ? finding.path_ct_mm
      : finding.points.map(({ ct_mm }) => ct_mm)).map((point) => new three.Vector3(...point));
    if (way.length < 2) return;
    const onSkin = finding.kind === 'geodesic';
    const lifted = way.map((place) => (onSkin
      ? place.clone().addScaledVector(this.normalAt(place) ?? new three.Vector3(), LIFT_MM) : place));
    const geometry = new LineGeometry();
    geometry.setPositions(lifted.flatMap((place) => place.toArray()));
    // Once where it is seen, and faintly where the body hides it.
    for (const [opacity, depthTest] of [[1, true], [0.35, false]] as const) {
      const material = new LineMaterial({
        color: COLOR, linewidth: 3, transparent: true, opacity, depthTest, depthWrite: false,
      });
      const line = new Line2(geometry, material);
      line.renderOrder = 20;
      this.lines.push(material);
      this.group.add(line);
    }
    const label = h('span', { class: 'length', 'data-id': finding.id }, lengthWords(finding));
    const middle = lifted[lifted.length >> 1]!;
    const place = lifted.length > 2 ? middle : lifted[0]!.clone().lerp(lifted[1]!, 0.5);
    this.pins.push({ element: label, place, normal: onSkin ? this.normalAt(place) : undefined });
    this.element.append(label);
  }

  /** Of the skin's nearest vertex. */
  private normalAt(place: three.Vector3): three.Vector3 | undefined {
    const places = this.skin.geometry.getAttribute('position');
    const normals = this.skin.geometry.getAttribute('normal');
    let best = -1;
    let bestSquare = Infinity;
    for (let i = 0; i < places.count; ++i) {
      const square = (places.getX(i) - place.x) ** 2 + (places.getY(i) - place.y) ** 2 +
        (places.getZ(i) - place.z) ** 2;
      if (square < bestSquare) [best, bestSquare] = [i, square];
    }
    return best < 0 ? undefined : new three.Vector3().fromBufferAttribute(normals, best);
  }
}
