// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { h, setText } from './dom';
import { icon, type IconName } from './icons';

export function button(
  label: string,
  name: IconName | undefined,
  onPress: () => void,
  style = '',
): HTMLButtonElement {
  const parts = name ? [icon(name), h('span', {}, label)] : [h('span', {}, label)];
  return h('button', { type: 'button', class: `key ${style}`, onclick: onPress }, ...parts);
}

/** A button without a word on it; the word is still there for a screen reader. */
export function iconButton(label: string, name: IconName, onPress: () => void): HTMLButtonElement {
  return h('button',
    { type: 'button', class: 'key square', 'aria-label': label, title: label, onclick: onPress },
    icon(name));
}

export interface Slider {
  element: HTMLElement;
  /** Shows what the server has, unless a finger is on it. */
  show(value: number): void;
}

export function slider(
  label: string,
  range: { min: number; max: number; step: number },
  text: (value: number) => string,
  onChange: (value: number) => void,
): Slider {
  const input = h('input', { type: 'range', 'aria-label': label, ...range });
  const shown = h('span', { class: 'value', 'aria-hidden': 'true' });
  let held = false;
  const paint = (): void => {
    const value = Number(input.value);
    setText(shown, text(value));
    input.setAttribute('aria-valuetext', text(value));
    const share = ((value - range.min) / (range.max - range.min)) * 100;
    input.style.setProperty('--share', `${share}%`);
  };
  input.addEventListener('input', () => {
    paint();
    onChange(Number(input.value));
  });
  input.addEventListener('pointerdown', () => (held = true));
  for (const end of ['pointerup', 'pointercancel', 'blur']) {
    input.addEventListener(end, () => (held = false));
  }
  const element = h('label', { class: 'slider' },
    h('span', { class: 'label-row' }, h('span', {}, label), shown), input);
  return {
    element,
    show(value) {
      if (held || Number(input.value) === value) return;
      input.value = String(value);
      paint();
    },
  };
}

export interface Choice<T extends string> {
  element: HTMLElement;
  show(value: T): void;
}

export function choice<T extends string>(
  label: string,
  options: readonly (readonly [T, string])[],
  onChange: (value: T) => void,
): Choice<T> {
  const keys = options.map(([value, word]) => {
    const key = h('button', { type: 'button', class: 'key', 'data-value': value }, word);
    key.addEventListener('click', () => {
      show(value);
      onChange(value);
    });
    return key;
  });
  const show = (value: T): void => {
    for (const key of keys) {
      key.setAttribute('aria-pressed', String(key.dataset['value'] === value));
    }
  };
  const element = h('div', { class: 'choice', role: 'group', 'aria-label': label },
    h('span', { class: 'caption' }, label), h('div', { class: 'choice-keys' }, ...keys));
  return { element, show };
}

/** Words at the lower edge for a few seconds: what went wrong, or what was done. */
export class Toast {
  readonly element = h('div', { class: 'toast', role: 'status', 'aria-live': 'polite', hidden: true });
  private timer: number | undefined;

  say(text: string, kind: 'good' | 'bad' = 'bad'): void {
    this.element.textContent = text;
    this.element.className = `toast ${kind}`;
    this.element.hidden = false;
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => (this.element.hidden = true), kind === 'bad' ? 6000 : 3000);
  }

  /** For promises of the API: shows the sentence with which they fail. */
  readonly sayError = (error: unknown): void => {
    this.say(error instanceof Error ? error.message : String(error));
  };
}
