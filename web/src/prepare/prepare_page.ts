// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { h, setText } from '../dom';
import { button, slider, Toast } from '../widgets';
import { api, type Check, type Decision, type Settings, type TakeOff } from './api';
import { BodyPane } from './body_pane';
import { Latest } from './latest';
import { volumeText } from './part_text';
import { PartsList } from './parts_list';
import { SlicePane } from './slice_pane';

const POLL_MS = 400;
const THRESHOLD_HU = { min: -900, max: 200, step: 10 };
const CLOSING_MM = { min: 0, max: 10, step: 0.5 };

/** The whole page: what would be taken for the body, to be corrected and then used. */
export class PreparePage {
  readonly element: HTMLElement;
  private check: Check | undefined;
  private readonly toast = new Toast();
  private readonly problem = this.toast.sayError;
  private readonly slices = (['axial', 'coronal', 'sagittal'] as const).map(
    (plane) => new SlicePane(plane, this.problem));
  private readonly body = new BodyPane(this.problem);
  private readonly parts = new PartsList(
    (decision) => void this.change(decision).then(() => this.parts.enable(true)),
    (at) => this.slices.forEach((pane) => pane.goTo(at[pane.plane])));
  private readonly threshold = slider('Threshold', THRESHOLD_HU, (hu) => `${hu} HU`,
    (threshold_hu) => this.set({ threshold_hu }));
  private readonly closing = slider('Closing', CLOSING_MM, (mm) => `${mm} mm`,
    (closing_mm) => this.set({ closing_mm }));
  private wanted: Settings = {};
  private readonly sending = new Latest<void>(() => {
    const settings = this.wanted;
    this.wanted = {};
    return this.change(settings);
  });
  private readonly title = h('span', { class: 'case-name' });
  private readonly size = h('span');
  private readonly useKey = button('Use it', 'accept', () => this.use(), 'primary');
  private readonly cancelKey = button('Cancel', 'cancel', () => this.cancel());
  private readonly end = h('div', { class: 'end', role: 'status', hidden: true });
  readonly inspection: { readonly check: Check | undefined; readonly isBusy: boolean };

  constructor() {
    this.element = h('main', { class: 'app check' },
      h('header', { class: 'top' }, h('h1', {}, 'Morgagni'), this.title,
        h('span', { class: 'notice' }, 'Not a medical device')),
      h('div', { class: 'panes' }, ...this.slices.map((pane) => pane.element), this.body.element),
      h('aside', { class: 'rail' },
        h('div', { class: 'settings' },
          h('p', { class: 'tip' }, h('span', { class: 'outline' }),
            'The green line becomes the skin; it is orange where that is not certain. What is coloured beside it is ',
            'cut off. ', this.size),
          h('div', { class: 'sliders' }, this.threshold.element, this.closing.element),
          this.parts.element),
        h('div', { class: 'pair-row' }, this.cancelKey, this.useKey)),
      this.end, this.toast.element);
    const self = this;
    this.inspection = {
      get check() {
        return self.check;
      },
      get isBusy() {
        return self.sending.isBusy;
      },
    };
  }

  start(): void {
    void api.state().then((check) => this.show(check)).catch((error: unknown) => {
      this.problem(error);
      setTimeout(() => this.start(), 2000);
    });
  }

  private set(settings: Settings): void {
    this.wanted = { ...this.wanted, ...settings };
    this.sending.ask();
  }

  private async change(change: Settings | Decision | TakeOff): Promise<void> {
    try {
      this.show(await api.change(change));
    } catch (error) {
      this.problem(error);
      if (this.check) this.showSettings(this.check);
    }
  }

  private show(check: Check): void {
    const isNew = check.version !== this.check?.version;
    this.check = check;
    setText(this.title, `Check the skin of ${check.title}`);
    this.showSettings(check);
    if (isNew) {
      this.parts.show(check);
      for (const pane of this.slices) pane.show(check);
      this.body.show(check);
    }
    this.showEnd(check);
  }

  private showSettings(check: Check): void {
    this.threshold.show(check.threshold_hu);
    this.closing.show(check.closing_mm);
    setText(this.size, `The body has ${volumeText(check.body_ml)}.`);
  }

  private showEnd(check: Check): void {
    const words = endText(check);
    this.end.hidden = words === undefined;
    this.end.className = `end ${check.state}`;
    if (words) this.end.replaceChildren(h('b', {}, words.title), h('p', {}, words.text), progressBar(check));
    if (check.state === 'failed' && check.error) this.toast.say(check.error);
    if (check.state === 'preparing') setTimeout(() => this.start(), POLL_MS);
  }

  private use(): void {
    void api.use().then((check) => this.show(check)).catch(this.problem);
  }

  private cancel(): void {
    void api.cancel().then((check) => this.show(check)).catch(this.problem);
  }
}

function endText({ state, step, title }: Check): { title: string; text: string } | undefined {
  if (state === 'preparing') return { title: 'The case is being made', text: `${step} …` };
  if (state === 'done') {
    return { title: 'The case is made',
      text: `Show it with: morgagni serve --case ${title}. This page can be closed.` };
  }
  if (state === 'cancelled') return { title: 'Cancelled', text: 'Nothing was made. This page can be closed.' };
  return undefined;
}

function progressBar({ state, fraction }: Check): HTMLElement {
  const bar = h('progress', { max: 1, value: fraction });
  bar.hidden = state !== 'preparing';
  return bar;
}
