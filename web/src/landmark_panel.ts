// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { api, type LandmarkSolution, type SkinViewpoint } from './api';
import { h, setText } from './dom';
import type { Point } from './geometry';
import { landmarkColor, Landmarks } from './landmarks';
import { SkinPane } from './skin_pane';
import type { Stage } from './stage';
import { millimetres } from './status_text';
import { button, type Toast } from './widgets';

/** Start by landmarks: the same points on the CT's skin and on the standing live picture. */
export class LandmarkPanel {
  readonly skin: SkinPane;
  readonly bar: HTMLElement;
  /** The server knows that points are being tapped here. */
  isBegun = false;

  private readonly landmarks = new Landmarks();
  private solution: LandmarkSolution | undefined;
  private readonly advice = h('p', { class: 'advice' });
  private readonly chips = h('ol', { class: 'chips' });
  private readonly fre = h('div', { class: 'fre' });
  private readonly undoKey: HTMLButtonElement;
  private readonly acceptKey: HTMLButtonElement;

  constructor(
    private readonly stage: Stage,
    private readonly toast: Toast,
    private readonly onEnd: () => void,
  ) {
    this.skin = new SkinPane(toast.sayError);
    this.undoKey = button('Undo', 'undo', () => this.undo());
    this.acceptKey = button('Accept', 'accept', () => void this.accept(), 'primary');
    this.bar = h('section', { class: 'landmark-bar', 'aria-label': 'Start by landmarks' },
      h('div', { class: 'landmark-words' }, this.advice, this.chips),
      this.fre,
      h('div', { class: 'landmark-keys' }, this.undoKey,
        button('Cancel', 'cancel', () => void this.cancel()), this.acceptKey));
  }

  /** The live picture stands from here on. */
  async begin(): Promise<void> {
    await api.beginLandmarks();
    this.isBegun = true;
    this.landmarks.clear();
    this.skin.onTap = (viewpoint, pixel) => void this.tapCt(viewpoint, pixel);
    this.stage.onTap = (point) => void this.tapLive(point);
    this.changed();
  }

  /** Draws the points again where the window has changed. */
  paint(): void {
    const all = this.landmarks.all.map((landmark, idx) => ({
      landmark, label: String(idx + 1), color: landmarkColor(idx),
    }));
    this.stage.showMarks(all.flatMap(({ landmark: { live }, label, color }) =>
      live ? [{ pixel: live.pixel, label, color }] : []));
    this.skin.showMarks(all.flatMap(({ landmark: { ct }, label, color }) =>
      ct ? [{ ct, label, color }] : []));
  }

  close(): void {
    this.isBegun = false;
    this.stage.onTap = undefined;
    this.skin.onTap = undefined;
    this.landmarks.clear();
    this.paint();
  }

  private async tapCt(viewpoint: SkinViewpoint, pixel: Point): Promise<void> {
    try {
      const { ct_mm } = await api.pickOnCt(viewpoint, pixel);
      this.landmarks.addCt({ mm: ct_mm, viewpoint, pixel });
      this.changed();
    } catch (error) {
      this.toast.sayError(error);
    }
  }

  private async tapLive(pixel: Point): Promise<void> {
    try {
      const { depth_mm } = await api.pickOnLive(pixel);
      this.landmarks.addLive({ mm: depth_mm, pixel });
      this.changed();
    } catch (error) {
      this.toast.sayError(error);
    }
  }

  private undo(): void {
    this.landmarks.undo();
    this.changed();
  }

  private changed(): void {
    this.solution = undefined;
    this.show();
    if (this.landmarks.pairs().length >= 3) void this.solve();
  }

  private async solve(): Promise<void> {
    const pairs = this.landmarks.pairs();
    try {
      const solution = await api.solveLandmarks(pairs);
      if (pairs.length !== this.landmarks.pairs().length) return;
      this.solution = solution;
    } catch (error) {
      this.toast.sayError(error);
    }
    this.show();
  }

  private async accept(): Promise<void> {
    try {
      // Too few points: the server says so.
      await api.acceptLandmarks(this.landmarks.pairs());
      this.onEnd();
    } catch (error) {
      this.toast.sayError(error);
    }
  }

  private async cancel(): Promise<void> {
    await api.cancelLandmarks().catch(this.toast.sayError);
    this.onEnd();
  }

  private show(): void {
    setText(this.advice, this.landmarks.advice());
    this.undoKey.disabled = this.landmarks.all.length === 0;
    this.acceptKey.classList.toggle('not-yet', this.landmarks.pairs().length < 3);
    this.fre.replaceChildren(
      h('span', { class: 'caption' }, 'FRE'),
      h('span', { class: 'figure' },
        h('span', { class: 'number' }, millimetres(this.solution?.fre_mm)),
        h('span', { class: 'unit' }, 'mm')));
    this.chips.replaceChildren(...this.landmarks.all.map(({ ct, live }, idx) => {
      const residual = this.solution?.residuals_mm[idx];
      const words = !live ? 'live?' : !ct ? 'CT?'
        : residual === undefined ? '✓' : `${residual.toFixed(1)} mm`;
      // A tap on it turns the CT to where that point was tapped.
      const chip = h('button', { type: 'button', class: 'chip' },
        h('b', {}, String(idx + 1)), h('span', {}, words));
      chip.addEventListener('click', () => ct && this.skin.lookFrom(ct.viewpoint));
      chip.style.setProperty('--color', landmarkColor(idx));
      return h('li', {}, chip);
    }));
    this.paint();
  }
}
