// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { View } from './api';
import { h, setClass, setText } from './dom';
import { clamp, containedBox, fromPicture, toPicture, type Point, type Size } from './geometry';
import type { Banner } from './status_text';

const DRAG_FROM_PX = 8;
const DOUBLE_TAP_MS = 350;
const DOUBLE_TAP_PX = 48;
// The live picture moves on below it.
const READOUT_MS = 4000;

/** The live picture and what lies over it. A finger on it moves the hole, or taps a point. */
export class Stage {
  readonly video = h('video', { muted: true, playsinline: true, 'aria-label': 'Live picture' });
  readonly element: HTMLElement;
  /** While set, a tap is a point (in the picture's pixels) and does not move the hole. */
  onTap: ((point: Point) => void) | undefined;

  private readonly readout = h('div', { class: 'readout', role: 'status', hidden: true });
  private readonly banner = h('div', { class: 'banner', role: 'alert', hidden: true });
  private readonly hint = h('div', { class: 'hint', hidden: true });
  private readonly ring = h('div', { class: 'ring', hidden: true });
  private readonly marks = h('div', { class: 'marks' });
  private down: { at: Point; moved: boolean } | undefined;
  private lastTap: { at: Point; time_ms: number } | undefined;
  private readoutTimer: number | undefined;

  constructor(
    private readonly view: () => View | undefined,
    private readonly onHole: (x: number, y: number) => void,
    private readonly onTouch: (point: Point) => void,
  ) {
    this.element = h('div', { class: 'stage' },
      this.video, this.ring, this.marks, this.readout, this.banner, this.hint);
    this.element.addEventListener('pointerdown', (event) => this.press(event));
    this.element.addEventListener('pointermove', (event) => this.move(event));
    this.element.addEventListener('pointerup', (event) => this.release(event));
    this.element.addEventListener('pointercancel', () => this.end());
  }

  /** The picture's own size; undefined before the first one. */
  pictureSize(): Size | undefined {
    const { videoWidth: width, videoHeight: height } = this.video;
    return width > 0 && height > 0 ? { width, height } : undefined;
  }

  showBanner(banner: Banner | undefined): void {
    this.banner.hidden = !banner;
    this.element.classList.toggle('not-now', banner?.kind === 'bad');
    if (!banner) return;
    setClass(this.banner, `banner ${banner.kind}`);
    setText(this.banner, banner.text);
  }

  showHint(text: string): void {
    this.hint.hidden = text === '';
    setText(this.hint, text);
  }

  /** The picture's rim says that what lies on it is not certain. */
  showUncertain(is: boolean): void {
    this.element.classList.toggle('uncertain', is);
  }

  /** Words at a point of the picture, for a while. */
  showReadout(pixel: Point, [words, more]: [string, string]): void {
    const picture = this.pictureSize();
    if (!picture) return;
    const at = fromPicture(pixel, this.box(), picture);
    const cross = h('span', { class: 'cross' });
    this.readout.replaceChildren(cross,
      h('span', { class: 'words' }, words, h('span', { class: 'more' }, more)));
    this.readout.classList.toggle('left', at.x > this.box().width / 2);
    this.readout.style.left = `${at.x}px`;
    this.readout.style.top = `${at.y}px`;
    this.readout.hidden = false;
    clearTimeout(this.readoutTimer);
    this.readoutTimer = window.setTimeout(() => this.hideReadout(), READOUT_MS);
  }

  hideReadout(): void {
    this.readout.hidden = true;
  }

  /** Draws numbered points, given in the picture's pixels. */
  showMarks(marks: { pixel: Point; label: string; color: string }[]): void {
    const picture = this.pictureSize();
    this.marks.replaceChildren(
      ...(picture ? marks : []).map(({ pixel, label, color }) => {
        const at = fromPicture(pixel, this.box(), picture!);
        return mark(at, label, color);
      }));
  }

  /** The free view has no hole to be moved: a finger turns it (FreeGestures). */
  private get isFree(): boolean {
    return this.view()?.picture === 'free';
  }

  /** The picture as it is shown, in pixels of the screen. */
  shownSize(): Size {
    const picture = this.pictureSize();
    return picture ? containedBox(this.box(), picture) : this.box();
  }

  private box(): DOMRect {
    return this.element.getBoundingClientRect();
  }

  private pointOf(event: PointerEvent): Point | undefined {
    const box = this.box();
    const picture = this.pictureSize();
    if (!picture) return undefined;
    return toPicture({ x: event.clientX - box.left, y: event.clientY - box.top }, box, picture);
  }

  private press(event: PointerEvent): void {
    if (!event.isPrimary && this.down) this.down.moved = true;  // Two fingers do not tap.
    if (!event.isPrimary || event.button !== 0 || !this.pointOf(event)) return;
    this.element.setPointerCapture(event.pointerId);
    this.down = { at: { x: event.clientX, y: event.clientY }, moved: false };
  }

  private move(event: PointerEvent): void {
    if (!this.down || (this.onTap && !this.isFree)) return;
    const distance = Math.hypot(event.clientX - this.down.at.x, event.clientY - this.down.at.y);
    if (distance > DRAG_FROM_PX) this.down.moved = true;
    const picture = this.pictureSize();
    if (!this.down.moved || !picture || this.isFree) return;
    const shown = containedBox(this.box(), picture);
    const x = clamp((event.clientX - this.box().left - shown.x) / shown.width, 0, 1);
    const y = clamp((event.clientY - this.box().top - shown.y) / shown.height, 0, 1);
    this.hideReadout();
    this.onHole(x, y);
    this.showRing(x, y);
  }

  private release(event: PointerEvent): void {
    const down = this.down;
    this.end();
    const point = this.pointOf(event);
    if (!down || down.moved || !point) return;
    if (this.onTap) {
      this.onTap(point);
      return;
    }
    if (!this.isFree && this.endsDoubleTap(event)) {
      this.hideReadout();
      this.onHole(0.5, 0.5);
    } else {
      this.onTouch(point);
    }
  }

  /** Two quick taps on two places are two questions, no double tap. */
  private endsDoubleTap(event: PointerEvent): boolean {
    const last = this.lastTap;
    const is = last !== undefined && event.timeStamp - last.time_ms < DOUBLE_TAP_MS
      && Math.hypot(event.clientX - last.at.x, event.clientY - last.at.y) < DOUBLE_TAP_PX;
    this.lastTap = is ? undefined : { at: { x: event.clientX, y: event.clientY }, time_ms: event.timeStamp };
    return is;
  }

  private end(): void {
    this.down = undefined;
    this.ring.hidden = true;
  }

  /** Where the hole goes, at once: the video follows a little later. */
  private showRing(x: number, y: number): void {
    const picture = this.pictureSize();
    const radius = this.view()?.hole_radius ?? 0;
    if (!picture || radius <= 0 || radius >= 2) return;
    const shown = containedBox(this.box(), picture);
    const size = 2 * radius * shown.height;
    this.ring.hidden = false;
    Object.assign(this.ring.style, {
      left: `${shown.x + x * shown.width - size / 2}px`,
      top: `${shown.y + y * shown.height - size / 2}px`,
      width: `${size}px`,
      height: `${size}px`,
    });
  }
}

export function mark(at: Point, label: string, color: string): HTMLElement {
  const element = h('div', { class: 'mark' }, h('span', {}, label));
  element.style.left = `${at.x}px`;
  element.style.top = `${at.y}px`;
  element.style.setProperty('--color', color);
  return element;
}
