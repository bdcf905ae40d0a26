// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import './self_calibration_panel.css';
import type { TrackingState } from './api';
import { section } from './controls';
import { h, setText } from './dom';
import { selfCalibration, type CorrectionMap, type SelfCalibration } from './self_calibration_api';
import {
  appliedLine, headline, mapAt, mapColor, mapEnd, proposalLines,
} from './self_calibration_text';
import { button, type Toast } from './widgets';

const POLL_MS = 1000;
/** Nobody looks at the panel: only whether there is a proposal is asked for. */
const QUIET_POLLS = 5;
const SHOWN_HINTS = 2;
const MAP_WIDTH = 120;
const MAP_HEIGHT = 90;

/** The depth camera's error as it is found on the CT skin; nothing is changed without a yes. */
export class SelfCalibrationPanel {
  readonly element: HTMLElement;

  private state: SelfCalibration | undefined;
  private polls = 0;
  private busy = false;
  private shownMap = '';
  private readonly head = h('p', { class: 'sensor-head', role: 'status' });
  private readonly bar = h('div', { class: 'texture-bar-filled' });
  private readonly count = h('span');
  private readonly parts = h('div',
    { class: 'sensor-parts', role: 'img', 'aria-label': 'Where in the picture the body has been' });
  private readonly hints = h('ul', { class: 'sensor-hints' });
  private readonly gathering: HTMLElement;
  private readonly lines = h('div', { class: 'sensor-lines' });
  private readonly canvas = h('canvas', { width: MAP_WIDTH, height: MAP_HEIGHT, role: 'img',
    'aria-label': 'What is added to the depth over the picture' });
  private readonly legend = h('figcaption', {});
  private readonly map = h('figure', { class: 'sensor-map' }, this.canvas, this.legend);
  private readonly proposal: HTMLElement;
  private readonly appliedLine = h('p', { class: 'tip' });
  private readonly applied: HTMLElement;
  private readonly problem = h('p', { class: 'tip sensor-problem', role: 'alert' });
  private readonly again: HTMLButtonElement;
  private readonly keys: HTMLButtonElement[];

  /** @param mark  Shows or takes away a small sign that there is something to say yes or no to. */
  constructor(private readonly toast: Toast, private readonly mark: (on: boolean) => void) {
    const apply = button('Apply', 'accept',
      () => void this.ask(selfCalibration.apply(), 'Corrected.'), 'primary');
    const discard = button('Not now', undefined, () => void this.ask(selfCalibration.discard()));
    const undo = button('Undo the correction', 'undo',
      () => void this.ask(selfCalibration.undo(), 'As it was before.'));
    this.again = button('Check again', undefined, () => void this.ask(selfCalibration.again()));
    this.keys = [apply, discard, undo, this.again];
    for (let i = 0; i < 9; ++i) this.parts.append(h('span'));
    this.gathering = h('div', { class: 'sensor-gathering' },
      h('div', { class: 'texture-bar' }, this.bar), this.count,
      h('div', { class: 'sensor-motion' }, this.parts, this.hints));
    this.proposal = h('div', { class: 'sensor-proposal' }, this.lines,
      h('div', { class: 'sensor-keys' }, apply, discard),
      this.map);
    this.applied = h('div', { class: 'sensor-applied' }, this.appliedLine, undo);
    this.element = h('div', { class: 'controls sensor' },
      section('Depth camera', this.head, this.gathering, this.proposal, this.again,
        this.applied, this.problem));
    this.show(undefined, undefined);
    setInterval(() => void this.poll(), POLL_MS);
  }

  private tracking: TrackingState | undefined;

  showTracking(tracking: TrackingState | undefined): void {
    if (tracking === this.tracking) return;
    this.show(this.state, tracking);
  }

  show(state: SelfCalibration | undefined, tracking: TrackingState | undefined): void {
    this.state = state;
    this.tracking = tracking;
    this.mark(state?.phase === 'proposed');
    setText(this.head, state ? headline(state, tracking) : 'The server does not answer.');
    this.gathering.hidden = state?.phase !== 'gathering';
    this.proposal.hidden = state?.phase !== 'proposed';
    this.again.hidden = state?.phase !== 'resting';
    this.applied.hidden = !state?.applied;
    this.problem.hidden = !state?.problem;
    setText(this.problem, state?.problem ?? '');
    if (state?.phase === 'gathering') this.showGathering(state);
    if (state?.phase === 'proposed' && state.found) {
      this.lines.replaceChildren(
        ...proposalLines(state.found).map((line) => h('p', { class: 'tip' }, line)));
      this.map.hidden = !state.found.corrects_sensor;
      this.draw(state.found.map);
    }
    if (state?.applied) setText(this.appliedLine, appliedLine(state.applied, state.device));
  }

  private showGathering(state: SelfCalibration): void {
    this.bar.style.width = `${Math.min(100, (100 * state.views) / state.wanted_views)}%`;
    setText(this.count, `${state.views} of ${state.wanted_views} views in motion`);
    [...this.parts.children].forEach((part, i) =>
      part.classList.toggle('seen', (state.views_in_part[i] ?? 0) > 0));
    const words = state.missing.slice(0, SHOWN_HINTS);
    if ([...this.hints.children].map((hint) => hint.textContent).join() === words.join()) return;
    this.hints.replaceChildren(...words.map((word) => h('li', {}, word)));
  }

  private draw(map: CorrectionMap): void {
    const drawn = map.add_mm.join();
    if (drawn === this.shownMap) return;
    this.shownMap = drawn;
    const end = mapEnd(map);
    const context = this.canvas.getContext('2d');
    if (!context) return;
    const picture = context.createImageData(MAP_WIDTH, MAP_HEIGHT);
    for (let y = 0; y < MAP_HEIGHT; ++y) {
      for (let x = 0; x < MAP_WIDTH; ++x) {
        const add_mm = mapAt(map, x / (MAP_WIDTH - 1), y / (MAP_HEIGHT - 1));
        picture.data.set([...mapColor(add_mm / end), 255], 4 * (y * MAP_WIDTH + x));
      }
    }
    context.putImageData(picture, 0, 0);
    this.legend.replaceChildren(h('span', {}, `−${end}`), h('span', { class: 'sensor-scale' }),
      h('span', {}, `+${end} mm`));
  }

  private async poll(): Promise<void> {
    if (this.busy || document.hidden) return;
    this.polls += 1;
    if (this.element.offsetParent === null && this.polls % QUIET_POLLS !== 1) return;
    const state = await selfCalibration.get().catch(() => undefined);
    if (!this.busy) this.show(state, this.tracking);
  }

  private async ask(request: Promise<SelfCalibration>, done = ''): Promise<void> {
    this.busy = true;
    for (const key of this.keys) key.disabled = true;
    try {
      this.show(await request, this.tracking);
      if (done) this.toast.say(done, 'good');
    } catch (error) {
      this.toast.sayError(error);
    } finally {
      this.busy = false;
      for (const key of this.keys) key.disabled = false;
    }
  }
}
