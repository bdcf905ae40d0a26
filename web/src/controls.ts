// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { CaseInfo, Status, View } from './api';
import { h } from './dom';
import { icon } from './icons';
import { button, slider } from './widgets';

export interface ControlActions {
  startAutomatically(): void;
  startByPlacement(): void;
  startByLandmarks(): void;
  changeView(change: Partial<View>): void;
  freeze(frozen: boolean): void;
  snapshot(): void;
}

// The last step of the slider opens the hole over the whole picture.
const LARGEST_HOLE = 0.8;
const EVERYWHERE = 2;

export function holeOfSlider(value: number): number {
  return value >= 1 ? EVERYWHERE : value * LARGEST_HOLE;
}

export function sliderOfHole(radius: number): number {
  return radius > LARGEST_HOLE ? 1 : radius / LARGEST_HOLE;
}

function holeText(value: number): string {
  if (value <= 0) return 'closed';
  return value >= 1 ? 'all' : `${Math.round(holeOfSlider(value) * 100)} %`;
}

/** How the tracking starts and what is seen in the hole; and the keys that are always at hand. */
export class Controls {
  readonly element: HTMLElement;
  readonly keys: HTMLElement;

  private readonly opacity;
  private readonly hole;
  private readonly structures = h('div', { class: 'structures', role: 'group', 'aria-label': 'Shown inside' });
  private readonly freezeKey: HTMLButtonElement;
  private readonly startKeys: HTMLButtonElement[];
  private shown: Record<string, boolean> = {};
  private frozen = false;

  constructor(private readonly actions: ControlActions) {
    this.opacity = slider('Opacity', { min: 0, max: 1, step: 0.01 },
      (value) => `${Math.round(value * 100)} %`,
      (opacity) => actions.changeView({ opacity }));
    this.hole = slider('Hole', { min: 0, max: 1, step: 0.01 }, holeText,
      (value) => actions.changeView({ hole_radius: holeOfSlider(value) }));
    this.startKeys = [
      button('Automatic', 'automatic', () => actions.startAutomatically(), 'primary'),
      button('Placement', 'placement', () => actions.startByPlacement()),
      button('Landmarks', 'landmarks', () => actions.startByLandmarks()),
    ];
    this.freezeKey = button('Freeze', 'freeze', () => actions.freeze(!this.frozen));
    this.element = h('div', { class: 'controls' },
      section('Start', h('div', { class: 'pair starts' }, ...this.startKeys)),
      section('Inside view', this.opacity.element, this.hole.element, this.structures,
        h('p', { class: 'tip' }, 'Drag on the picture: moves the hole. Tap: error there. Double tap: hole to the centre.')));
    this.keys = h('div', { class: 'rail-keys', role: 'group', 'aria-label': 'Picture' }, this.freezeKey,
      button('Snapshot', 'snapshot', () => actions.snapshot()));
  }

  showCase(info: CaseInfo): void {
    this.structures.replaceChildren(...info.structures.map(({ name, color }) => {
      const key = h('button', { type: 'button', class: 'key toggle', 'data-name': name, 'aria-pressed': 'true' },
        h('span', { class: 'swatch' }), h('span', {}, name), icon('accept'));
      // Only a colour may come out of the server's words into a style.
      if (/^#[0-9a-f]{6}$/i.test(color)) key.style.setProperty('--color', color);
      key.addEventListener('click', () => {
        const on = !(this.shown[name] ?? true);
        this.shown = { ...this.shown, [name]: on };
        key.setAttribute('aria-pressed', String(on));
        this.actions.changeView({ structures: { [name]: on } });
      });
      return key;
    }));
  }

  showView(view: View): void {
    this.opacity.show(view.opacity);
    this.hole.show(Math.round(sliderOfHole(view.hole_radius) * 100) / 100);
    this.shown = { ...view.structures };
    for (const key of this.structures.querySelectorAll('button')) {
      key.setAttribute('aria-pressed', String(view.structures[key.dataset['name'] ?? ''] ?? true));
    }
  }

  showStatus(status: Status): void {
    // Once a start is found, starting again is no longer what the eye should fall on first.
    this.startKeys[0]?.classList.toggle('primary', status.state !== 'tracking');
    if (this.frozen === status.frozen) return;
    this.frozen = status.frozen;
    this.freezeKey.setAttribute('aria-pressed', String(status.frozen));
    this.freezeKey.replaceChildren(icon(status.frozen ? 'resume' : 'freeze'),
      h('span', {}, status.frozen ? 'Live again' : 'Freeze'));
  }
}

export function section(title: string, ...children: Node[]): HTMLElement {
  return h('section', { class: 'group' }, h('h2', {}, title), ...children);
}
