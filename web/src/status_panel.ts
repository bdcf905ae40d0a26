// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { Status, TrackingState } from './api';
import { h, setClass, setText } from './dom';
import { icon } from './icons';
import type { LiveVideo } from './live_video';
import { milliseconds, millimetres, STATE_WORDS } from './status_text';

/** One figure with its unit and what it means. */
class Tile {
  private readonly number = h('span', { class: 'number' }, '–');
  readonly element: HTMLElement;

  constructor(label: string, unit = '') {
    this.element = h('div', { class: 'tile' },
      h('span', { class: 'caption' }, label),
      h('span', { class: 'figure' }, this.number, h('span', { class: 'unit' }, unit)));
  }

  show(text: string): void {
    setText(this.number, text);
  }
}

/** State by colour, sign and word, and the figures below the picture. */
export class StatusPanel {
  readonly state = h('div', { class: 'state waiting', role: 'status', 'aria-live': 'polite' });
  readonly element: HTMLElement;

  private shownState: TrackingState | undefined;
  private readonly residual = new Tile('Residual', 'mm');
  private readonly explained = new Tile('Body in place', '%');
  private readonly rate = new Tile('Frame rate', '/s');
  private readonly latency = new Tile('Latency', 'ms');
  private readonly dropped = new Tile('Dropped');
  private readonly counts = h('div', { class: 'counts' });

  constructor() {
    this.element = h('section', { class: 'figures', 'aria-label': 'Figures' },
      h('div', { class: 'tiles' },
        ...[this.residual, this.explained, this.rate, this.latency, this.dropped].map(
          (tile) => tile.element)),
      this.counts);
    this.showState('waiting');
  }

  show(status: Status | undefined, live: LiveVideo): void {
    this.rate.show(live.frameRate().toFixed(0));
    this.latency.show(milliseconds(live.latencyMs()));
    if (!status) return;
    this.showState(status.state);
    this.residual.show(millimetres(status.rms_distance_mm));
    const share = status.explained_fraction;
    this.explained.show(share === null ? '–' : (share * 100).toFixed(0));
    this.dropped.show(String(status.frames.dropped));
    const { tracked, skipped, lost } = status.frames;
    const stages = Object.entries(status.stage_ms)
      .map(([name, ms]) => `${name} ${ms.toFixed(0)}`)
      .join(' · ');
    setText(this.counts,
      `Frames: ${tracked} tracked · ${skipped} skipped · ${lost} lost    ms: ${stages}`);
  }

  private showState(state: TrackingState): void {
    if (state === this.shownState) return;
    this.shownState = state;
    setClass(this.state, `state ${state}`);
    this.state.replaceChildren(icon(state), h('span', {}, STATE_WORDS[state]));
  }
}
