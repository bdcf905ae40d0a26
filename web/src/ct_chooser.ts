// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { h } from './dom';
import { sentenceOf } from './server_error';

interface Cts {
  names: string[];
  /** Empty: the case's first. */
  shown: string;
}

const RETRY_MS = 400;
const GIVE_UP_MS = 30000;

async function getCts(): Promise<Cts> {
  const response = await fetch('/api/cts');
  if (!response.ok) throw new Error(sentenceOf(await response.text()));
  return (await response.json()) as Cts;
}

/** Of a case with several CTs: which one is shown. There is nothing to see where it has only one. */
export class CtChooser {
  readonly element = h('label', { class: 'ct-chooser', hidden: true });

  constructor(private readonly onProblem: (error: unknown) => void) {}

  async load(): Promise<void> {
    const cts = await getCts().catch(() => undefined);
    if (!cts || cts.names.length === 0) return;
    const options = ['', ...cts.names].map((name) =>
      h('option', { value: name, selected: name === cts.shown }, name === '' ? 'First CT' : name));
    const select = h('select', { 'aria-label': 'CT' }, ...options);
    select.addEventListener('change', () => void this.choose(select, cts.shown));
    this.element.replaceChildren(h('span', {}, 'CT'), select);
    this.element.hidden = false;
  }

  private async choose(select: HTMLSelectElement, shown: string): Promise<void> {
    select.disabled = true;
    try {
      const name = select.value;
      const response = await fetch('/api/cts/choose', { method: 'POST', body: JSON.stringify({ name }) });
      if (!response.ok) throw new Error(sentenceOf(await response.text()));
      await this.waitFor(name);
      window.location.reload();
    } catch (error) {
      select.value = shown;
      select.disabled = false;
      this.onProblem(error);
    }
  }

  /** The server begins anew with the other CT. */
  private async waitFor(name: string): Promise<void> {
    const until = performance.now() + GIVE_UP_MS;
    while (performance.now() < until) {
      await new Promise((resolve) => setTimeout(resolve, RETRY_MS));
      const cts = await getCts().catch(() => undefined);
      if (cts?.shown === name) return;
    }
    throw new Error('The other CT does not come: see what the program says.');
  }
}
