// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import './texture_panel.css';
import { api, textureSidesUrl, type TextureInfo } from './api';
import { section } from './controls';
import { h, setText } from './dom';
import { textureAdvice, textureSaved } from './texture_text';
import { button, type Toast } from './widgets';

const POLL_MS = 1000;
const SIDES = ['Front', 'Left', 'Back', 'Right'] as const;

/** The texture that is melted from many pictures: what it has, what it still lacks. */
export class TexturePanel {
  readonly element: HTMLElement;

  private info: TextureInfo | undefined;
  private shownVersion = -1;
  private readonly percent = h('strong', { class: 'texture-percent' }, '–');
  private readonly bar = h('div', { class: 'texture-bar-filled' });
  private readonly advice = h('p', { class: 'tip', role: 'status' });
  private readonly saved = h('p', { class: 'tip' });
  /** One picture in two rows: the rail is narrow. */
  private readonly rows = [h('div', { class: 'texture-row' }), h('div', { class: 'texture-row' })];
  private readonly recordKey: HTMLButtonElement;
  private readonly saveKey: HTMLButtonElement;
  private readonly againKey: HTMLButtonElement;

  constructor(private readonly toast: Toast) {
    this.recordKey = button('Record', undefined, () => void this.toggle(), 'primary');
    this.saveKey = button('Save into the case', undefined, () => void this.ask(api.saveTexture()));
    this.againKey = button('Start again', undefined, () => void this.startAgain());
    this.element = h('div', { class: 'controls texture' },
      section('Fused texture',
        h('div', { class: 'texture-head' }, this.percent, h('span', {}, 'of the skin recorded')),
        h('div', { class: 'texture-bar' }, this.bar),
        this.advice, this.recordKey,
        h('div', { class: 'texture-keys' }, this.saveKey, this.againKey), this.saved,
        h('figure', {
          class: 'texture-figure', role: 'img',
          'aria-label': 'The body from four sides; what was not recorded yet is striped',
        }, ...this.rows.flatMap((row, i) => [row, h('figcaption', {},
          ...SIDES.slice(2 * i, 2 * i + 2).map((side) => h('span', {}, side)))]))));
    this.show(undefined);
    setInterval(() => void this.poll(), POLL_MS);
  }

  show(info: TextureInfo | undefined): void {
    this.info = info;
    const isReady = info?.ready ?? false;
    const percent = Math.floor((info?.coverage ?? 0) * 100);
    setText(this.percent, isReady ? `${percent} %` : '–');
    this.bar.style.width = `${percent}%`;
    setText(this.recordKey, info?.recording ? 'Pause' : 'Record');
    this.recordKey.setAttribute('aria-pressed', String(info?.recording ?? false));
    this.recordKey.disabled = !isReady;
    const isEmpty = !info || info.frames === 0;
    this.saveKey.disabled = isEmpty || info.saving || info.saved;
    this.againKey.disabled = isEmpty;
    setText(this.advice, textureAdvice(info));
    setText(this.saved, textureSaved(info));
    if (info && info.version > 0 && info.version !== this.shownVersion) {
      this.shownVersion = info.version;
      for (const row of this.rows) {
        row.style.backgroundImage = `url("${textureSidesUrl(info.version)}")`;
      }
    }
  }

  private async poll(): Promise<void> {
    // Nobody looks: nothing is asked.
    if (this.element.offsetParent === null || document.hidden) return;
    try {
      this.show(await api.getTexture());
    } catch {
      this.show(undefined);
    }
  }

  private toggle(): Promise<void> {
    return this.ask(api.recordTexture(!(this.info?.recording ?? false)));
  }

  private async startAgain(): Promise<void> {
    const isLost = this.info !== undefined && !this.info.saved;
    if (isLost && !window.confirm('Forget what was recorded and not saved?')) return;
    await this.ask(api.clearTexture());
  }

  private async ask(request: Promise<unknown>): Promise<void> {
    try {
      await request;
      await this.poll();
    } catch (error) {
      this.toast.sayError(error);
    }
  }
}
