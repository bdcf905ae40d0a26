// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { api, documentUrl, type Documents } from './api';
import { section } from './controls';
import { h, setText } from './dom';
import './documents_panel.css';
import { icon } from './icons';
import { button, choice, slider, type Toast } from './widgets';

const REFRESH_MS = 500;
const KINDS: readonly (readonly [string, string, string[]])[] = [
  ['Viewer for any browser', 'one file, without network', ['viewer']],
  ['Report', 'PDF', ['pdf']],
  ['Models', 'GLB, OBJ, PLY, STL', ['glb', 'obj', 'ply', 'stl']],
  ['To print', '3MF in colours', ['3mf']],
];
const WORDS: Record<string, string> = {
  'viewer.html': 'Viewer', 'report.pdf': 'Report', 'model.glb': 'Model (GLB)', 'model.obj': 'Model (OBJ)',
  'skin-print.3mf': 'Skin to print (3MF)', 'skin-print.stl': 'Skin to print (STL)',
  'structures.3mf': 'Structures (3MF)', 'manifest.json': 'Manifest with hashes',
};

export function sizeWords(bytes: number): string {
  return bytes >= 1e6 ? `${(bytes / 1e6).toFixed(1)} MB` : `${Math.max(1, Math.round(bytes / 1e3))} kB`;
}

/** Models, viewer and report of the case: asked for here, made by the server, downloaded here. */
export class DocumentsPanel {
  readonly element: HTMLElement;

  private readonly chosen = new Set(KINDS.flatMap(([, , formats]) => formats));
  private print: 'filled' | 'shell' = 'filled';
  private wall_mm = 3;
  private busy = false;
  private readonly author = h('input',
    { type: 'text', class: 'author', maxlength: 80, placeholder: 'Your name', 'aria-label': 'Your name, for the report' });
  private readonly makeKey: HTMLButtonElement;
  private readonly stopKey = button('Stop', 'cancel', () => void this.stop());
  private readonly bar = h('progress', { max: 1, value: 0, 'aria-label': 'Progress' });
  private readonly stage = h('span', { class: 'tip' });
  private readonly work = h('div', { class: 'making', hidden: true }, this.bar, this.stage);
  private readonly files = h('div', { class: 'files' });
  private readonly remarks = h('div', { class: 'remarks' });
  private shownFolder: string | null = null;

  constructor(private readonly toast: Toast) {
    const wall = slider('Wall', { min: 1, max: 10, step: 0.5 }, (value) => `${value.toFixed(1)} mm`,
      (value) => (this.wall_mm = value));
    wall.show(this.wall_mm);
    wall.element.hidden = true;
    const form = choice('Skin to print', [['filled', 'Filled'], ['shell', 'Shell']] as const, (value) => {
      this.print = value;
      wall.element.hidden = value !== 'shell';
    });
    form.show(this.print);
    this.makeKey = button('Make documents', 'takeAway', () => void this.make(), 'primary');
    this.stopKey.hidden = true;
    this.element = section('Documents', ...KINDS.map((kind) => this.kindKey(kind)),
      form.element, wall.element, this.author, this.makeKey, this.stopKey, this.work, this.files, this.remarks);
    this.element.classList.add('documents');
    setInterval(() => void this.refresh(), REFRESH_MS);
  }

  private kindKey([label, detail, formats]: readonly [string, string, string[]]): HTMLElement {
    const key = h('button', { type: 'button', class: 'key toggle', 'aria-pressed': 'true' },
      h('span', { class: 'kind' }, label, h('small', {}, detail)), icon('accept'));
    key.addEventListener('click', () => {
      const on = key.getAttribute('aria-pressed') !== 'true';
      key.setAttribute('aria-pressed', String(on));
      for (const format of formats) {
        if (on) this.chosen.add(format);
        else this.chosen.delete(format);
      }
      this.makeKey.disabled = this.chosen.size === 0;
    });
    return key;
  }

  private async make(): Promise<void> {
    try {
      this.show(await api.makeDocuments({
        formats: [...this.chosen], print: this.print, wall_mm: this.wall_mm, author: this.author.value.trim(),
      }));
    } catch (error) {
      this.toast.sayError(error);
    }
  }

  private async stop(): Promise<void> {
    await api.stopDocuments().catch(this.toast.sayError);
  }

  /** Another tablet may have begun it. */
  private async refresh(): Promise<void> {
    const isRunning = !this.stopKey.hidden;
    if (this.busy || (this.element.offsetParent === null && !isRunning)) return;
    this.busy = true;
    const documents = await api.documents().catch(() => undefined);
    this.busy = false;
    if (documents) this.show(documents);
  }

  private show(documents: Documents): void {
    const wasRunning = !this.stopKey.hidden;
    const isRunning = documents.state === 'running';
    this.makeKey.hidden = isRunning;
    this.stopKey.hidden = !isRunning;
    this.work.hidden = !isRunning;
    this.bar.value = documents.fraction;
    setText(this.stage, documents.stage);
    if (wasRunning && documents.state === 'failed') this.toast.say(documents.error ?? 'Failed.');
    if (wasRunning && documents.state === 'done') this.toast.say('The documents are made.', 'good');
    if (documents.folder !== this.shownFolder) this.showFiles(documents);
  }

  private showFiles(documents: Documents): void {
    this.shownFolder = documents.folder;
    // What people open first stands first.
    const order = Object.keys(WORDS);
    const rank = (name: string): number => (name in WORDS ? order.indexOf(name) : order.length);
    const files = [...documents.files].sort((a, b) => rank(a.name) - rank(b.name));
    this.files.replaceChildren(...files.map(({ name, bytes }) =>
      h('a', { class: 'file', href: documentUrl(name), download: name },
        icon('takeAway'), h('span', {}, WORDS[name] ?? name), h('span', { class: 'size' }, sizeWords(bytes)))));
    this.remarks.replaceChildren(...documents.remarks.map((remark) => h('p', { class: 'tip' }, remark)));
  }
}
