// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { api, type BodySide, type CaseInfo } from './api';
import { section } from './controls';
import { h } from './dom';
import { wrapAngle } from './landmarks';
import { button, choice, slider, type Toast } from './widgets';

const SIDES = [
  ['anterior', 'Front'],
  ['posterior', 'Back'],
  ['left', 'Left'],
  ['right', 'Right'],
] as const satisfies readonly (readonly [BodySide, string])[];

/** Start by placement: the body's outline hangs before the camera, and the camera goes to it. */
export class PlacementPanel {
  readonly element: HTMLElement;

  private placement: { distance_mm: number; side: BodySide; roll_rad: number } = {
    distance_mm: 600, side: 'anterior', roll_rad: 0,
  };
  private range = { min: 300, max: 1000 };
  private readonly settings = h('div', { class: 'settings' });
  private sending = false;
  private changed = false;

  constructor(onClose: () => void, private readonly toast: Toast) {
    this.element = h('div', { class: 'controls placement' },
      section('Start by placement', this.settings),
      h('p', { class: 'tip' },
        'The outline shows where the body must be seen. Tracking begins by itself when it fits.'),
      button('Close', 'cancel', onClose));
  }

  showCase(info: CaseInfo): void {
    const { distance_mm, min, max } = info.start_options;
    this.placement.distance_mm = distance_mm;
    this.range = { min, max };
  }

  /** Puts the outline before the camera. */
  begin(): void {
    const distance = slider('Distance', { ...this.range, step: 10 },
      (value) => `${(value / 10).toFixed(0)} cm`,
      (distance_mm) => this.change({ distance_mm }));
    const side = choice('Side to the camera', SIDES, (value) => this.change({ side: value }));
    const turn = (angle: number) => (): void =>
      this.change({ roll_rad: wrapAngle(this.placement.roll_rad + angle) });
    this.settings.replaceChildren(distance.element, side.element,
      h('span', { class: 'caption' }, 'Turn the outline'),
      h('div', { class: 'pair' },
        button('90°', 'turnLeft', turn(-Math.PI / 2)),
        button('90°', 'turnRight', turn(Math.PI / 2))));
    distance.show(this.placement.distance_mm);
    side.show(this.placement.side);
    this.change({});
  }

  private change(change: Partial<PlacementPanel['placement']>): void {
    this.placement = { ...this.placement, ...change };
    this.changed = true;
    if (!this.sending) void this.send();
  }

  private async send(): Promise<void> {
    this.sending = true;
    while (this.changed) {
      this.changed = false;
      await api.startByPlacement(this.placement).catch(this.toast.sayError);
    }
    this.sending = false;
  }
}
