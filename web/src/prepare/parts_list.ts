// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { h } from '../dom';
import type { Check, Decision, Doubt, Part, Plane, TakeOff } from './api';
import { doubtText, doubtTitle, placeText, sizeText } from './part_text';

/** What was cut off and what stands out, with a switch each, and where the skin is not certain. */
export class PartsList {
  readonly element = h('div', { class: 'parts' });
  private version = -1;

  constructor(private readonly onDecision: (decision: Decision | TakeOff) => void,
    private readonly onLook: (at: Record<Plane, number>) => void) {}

  show(check: Check): void {
    if (check.version === this.version) return;
    this.version = check.version;
    const rows = check.parts.map((part, i) => ({ part, row: this.row(part, i) }));
    const group = (title: string, tip: string, stands_out: boolean): HTMLElement[] => {
      const some = rows.filter(({ part }) => part.stands_out === stands_out).map(({ row }) => row);
      return [h('h2', {}, title), ...(some.length > 0 ? some : [h('p', { class: 'tip' }, tip)])];
    };
    const focus = document.activeElement?.getAttribute('data-part');
    this.element.replaceChildren(
      ...group('Cut off', 'Nothing of 1 ml or more lies beside the body.', false),
      ...group('Standing out, kept', 'Nothing stands out from the body.', true),
      ...this.doubtRows(check.doubts));
    if (focus) this.element.querySelector<HTMLElement>(`[data-part="${focus}"]`)?.focus();
  }

  /** One decision at a time: the list may be another one after it. */
  enable(on: boolean): void {
    for (const key of this.element.querySelectorAll<HTMLButtonElement>('.switch, .take-off')) key.disabled = !on;
  }

  private doubtRows(doubts: Doubt[]): HTMLElement[] {
    if (doubts.length === 0) return [];
    return [h('h2', {}, 'Skin that is not certain'),
      h('p', { class: 'tip' }, 'Orange in the pictures. Look whether the outline follows the skin there. A layer that ',
        'was taken off is in the list above: its switch puts it back. Where one was left and you see it, take it off.'),
      ...doubts.map((doubt, i) => h('div', { class: 'part doubt' }, h('span', { class: 'swatch' }),
        h('button', { type: 'button', class: 'what', title: 'Show the slices through it',
          onclick: () => this.onLook(doubt.at) }, h('b', {}, doubtTitle(doubt)), h('span', {}, doubtText(doubt))),
        ...this.takeOffKey(doubt, i)))];
  }

  private takeOffKey(doubt: Doubt, index: number): HTMLElement[] {
    const off = doubt.why === 'layer_left';
    if (!off && doubt.why !== 'taken_off') return [];
    return [h('button', { type: 'button', class: 'take-off', 'data-part': `doubt-${index}`,
      title: off ? `Take off up to ${doubt.up_to_mm.toFixed(1)} mm there` : 'As it was found',
      onclick: () => {
        this.enable(false);
        this.onDecision({ doubt: index, take_off: off, version: this.version });
      },
    }, off ? 'Take off' : 'Put back')];
  }

  private row(part: Part, index: number): HTMLElement {
    const word = part.kept ? 'Kept' : 'Cut';
    const key = h('button', {
      type: 'button', class: `switch ${part.kept ? 'on' : ''}`, role: 'switch', 'data-part': index,
      'aria-checked': String(part.kept), 'aria-label': `Keep what is ${placeText(part).toLowerCase()}`,
      onclick: () => {
        this.enable(false);
        this.onDecision({ part: index, keep: !part.kept, version: this.version });
      },
    }, h('span', { class: 'knob' }), h('span', { class: 'word' }, word));
    const look = h('button', { type: 'button', class: 'what', title: 'Show the slices through it',
      onclick: () => this.onLook(part.at) }, h('b', {}, placeText(part)), h('span', {}, sizeText(part)));
    const row = h('div', { class: 'part' }, h('span', { class: 'swatch' }), look, key);
    row.style.setProperty('--color', part.color);
    return row;
  }
}
