// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { h } from '../dom';
import { slider, type Slider } from '../widgets';
import { api, type Check, type Plane } from './api';
import { Latest } from './latest';

const LETTERS: Record<Plane, [left: string, right: string, top: string, bottom: string]> = {
  axial: ['R', 'L', 'A', 'P'],
  coronal: ['R', 'L', 'H', 'F'],
  sagittal: ['A', 'P', 'H', 'F'],
};
const NAMES: Record<Plane, string> = { axial: 'Axial', coronal: 'Coronal', sagittal: 'Sagittal' };
const MAX_HEIGHT_PX = 1024;
const WHEEL_MM = 4;

/** One slice of the CT with the skin's outline, and a slider through the body. */
export class SlicePane {
  readonly element: HTMLElement;
  private readonly picture = h('img', { alt: '', draggable: 'false' });
  private readonly frame: HTMLElement;
  private through: Slider | undefined;
  private position = 0.5;
  private check: Check | undefined;
  private readonly loading = new Latest<string>((path) => this.load(path));

  constructor(readonly plane: Plane, private readonly onProblem: (error: unknown) => void) {
    const letters = ['left', 'right', 'top', 'bottom'].map((side, i) =>
      h('span', { class: `letter at-${side}`, 'aria-hidden': 'true' }, LETTERS[plane][i]!));
    this.frame = h('div', { class: 'picture' }, this.picture, ...letters);
    this.element = h('section', { class: `pane ${plane}`, 'aria-label': `${NAMES[plane]} slice` },
      this.frame);
    this.frame.addEventListener('wheel', (event) => this.roll(event), { passive: false });
    new ResizeObserver(() => this.draw()).observe(this.frame);
  }

  show(check: Check): void {
    this.check = check;
    if (!this.through) this.addSlider(check.planes_mm[this.plane][2]);
    this.draw();
  }

  /** Shows the slice at a share of the way through the body. */
  goTo(position: number): void {
    this.position = Math.min(1, Math.max(0, position));
    this.through?.show(this.position);
    this.draw();
  }

  private addSlider(through_mm: number): void {
    this.through = slider(NAMES[this.plane], { min: 0, max: 1, step: 0.001 },
      (at) => `${Math.round(at * through_mm)} mm`, (at) => {
        this.position = at;
        this.draw();
      });
    // A slider is painted when it changes.
    this.through.show(0);
    this.through.show(this.position);
    this.element.append(this.through.element);
  }

  private roll(event: WheelEvent): void {
    if (!this.check) return;
    event.preventDefault();
    const step = (Math.sign(event.deltaY) * WHEEL_MM) / this.check.planes_mm[this.plane][2];
    this.goTo(this.position + step);
  }

  private draw(): void {
    if (!this.check || this.frame.clientHeight < 16) return;
    const [across, down] = this.check.planes_mm[this.plane];
    const scale = Math.min(this.frame.clientWidth / across, this.frame.clientHeight / down);
    const height = Math.round(down * scale * window.devicePixelRatio);
    this.picture.style.height = `${Math.round(down * scale)}px`;
    this.picture.style.width = `${Math.round(across * scale)}px`;
    this.loading.ask(api.slicePath(this.plane, this.position,
      Math.min(MAX_HEIGHT_PX, Math.max(16, height)), this.check.version));
  }

  private async load(path: string): Promise<void> {
    if (this.picture.getAttribute('src') === path) return;
    const next = new Image();
    next.src = path;
    try {
      await next.decode();
      this.picture.src = path;
    } catch {
      this.onProblem(new Error('The slice could not be drawn: is the program still running?'));
    }
  }
}
