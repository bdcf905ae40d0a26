// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { Waiting } from '../api';
import { h, setText } from '../dom';
import { LiveVideo } from '../live_video';
import { sentenceOf } from '../server_error';
import { waitingBanner } from '../status_text';
import { hintOf, hintPicture, partOf } from './hint';
import { countOf, shareOf } from './progress';
import { asSentence } from './sentence';

interface Figure {
  name: string;
  value: string;
}

export interface CalibrationState {
  board: string;
  device: string;
  say: string;
  sees_board: boolean;
  camera_error: string;
  has_infrared: boolean;
  views: number;
  wanted_views: number;
  views_on_wall: number;
  wanted_on_wall: number;
  parts: number[];
  missing: string[];
  solving: boolean;
  problem: string;
  kept: string;
  in_use?: string;
  result?: { figures: Figure[]; remarks: string[]; check?: Figure[] };
}

const SHOWN_HINTS = 3;

/** The one thing to do now. */
function nowOf(state: CalibrationState, isEnough: boolean): string {
  if (state.solving) return 'Calculating: this takes some seconds';
  if (state.kept) return 'Kept: from now on this camera is used with it';
  if (state.result) return 'Look at the figures, then keep it';
  return isEnough ? 'That is enough: calculate' : state.say;
}


/** Holding a printed board before the camera until the server has seen enough of it. */
export class CalibratePage {
  readonly live: LiveVideo;
  status: CalibrationState | undefined;

  private readonly main = h('main', { class: 'calibrate' });
  private readonly say = h('p', { class: 'say', 'aria-live': 'polite' });
  private readonly count = h('p', { class: 'count' });
  private readonly bar = h('progress', { class: 'bar', max: 1 });
  private readonly hints = h('ul', { class: 'hints' });
  private readonly grid = h('div', { class: 'grid', 'aria-hidden': 'true' });
  private readonly device = h('p', { class: 'device' });
  private readonly outcome = h('section', { class: 'outcome', hidden: true });
  private readonly error = h('p', { class: 'error', role: 'alert', hidden: true });
  private readonly take = this.key('Take this view', 'take');
  private readonly drop = this.key('Undo the last', 'drop');
  private readonly solve = this.key('Calculate', 'solve');
  private readonly save = this.key('Keep it', 'save');
  private readonly restart = this.key('Begin again', 'restart');
  private isWaiting = false;
  private shownHints = '';
  private shownResult = '';

  constructor(root: HTMLElement) {
    const video = h('video', { muted: true, playsinline: true, autoplay: true });
    this.live = new LiveVideo(video);
    for (let i = 0; i < 9; ++i) this.grid.append(h('span'));
    this.solve.classList.add('main');
    this.save.classList.add('main');
    this.main.append(
      h('header', { class: 'head' }, h('h1', {}, 'Calibrate the camera'), this.device),
      h('div', { class: 'view' }, video, this.grid),
      h('aside', { class: 'side' },
        h('div', { class: 'now' }, this.say, this.error),
        h('div', { class: 'progress' }, this.count, this.bar),
        this.hints,
        this.outcome,
        h('div', { class: 'keys' }, this.take, this.drop, this.solve, this.save, this.restart)));
    root.append(this.main);
  }

  start(): void {
    void this.live.connect();
    const events = new EventSource('/api/events');
    events.addEventListener('status', (event) => {
      const state = JSON.parse((event as MessageEvent<string>).data) as CalibrationState | Waiting;
      if ('waiting_for_camera' in state) {
        this.showWaiting(state);
      } else if (this.isWaiting) {
        window.location.reload();
      } else {
        this.show(state);
      }
    });
  }

  private showWaiting(waiting: Waiting): void {
    this.isWaiting = true;
    this.main.classList.add('no-camera');
    setText(this.say, waitingBanner(waiting).text);
  }

  private key(words: string, action: string): HTMLButtonElement {
    return h('button', {
      class: `key ${action}`,
      type: 'button',
      onclick: () => void this.send('POST', `/api/calibration/${action}`),
    }, words);
  }

  private async send(method: string, path: string): Promise<void> {
    try {
      const response = await fetch(path, { method });
      const text = await response.text();
      if (!response.ok) throw new Error(sentenceOf(text));
      this.complain('');
      const state = JSON.parse(text) as CalibrationState;
      if (state.board !== undefined) this.show(state);
    } catch (error) {
      this.complain(error instanceof TypeError ? 'The server does not answer.' : (error as Error).message);
    }
  }

  private complain(words: string): void {
    setText(this.error, asSentence(words));
    this.error.hidden = words === '';
  }

  private show(state: CalibrationState): void {
    this.status = state;
    const kept = state.in_use ? `in use: ${state.in_use}` : 'not calibrated so far';
    setText(this.device, `${state.device || 'a device without a number'}: ${kept}. Board ${state.board}`);
    const enough = state.views > 0 && state.missing.length === 0;
    setText(this.say, asSentence(state.camera_error || nowOf(state, enough)));
    setText(this.count, countOf(state));
    this.bar.value = shareOf(state);
    this.showParts(state.parts);
    this.showHints(state.result ? [] : state.missing.slice(0, SHOWN_HINTS));
    this.showOutcome(state);
    this.main.classList.toggle('has-result', state.result !== undefined);
    this.drop.disabled = state.views === 0 || state.solving;
    this.solve.hidden = state.result !== undefined;
    this.solve.disabled = state.views < 8 || state.solving;
    this.solve.classList.toggle('ready', enough);
    this.save.hidden = state.result === undefined;
    this.save.disabled = state.kept !== '';
    setText(this.save, state.kept ? 'Kept' : 'Keep it');
    this.take.hidden = state.result !== undefined;
    this.take.disabled = !state.sees_board || state.solving;
  }

  private showParts(parts: number[]): void {
    [...this.grid.children].forEach((cell, i) => {
      cell.classList.toggle('done', (parts[i] ?? 0) > 0);
    });
  }

  private showHints(missing: string[]): void {
    const key = missing.join('\n');
    if (key === this.shownHints) return;
    this.shownHints = key;
    this.hints.replaceChildren(
      ...missing.map((sentence) => h('li', {}, hintPicture(hintOf(sentence), partOf(sentence)), h('span', {}, asSentence(sentence)))));
  }

  private showOutcome(state: CalibrationState): void {
    const key = JSON.stringify([state.result, state.problem]);
    if (key === this.shownResult) return;
    this.shownResult = key;
    this.outcome.hidden = !state.result && !state.problem;
    this.outcome.replaceChildren();
    if (state.problem) {
      this.outcome.append(h('h2', { class: 'bad' }, 'It cannot be calculated yet'), h('p', {}, asSentence(state.problem)));
    }
    if (!state.result) return;
    const verdict = state.result.check?.find((figure) => figure.name === 'state')?.value ?? '';
    this.outcome.append(h('h2', {}, verdict === 'good' ? 'The calibration is good' : asSentence(verdict) || 'Calculated'));
    for (const remark of state.result.remarks) this.outcome.append(h('p', {}, remark));
    const rows = [...(state.result.check ?? []).filter((figure) => figure.name !== 'state'), ...state.result.figures];
    this.outcome.append(
      h('dl', {}, ...rows.flatMap(({ name, value }) => [h('dt', {}, asSentence(name).slice(0, -1)), h('dd', {}, value.replaceAll('+-', '±'))])));
  }
}
