// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { skinViewUrl, type SkinViewpoint } from './api';
import { h } from './dom';
import { clamp, type Point } from './geometry';
import { dragged, type CtPick } from './landmarks';
import { mark } from './stage';
import { iconButton } from './widgets';

const TAP_WITHIN_PX = 8;
const VIEWS: readonly (readonly [string, number, number])[] = [
  ['Front', 0, 0],
  ['Left', Math.PI / 2, 0],
  ['Right', -Math.PI / 2, 0],
  ['Head', 0, Math.PI / 2],
  ['Feet', 0, -Math.PI / 2],
];

/** The CT's skin, drawn by the server: a drag turns it, a tap is a point. */
export class SkinPane {
  readonly element: HTMLElement;
  onTap: ((viewpoint: SkinViewpoint, pixel: Point) => void) | undefined;

  private readonly image = h('img', { alt: 'Skin of the CT', draggable: 'false' });
  private readonly marks = h('div', { class: 'marks' });
  private readonly picture: HTMLElement;
  private wanted: SkinViewpoint = { yaw: 0, pitch: 0, zoom: 1, width: 480, height: 480 };
  private loaded: SkinViewpoint | undefined;
  private loading = false;
  private picks: { ct: CtPick; label: string; color: string }[] = [];
  private down: { at: Point; from: SkinViewpoint; moved: boolean } | undefined;

  constructor(private readonly onError: (error: unknown) => void) {
    this.picture = h('div', { class: 'skin' }, this.image, this.marks);
    this.element = h('div', { class: 'pane ct-pane' }, h('h2', {}, 'CT skin'), this.picture,
      h('div', { class: 'views' },
        ...VIEWS.map(([word, yaw, pitch]) =>
          h('button', { type: 'button', class: 'key', onclick: () => this.look({ yaw, pitch }) }, word)),
        iconButton('Smaller', 'minus', () => this.zoom(1 / 1.3)),
        iconButton('Larger', 'plus', () => this.zoom(1.3))));
    this.picture.addEventListener('pointerdown', (event) => this.press(event));
    this.picture.addEventListener('pointermove', (event) => this.move(event));
    this.picture.addEventListener('pointerup', (event) => this.release(event));
    this.picture.addEventListener('pointercancel', () => (this.down = undefined));
    this.picture.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.zoom(event.deltaY < 0 ? 1.1 : 1 / 1.1);
    }, { passive: false });
    new ResizeObserver(() => this.look({})).observe(this.picture);
  }

  showMarks(picks: { ct: CtPick; label: string; color: string }[]): void {
    this.picks = picks;
    this.paintMarks();
  }

  /** The same direction and size as then. */
  lookFrom({ yaw, pitch, zoom }: SkinViewpoint): void {
    this.look({ yaw, pitch, zoom });
  }

  private look(change: Partial<SkinViewpoint>): void {
    const { width, height } = this.picture.getBoundingClientRect();
    if (width < 16 || height < 16) return;
    this.wanted = { ...this.wanted, ...change, width: Math.round(width), height: Math.round(height) };
    if (!this.loading) void this.load();
  }

  private zoom(factor: number): void {
    this.look({ zoom: clamp(this.wanted.zoom * factor, 0.5, 8) });
  }

  /** One picture at a time; what was wanted meanwhile comes next. */
  private async load(): Promise<void> {
    this.loading = true;
    while (!same(this.wanted, this.loaded)) {
      const viewpoint = this.wanted;
      try {
        const next = new Image();
        next.src = skinViewUrl(viewpoint);
        await next.decode();
        this.image.src = next.src;
        this.image.dataset['ready'] = 'true';
      } catch {
        this.onError(new Error('The server cannot draw the CT skin.'));
        break;
      }
      this.loaded = viewpoint;
      this.paintMarks();
    }
    this.loading = false;
  }

  /** A point is drawn in the view in which it was tapped; in another one it would be wrong. */
  private paintMarks(): void {
    const loaded = this.loaded;
    this.marks.replaceChildren(
      ...this.picks
        .filter(({ ct }) => same(ct.viewpoint, loaded))
        .map(({ ct, label, color }) => mark(ct.pixel, label, color)));
  }

  private press(event: PointerEvent): void {
    if (!event.isPrimary) return;
    this.picture.setPointerCapture(event.pointerId);
    this.down = { at: { x: event.clientX, y: event.clientY }, from: this.wanted, moved: false };
  }

  private move(event: PointerEvent): void {
    if (!this.down) return;
    const dx = event.clientX - this.down.at.x;
    const dy = event.clientY - this.down.at.y;
    if (Math.hypot(dx, dy) > TAP_WITHIN_PX) this.down.moved = true;
    if (!this.down.moved) return;
    const { yaw, pitch } = dragged(this.down.from, dx, dy);
    this.look({ yaw, pitch });
  }

  private release(event: PointerEvent): void {
    const down = this.down;
    this.down = undefined;
    if (!down || down.moved || !this.loaded) return;
    const box = this.picture.getBoundingClientRect();
    this.onTap?.(this.loaded, { x: event.clientX - box.left, y: event.clientY - box.top });
  }
}

function same(a: SkinViewpoint, b: SkinViewpoint | undefined): boolean {
  return b !== undefined && a.yaw === b.yaw && a.pitch === b.pitch && a.zoom === b.zoom &&
    a.width === b.width && a.height === b.height;
}
