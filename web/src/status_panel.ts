// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { Status } from './api';
import { h, setClass, setText } from './dom';
import { icon } from './icons';
import type { LiveVideo } from './live_video';
import { calibrationText, milliseconds, millimetres, stateWords, type ShownState } from './status_text';

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
  readonly state = h('div', { class: 'state', role: 'status', 'aria-live': 'polite' });
  readonly element: HTMLElement;

  private shownState: ShownState | undefined;
  private readonly words = h('span');
  private readonly bound = new Tile('Error, 95 % below', 'mm');
  private readonly residual = new Tile('Residual', 'mm');
  private readonly explained = new Tile('Body in place', '%');
  private readonly rate = new Tile('Frame rate', '/s');
  private readonly latency = new Tile('Latency', 'ms');
  private readonly counts = h('span');
  private readonly stages = h('span');
  private readonly calibration = h('span', { class: 'calibration' });
  private readonly calibrationHint = h('span', { class: 'calibration-hint' });

  constructor() {
    this.element = h('section', { class: 'figures', 'aria-label': 'Figures' },
      h('div', { class: 'tiles' },
        ...[this.bound, this.residual, this.explained, this.rate, this.latency].map(
          (tile) => tile.element)),
      h('div', { class: 'counts' }, this.counts, this.stages, this.calibration, this.calibrationHint));
    this.showState('unknown', undefined);
  }

  /** @param isWaitedFor  There is no camera yet. */
  show(status: Status | undefined, live: LiveVideo, isWaitedFor = false): void {
    this.rate.show(live.frameRate().toFixed(0));
    this.latency.show(milliseconds(live.latencyMs()));
    this.showState(status?.state ?? (isWaitedFor ? 'waiting' : 'unknown'), status);
    if (!status) {
      // What was true a while ago is no longer known.
      for (const tile of [this.bound, this.residual, this.explained]) tile.show('–');
      setText(this.counts, '');
      setText(this.stages, '');
      setText(this.calibration, '');
      setText(this.calibrationHint, '');
      return;
    }
    this.bound.show(millimetres(status.bound_mm));
    this.residual.show(millimetres(status.rms_distance_mm));
    const share = status.explained_fraction;
    this.explained.show(share === null ? '–' : (share * 100).toFixed(0));
    const { tracked, uncertain, lost, dropped } = status.frames;
    const stages = Object.entries(status.stage_ms)
      .map(([name, ms]) => `${name} ${ms.toFixed(0)}`)
      .join(' · ');
    setText(this.counts, `Frames: ${tracked} tracked · ${uncertain} uncertain · ${dropped} dropped · lost ${lost} times`);
    setText(this.stages, `ms: ${stages}`);
    setText(this.calibration, calibrationText(status.calibration));
    setText(this.calibrationHint, status.calibration.hint ?? '');
    // For those who want to know more than the picture's words say.
    this.element.title = status.search?.reason ?? '';
  }

  private showState(state: ShownState, status: Status | undefined): void {
    setText(this.words, stateWords(state, status));
    if (state === this.shownState) return;
    this.shownState = state;
    setClass(this.state, `state ${state}`);
    this.state.replaceChildren(icon(state), this.words);
  }
}
