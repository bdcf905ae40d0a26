// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { section } from '../../src/controls';
import { h } from '../../src/dom';
import { icon } from '../../src/icons';
import { button, choice, slider } from '../../src/widgets';
import type { Body, Part } from './body';
import { lengthWords, type CaseData, type Finding } from './case_data';
import { PLANES, type Slices } from './slices';
import type { Stage, StandardView } from './stage';

const VIEWS: readonly (readonly [StandardView, string])[] = [
  ['front', 'Front'], ['back', 'Back'], ['left', 'Left'],
  ['right', 'Right'], ['head', 'Head'], ['feet', 'Feet'],
];
const WINDOWS: readonly (readonly [string, string, number, number])[] = [
  ['soft', 'Soft', 40, 400], ['bone', 'Bone', 400, 1800], ['lung', 'Lung', -600, 1500],
];
const percent = (value: number): string => `${Math.round(value * 100)} %`;

function toggle(label: string, on: boolean, color: string, onChange: (on: boolean) => void): HTMLButtonElement {
  const key = h('button', { type: 'button', class: 'key toggle', 'aria-pressed': String(on) },
    ...(color ? [h('span', { class: 'swatch' })] : []), h('span', {}, label), icon('accept'));
  if (color) key.style.setProperty('--color', color);
  key.addEventListener('click', () => {
    const isOn = key.getAttribute('aria-pressed') !== 'true';
    key.setAttribute('aria-pressed', String(isOn));
    onChange(isOn);
  });
  return key;
}

function partControls(part: Part, stage: Stage): HTMLElement {
  let on = true;
  let opacity = 1;
  const apply = (): void => {
    part.show(on ? opacity : 0);
    stage.plan();
  };
  const amount = slider('Opacity', { min: 0.05, max: 1, step: 0.01 }, percent, (value) => {
    opacity = value;
    apply();
  });
  amount.show(1);
  const key = toggle(part.name, true, part.color, (isOn) => {
    on = isOn;
    amount.element.hidden = !isOn;
    apply();
  });
  return h('div', { class: 'part', 'data-name': part.name }, key, amount.element);
}

function surfaces(body: Body, stage: Stage, textured: boolean): HTMLElement {
  const parts = body.parts.map((part) => partControls(part, stage));
  const light = toggle('Light on the skin', true, '', (on) => {
    body.light(on);
    stage.plan();
  });
  return section('Surfaces', ...parts, ...(textured ? [light] : []));
}

function sliceControls(slices: Slices, stage: Stage, data: CaseData): HTMLElement {
  const rows = PLANES.map((plane) => {
    const place = slider('Place', { min: 0, max: 1, step: 0.002 },
      () => `${slices.place(plane).toFixed(0)} mm`, (share) => {
        slices.move(plane, share);
        stage.plan();
      });
    slices.move(plane, 0.5);
    place.show(0.5);
    place.element.hidden = true;
    const key = toggle(plane, false, '', (on) => {
      slices.show(plane, on);
      place.element.hidden = !on;
      if (on) stage.lookOnto(plane);
      stage.plan();
    });
    return h('div', { class: 'part', 'data-plane': plane }, key, place.element);
  });
  const windows = choice('Window', WINDOWS.map(([value, word]) => [value, word] as const), (value) => {
    const [, , level, width] = WINDOWS.find(([name]) => name === value)!;
    slices.setWindow(level, width);
    stage.plan();
  });
  windows.show('soft');
  const cut = toggle('Cut the body open there', true, '', (on) => {
    stage.cutOpen = on;
    stage.plan();
  });
  const size = data.volume!.spacing_mm.map((side) => side.toFixed(2)).join(' × ');
  const source = data.volume!.source_spacing_mm.map((side) => side.toFixed(2)).join(' × ');
  return section('CT slices', ...rows, windows.element, cut,
    h('p', { class: 'tip' }, `Voxels of ${size} mm, made from ${source} mm. Not for diagnosis.`));
}

function card(finding: Finding, onPress: (finding: Finding) => void): HTMLElement {
  const bounds = finding.points.map(({ bound_mm }) => bound_mm).filter((bound) => bound !== null);
  const sure = bounds.length > 0
    ? `Error bound ${Math.max(...bounds).toFixed(1)} mm (95 %)` : 'Error bound not known';
  const element = h('button', { type: 'button', class: 'finding', 'data-id': finding.id },
    h('span', { class: 'finding-head' }, h('b', {}, finding.id), h('span', {}, lengthWords(finding))));
  element.addEventListener('click', () => onPress(finding));
  // Words of people go in as text, never as HTML.
  if (finding.note) element.append(h('span', { class: 'note', dir: 'auto' }, finding.note));
  if (finding.photo?.startsWith('data:image/png;base64,')) {
    element.append(h('img', { src: finding.photo, alt: `Photo of ${finding.id}` }));
  }
  element.append(h('span', { class: 'sure' }, `${sure} · ${finding.created_at}`));
  return element;
}

/** Everything beside the picture. */
export function makePanel(data: CaseData, body: Body, slices: Slices | undefined, stage: Stage,
  onPress: (finding: Finding) => void): HTMLElement {
  const views = h('div', { class: 'view-keys' },
    ...VIEWS.map(([view, word]) => button(word, undefined, () => stage.look(view))));
  const findings = data.findings.map((finding) => card(finding, onPress));
  const facts = h('dl', {}, ...data.facts.flatMap(([name, value]) => [h('dt', {}, name), h('dd', {}, value)]));
  const skin = data.textured
    ? `${Math.round(data.seen_share * 100)} % of the skin was seen by the camera; grey skin was not.`
    : 'No camera colours: the skin has one plain colour, which is not the body’s.';
  return h('aside', { class: 'panel' },
    section('View', views),
    ...(findings.length > 0 ? [section('Findings', ...findings)] : []),
    surfaces(body, stage, data.textured),
    ...(slices ? [sliceControls(slices, stage, data)] : []),
    h('details', { class: 'about' }, h('summary', {}, 'About this case'),
      h('p', { class: 'tip' }, skin), ...data.remarks.map((remark) => h('p', { class: 'tip' }, remark)), facts,
      h('p', { class: 'tip' }, `Made ${data.made_at} with Morgagni ${data.version}.`)));
}
