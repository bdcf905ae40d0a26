// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import './style/findings.css';
import { section } from './controls';
import { h, setText } from './dom';
import { badge, FindingMarks } from './finding_marks';
import { adviceFor, titleOf } from './finding_text';
import { findingsApi, type Finding, type FindingKind, type FindingList } from './findings_api';
import type { Point } from './geometry';
import type { LiveVideo } from './live_video';
import type { Stage } from './stage';
import { button, iconButton, type Toast } from './widgets';

// Another tablet may change the list too. Nothing is asked for while the tab is closed.
const REFRESH_MS = 3000;
const LOOK_MS = 250;
// So many are shown at once; a list of thousands would hold up the picture.
const PAGE = 50;
const MAX_NOTE = 4000;

const KINDS = [
  ['point', 'Point'],
  ['distance', 'Straight'],
  ['geodesic', 'Over skin'],
] as const satisfies readonly (readonly [FindingKind, string])[];

/** Findings: made by tapping the picture, listed, edited, deleted. */
export class FindingsPanel {
  readonly element: HTMLElement;

  private readonly marks: FindingMarks;
  private readonly keys = new Map<FindingKind, HTMLButtonElement>();
  private readonly advice = h('p', { class: 'tip advice', role: 'status', hidden: true });
  private readonly cancelKey = button('Cancel', 'cancel', () => void this.cancel());
  private readonly undoKey = button('Undo', 'undo', () => void this.undo());
  private readonly list = h('ol', { class: 'finding-list' });
  private readonly empty = h('p', { class: 'tip' },
    'Nothing marked yet. Choose what to mark, then tap the body in the picture.');
  private readonly more = button('Show more', 'plus', () => this.showMore());
  private making: { kind: FindingKind; picks: number[] } | undefined;
  private busy = false;
  private shown = '';
  private refreshed_ms = -Infinity;
  private num_shown = PAGE;
  private edited: string | undefined;
  /** What is written in the edited note and not saved yet. */
  private unsaved: { id: string; text: string } | undefined;
  private last: FindingList = { findings: [], undoable: null };

  constructor(private readonly stage: Stage, private readonly live: LiveVideo,
    private readonly toast: Toast) {
    this.marks = new FindingMarks(stage, live);
    for (const [kind, word] of KINDS) {
      const key = button(word, kind, () => this.begin(kind));
      key.setAttribute('aria-pressed', 'false');
      this.keys.set(kind, key);
    }
    this.cancelKey.hidden = true;
    this.undoKey.hidden = true;
    this.more.hidden = true;
    this.element = h('div', { class: 'findings' },
      section('Mark on the body', h('div', { class: 'kinds' }, ...this.keys.values()), this.advice,
        this.cancelKey),
      section('Findings', this.empty, this.list, this.more, this.undoKey));
    setInterval(() => {
      if (this.element.offsetParent === null) this.refreshed_ms = -Infinity;
      else if (!this.busy && performance.now() - this.refreshed_ms > REFRESH_MS) void this.refresh();
    }, LOOK_MS);
  }

  /** Ends what was begun: the finger is wanted for something else. */
  leave(): void {
    if (this.making) void this.cancel();
  }

  private begin(kind: FindingKind): void {
    if (this.making?.kind === kind) {
      void this.cancel();
      return;
    }
    if (this.making && this.making.picks.length > 0) void findingsApi.cancel().catch(() => undefined);
    this.making = { kind, picks: [] };
    this.stage.onTap = (point) => void this.tap(point);
    this.showMaking();
  }

  private async cancel(): Promise<void> {
    this.end();
    await findingsApi.cancel().catch(this.toast.sayError);
  }

  private end(): void {
    this.making = undefined;
    this.stage.onTap = undefined;
    this.showMaking();
  }

  private showMaking(): void {
    for (const [kind, key] of this.keys) {
      key.setAttribute('aria-pressed', String(kind === this.making?.kind));
    }
    this.advice.hidden = !this.making;
    this.cancelKey.hidden = !this.making;
    const words = this.making ? adviceFor(this.making.kind, this.making.picks.length) : '';
    setText(this.advice, words);
    this.stage.showHint(words);
  }

  private async tap(point: Point): Promise<void> {
    const making = this.making;
    if (!making || this.busy) return;
    this.busy = true;
    try {
      const frame_id = this.live.lastPicture()?.info?.frame_id;
      const pick = await findingsApi.pick(point, frame_id);
      if (making !== this.making) {
        // Given up meanwhile: nobody takes this pick up.
        if (!this.making?.picks.length) await findingsApi.cancel();
        return;
      }
      making.picks.push(pick.pick);
      this.showMaking();
      if (making.picks.length < (making.kind === 'point' ? 1 : 2)) return;
      this.end();
      await this.saveNote();
      const finding = await findingsApi.add(making.kind, making.picks, '');
      this.edited = finding.id;
      this.show(await findingsApi.list());
      this.list.querySelector('textarea')?.focus();
    } catch (error) {
      this.toast.sayError(error);
      if (!this.making) void findingsApi.cancel().catch(() => undefined);
    } finally {
      this.busy = false;
    }
  }

