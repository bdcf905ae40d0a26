// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { panned, turned, zoomed, type FreeViewpoint } from './free_view';
import type { Point, Size } from './geometry';

const TAP_WITHIN_PX = 8;
const WHEEL_ZOOM = 1.1;

export interface FreeGestureSource {
  /** Where the virtual camera is; undefined while another picture is shown. */
  viewpoint(): FreeViewpoint | undefined;
  radiusMm(): number;
  /** The picture as it is shown, in pixels of the screen. */
  shown(): Size;
  change(viewpoint: FreeViewpoint): void;
}

/**
 * The virtual camera by hand: one finger turns, two move and zoom. With a mouse: drag, drag with
 * shift or the right button, wheel.
 */
export class FreeGestures {
  private readonly fingers = new Map<number, Point>();
  private pans = false;
  private hasMoved = false;
  private pressed: Point | undefined;

  constructor(private readonly element: HTMLElement, private readonly source: FreeGestureSource) {
    element.addEventListener('pointerdown', (event) => this.press(event));
    element.addEventListener('pointermove', (event) => this.move(event));
    element.addEventListener('pointerup', (event) => this.fingers.delete(event.pointerId));
    element.addEventListener('pointercancel', (event) => this.fingers.delete(event.pointerId));
    element.addEventListener('contextmenu', (event) => {
      if (this.source.viewpoint()) event.preventDefault();
    });
    element.addEventListener('wheel', (event) => this.wheel(event), { passive: false });
  }

  private press(event: PointerEvent): void {
    if (!this.source.viewpoint()) return;
    this.element.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, pointOf(event));
    this.pans = event.shiftKey || event.button === 2;
    this.pressed = pointOf(event);
    this.hasMoved = this.fingers.size > 1;
  }

  private move(event: PointerEvent): void {
    const viewpoint = this.source.viewpoint();
    const before = this.fingers.get(event.pointerId);
    if (!viewpoint || !before || !this.pressed) return;
    const now = pointOf(event);
    // A finger that taps trembles.
    this.hasMoved ||= distance(now, this.pressed) > TAP_WITHIN_PX;
    if (!this.hasMoved) return;
    const shown = this.source.shown();
    if (this.fingers.size > 1) {
      this.source.change(this.pinched(viewpoint, event.pointerId, before, now));
    } else if (this.pans) {
      this.source.change(panned(viewpoint, difference(now, before), this.source.radiusMm(), shown));
    } else {
      this.source.change(turned(viewpoint, difference(now, before), shown));
    }
    this.fingers.set(event.pointerId, now);
  }

  /** One of two fingers has moved: the point between them carries the body, their distance zooms. */
  private pinched(viewpoint: FreeViewpoint, id: number, before: Point, now: Point): FreeViewpoint {
    const other = [...this.fingers].find(([finger]) => finger !== id)![1];
    const shown = this.source.shown();
    const moved = { x: (now.x - before.x) / 2, y: (now.y - before.y) / 2 };
    const factor = distance(now, other) / Math.max(distance(before, other), 1);
    const middle = { x: (now.x + other.x) / 2, y: (now.y + other.y) / 2 };
    const carried = panned(viewpoint, moved, this.source.radiusMm(), shown);
    return zoomed(carried, factor, this.fromMiddle(middle), this.source.radiusMm(), shown);
  }

  private wheel(event: WheelEvent): void {
    const viewpoint = this.source.viewpoint();
    if (!viewpoint) return;
    event.preventDefault();
    const factor = event.deltaY < 0 ? WHEEL_ZOOM : 1 / WHEEL_ZOOM;
    const at = this.fromMiddle({ x: event.clientX, y: event.clientY });
    this.source.change(zoomed(viewpoint, factor, at, this.source.radiusMm(), this.source.shown()));
  }

  private fromMiddle(point: Point): Point {
    const box = this.element.getBoundingClientRect();
    return { x: point.x - box.left - box.width / 2, y: point.y - box.top - box.height / 2 };
  }
}

function pointOf(event: PointerEvent): Point {
  return { x: event.clientX, y: event.clientY };
}

function difference(a: Point, b: Point): Point {
  return { x: a.x - b.x, y: a.y - b.y };
}

function distance(a: Point, b: Point): number {
  return Math.hypot(a.x - b.x, a.y - b.y);
}
