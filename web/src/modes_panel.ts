// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { CaseInfo, SlicePlane, View, VolumePreset } from './api';
import { h } from './dom';
import './modes_panel.css';
import { button, choice, slider, type Slider } from './widgets';

const PLANES: readonly (readonly [SlicePlane, string])[] = [
  ['none', 'None'], ['camera', 'Camera'], ['coronal', 'Coronal'],
  ['axial', 'Axial'], ['sagittal', 'Sagittal'],
];
const PRESETS: readonly (readonly [VolumePreset, string])[] = [
  ['none', 'None'], ['bone', 'Bone'], ['soft-tissue', 'Soft tissue'],
  ['lung', 'Lung'], ['vessels', 'Vessels'], ['skin', 'Skin'],
];
const SLICE_WINDOWS: readonly (readonly [string, number, number])[] = [
  ['Soft', 40, 400], ['Bone', 400, 1800], ['Lung', -600, 1500],
];

const hu = (value: number): string => `${Math.round(value)} HU`;

/** What is shown inside the hole besides the structures' on and off. */
export class ModesPanel {
  readonly element: HTMLElement;

  private readonly opacities = h('div', { class: 'opacities' });
  private readonly sliders = new Map<string, Slider>();
  private readonly ct = h('div', { class: 'ct-modes' });
  private readonly noCt = h('p', { class: 'tip', hidden: true },
    'This case keeps no CT voxels: prepare it again to see slices and volume.');
  private readonly hands: HTMLButtonElement;
  private readonly outlines: HTMLButtonElement;
  private readonly inverted: HTMLButtonElement;
  private readonly cuts: HTMLButtonElement;
  private readonly plane;
  private readonly preset;
  private readonly position: Slider;
  private readonly depth: Slider;
  private readonly level: Slider;
  private readonly window: Slider;
  private readonly volumeLevel: Slider;
  private readonly volumeWindow: Slider;
  private readonly sliceControls: HTMLElement;
  private readonly volumeControls: HTMLElement;
  private shown: View | undefined;

  constructor(private readonly change: (change: Partial<View>) => void) {
    this.plane = choice('Slice', PLANES, (slice) => this.send({ slice }));
    this.preset = choice('Volume', PRESETS, (volume) => change({ volume }));
    this.position = slider('Position', { min: 0, max: 1, step: 0.005 },
      (value) => `${Math.round(value * 100)} %`, (slice_position) => change({ slice_position }));
    this.depth = slider('Depth below the skin', { min: 0, max: 250, step: 1 },
      (value) => `${value} mm`, (slice_depth_mm) => change({ slice_depth_mm }));
    this.level = slider('Level', { min: -1000, max: 1500, step: 10 }, hu,
      (slice_level_hu) => change({ slice_level_hu }));
    this.window = slider('Window', { min: 50, max: 3000, step: 10 }, hu,
      (width) => change({ slice_window_hu: this.isInverted() ? -width : width }));
    this.volumeLevel = slider('Level', { min: -1000, max: 1500, step: 10 }, hu,
      (volume_level_hu) => change({ volume_level_hu }));
    this.volumeWindow = slider('Window', { min: 50, max: 3000, step: 10 }, hu,
      (volume_window_hu) => change({ volume_window_hu }));
    this.hands = toggle('Hands stay in front',
      () => this.send({ hands_in_front: !(this.shown?.hands_in_front ?? true) }));
    this.outlines = toggle('Outline what is hidden',
      () => this.send({ outlines: !(this.shown?.outlines ?? false) }));
    this.inverted = toggle('Inverted greys', () =>
      this.send({ slice_window_hu: -(this.shown?.slice_window_hu ?? -400) }));
    this.cuts = toggle('Cut away what is before it',
      () => this.send({ slice_cuts: !(this.shown?.slice_cuts ?? true) }));
    this.sliceControls = h('div', { class: 'slice-controls', hidden: true },
      this.position.element, this.depth.element,
      h('div', { class: 'triple' }, ...SLICE_WINDOWS.map(([word, slice_level_hu, slice_window_hu]) =>
        button(word, undefined, () => change({ slice_level_hu, slice_window_hu })))),
      this.level.element, this.window.element, this.inverted, this.cuts);
    this.volumeControls = h('div', { class: 'volume-controls', hidden: true },
      this.volumeLevel.element, this.volumeWindow.element);
    this.ct.append(this.plane.element, this.sliceControls, this.preset.element, this.volumeControls);
    this.element = h('details', { class: 'group modes' },
      h('summary', {}, 'More views'), this.hands, this.outlines, this.opacities, this.ct, this.noCt);
  }

  showCase(info: CaseInfo): void {
    this.ct.hidden = !info.has_ct;
    this.noCt.hidden = info.has_ct;
    this.sliders.clear();
    for (const { name } of info.structures) {
      this.sliders.set(name, slider(`Opacity of ${name}`, { min: 0.05, max: 1, step: 0.01 },
        (value) => `${Math.round(value * 100)} %`,
        (value) => this.change({ structure_opacity: { [name]: value } })));
    }
    this.opacities.replaceChildren(...[...this.sliders.values()].map(({ element }) => element));
  }

  showView(view: View): void {
    this.shown = view;
    for (const [name, { element, show }] of this.sliders) {
      element.hidden = !(view.structures[name] ?? true);
      show(view.structure_opacity[name] ?? 1);
    }
    this.hands.setAttribute('aria-pressed', String(view.hands_in_front));
    this.outlines.setAttribute('aria-pressed', String(view.outlines));
    this.inverted.setAttribute('aria-pressed', String(this.isInverted()));
    this.cuts.setAttribute('aria-pressed', String(view.slice_cuts));
    this.plane.show(view.slice);
    this.preset.show(view.volume);
    this.sliceControls.hidden = view.slice === 'none';
    this.position.element.hidden = view.slice === 'camera';
    this.depth.element.hidden = view.slice !== 'camera';
    this.volumeControls.hidden = view.volume === 'none';
    this.position.show(view.slice_position);
    this.depth.show(view.slice_depth_mm);
    this.level.show(view.slice_level_hu);
    this.window.show(Math.abs(view.slice_window_hu));
    this.volumeLevel.show(view.volume_level_hu);
    this.volumeWindow.show(view.volume_window_hu);
  }

  private isInverted(): boolean {
    return (this.shown?.slice_window_hu ?? 0) < 0;
  }

  /** Shows at once what the server will say a little later. */
  private send(change: Partial<View>): void {
    this.change(change);
    if (this.shown) this.showView({ ...this.shown, ...change });
  }
}

function toggle(word: string, onPress: () => void): HTMLButtonElement {
  const key = button(word, undefined, onPress, 'toggle');
  key.setAttribute('aria-pressed', 'true');
  return key;
}