  private async change(work: () => Promise<FindingList>): Promise<boolean> {
    this.busy = true;
    try {
      this.show(await work());
      return true;
    } catch (error) {
      this.toast.sayError(error);
      return false;
    } finally {
      this.busy = false;
    }
  }

  private async undo(): Promise<void> {
    await this.change(() => findingsApi.undo());
  }

  private async refresh(): Promise<void> {
    this.refreshed_ms = performance.now();
    try {
      this.show(await findingsApi.list());
    } catch (error) {
      this.empty.hidden = false;
      setText(this.empty, error instanceof Error ? error.message : String(error));
    }
  }

  private showMore(): void {
    this.num_shown += PAGE;
    this.shown = '';
    this.show(this.last);
  }

  private show(list: FindingList): void {
    this.last = list;
    const key = JSON.stringify([list, this.edited, this.num_shown]);
    if (key === this.shown) return;
    // What is being written stays as it is; the list follows when it is done.
    const isWriting = this.list.contains(document.activeElement) && this.edited !== undefined
      && list.findings.some((finding) => finding.id === this.edited)
      && this.list.querySelector('textarea') !== null;
    if (isWriting) return;
    this.shown = key;
    if (!list.findings.some((finding) => finding.id === this.unsaved?.id)) this.unsaved = undefined;
    const newestFirst = [...list.findings].reverse();
    this.list.replaceChildren(...newestFirst.slice(0, this.num_shown).map((f) => this.item(f)));
    this.more.hidden = newestFirst.length <= this.num_shown;
    this.empty.hidden = newestFirst.length > 0;
    setText(this.empty,
      'Nothing marked yet. Choose what to mark, then tap the body in the picture.');
    this.undoKey.hidden = list.undoable === null;
    setText(this.undoKey.lastElementChild!, `Undo ${list.undoable ?? ''}`);
  }

  private item(finding: Finding): HTMLElement {
    const item = h('li', { class: 'finding-item', 'data-id': finding.id },
      h('div', { class: 'finding-head' }, badge(finding.id),
        h('span', { class: 'finding-title' }, titleOf(finding)),
        iconButton(`Edit the note of ${finding.id}`, 'edit', () => void this.edit(finding.id)),
        iconButton(`Delete ${finding.id}`, 'remove',
          () => void this.change(() => findingsApi.remove(finding.id)))));
    item.addEventListener('pointerenter', () => this.marks.choose(finding.id));
    item.addEventListener('pointerleave', () => this.marks.choose(undefined));
    if (finding.has_photo) item.append(this.photo(finding.id));
    if (this.edited === finding.id) {
      item.append(this.editor(finding));
    } else if (finding.note !== '') {
      item.append(h('p', { class: 'finding-note' }, finding.note));
    }
    return item;
  }

  /** The place as it was shown; a tap on it shows it as the camera saw it. */
  private photo(id: string): HTMLElement {
    const image = h('img', { class: 'finding-photo', loading: 'lazy', alt: `The place of ${id}` });
    let overlay = true;
    const load = (): void => {
      image.src = findingsApi.photoUrl(id, overlay);
    };
    image.addEventListener('error', () => {
      if (!overlay) return;
      overlay = false;
      load();
    });
    image.addEventListener('click', () => {
      overlay = !overlay;
      load();
    });
    load();
    return image;
  }

  /** Opens the note of a finding; the one that is open is saved and closed. */
  private async edit(id: string): Promise<void> {
    if (this.busy) return;
    // What has the focus counts as being written, and would stay.
    if (document.activeElement instanceof HTMLElement) document.activeElement.blur();
    if (!(await this.saveNote())) {
      this.list.querySelector('textarea')?.focus();
      return;
    }
    this.edited = this.edited === id ? undefined : id;
    this.shown = '';
    this.show(this.last);
    this.list.querySelector('textarea')?.focus();
  }

  /** Nothing written is lost, even if something else is gone on with. @return False: it was refused. */
  private async saveNote(): Promise<boolean> {
    const note = this.unsaved;
    if (!note) return true;
    if (!(await this.change(() => findingsApi.setNote(note.id, note.text)))) return false;
    if (this.unsaved === note) this.unsaved = undefined;
    return true;
  }

  private editor(finding: Finding): HTMLElement {
    const field = h('textarea', { rows: 3, maxlength: MAX_NOTE, 'aria-label': `Note of ${finding.id}`,
      placeholder: 'What is it? Optional.' });
    field.value = this.unsaved?.id === finding.id ? this.unsaved.text : finding.note;
    field.addEventListener('input', () => {
      this.unsaved = { id: finding.id, text: field.value };
    });
    return h('div', { class: 'finding-editor' }, field,
      button('Save', 'accept', () => void this.edit(finding.id), 'primary'));
  }
}
