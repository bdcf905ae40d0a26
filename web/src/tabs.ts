// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { h } from './dom';
import { icon, type IconName } from './icons';

const TABS = [
  ['look', 'Look', 'look'],
  ['surface', 'Surface', 'surface'],
  ['findings', 'Findings', 'findings'],
  ['take-away', 'Take away', 'takeAway'],
  ['sensor', 'Sensor', 'sensor'],
] as const satisfies readonly (readonly [string, string, IconName])[];

export type TabName = (typeof TABS)[number][0];

/** The rail's topics, one open at a time. A topic without a panel is not offered. */
export class Tabs {
  readonly keys = h('div', { class: 'tabs', role: 'tablist', 'aria-label': 'Topics' });
  readonly panels = h('div', { class: 'tab-panels' });

  private readonly all = new Map<TabName, { key: HTMLButtonElement; panel: HTMLElement }>();

  constructor(first: TabName) {
    for (const [name, word, drawing] of TABS) {
      const key = h('button',
        { type: 'button', class: 'tab', role: 'tab', id: `tab-${name}`, 'aria-controls': `panel-${name}`,
          hidden: true, onclick: () => this.open(name) },
        icon(drawing), h('span', {}, word));
      const panel = h('div',
        { class: 'tab-panel', role: 'tabpanel', id: `panel-${name}`, 'aria-labelledby': `tab-${name}` });
      this.all.set(name, { key, panel });
      this.keys.append(key);
      this.panels.append(panel);
    }
    this.open(first);
  }

  /** Puts a panel below what the topic has already. */
  add(name: TabName, panel: HTMLElement): void {
    const tab = this.all.get(name)!;
    tab.panel.append(panel);
    tab.key.hidden = false;
  }

  /** A dot on the topic's key: there is something new. */
  mark(name: TabName, on: boolean): void {
    this.all.get(name)!.key.classList.toggle('marked', on);
  }

  open(name: TabName): void {
    for (const [other, { key, panel }] of this.all) {
      key.setAttribute('aria-selected', String(other === name));
      panel.hidden = other !== name;
    }
    this.panels.scrollTop = 0;
  }
}
