// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import '../../src/style/base.css';
import '../../src/style/controls.css';
import './viewer.css';
import { h } from '../../src/dom';
import { Body } from './body';
import { caseData, unpacked, type Finding } from './case_data';
import { Marks } from './marks';
import { makePanel } from './panel';
import { Slices } from './slices';
import { Stage } from './stage';

async function open(root: HTMLElement): Promise<void> {
  const data = caseData();
  document.title = `${data.name} – Morgagni`;
  const [model, voxels] = await Promise.all([
    unpacked('model'), data.volume ? unpacked('volume') : undefined]);
  const body = await Body.load(model);
  const slices = data.volume && voxels ? new Slices(data.volume, voxels, body.box) : undefined;

  const choose = (finding: Finding): void => {
    marks.select(finding.id);
    for (const card of panel.querySelectorAll<HTMLElement>('.finding')) {
      const isChosen = card.dataset['id'] === finding.id;
      card.setAttribute('aria-pressed', String(isChosen));
      if (isChosen) card.scrollIntoView({ block: 'nearest' });
    }
    const found = marks.placeOf(finding);
    if (found) stage.lookAt(found.place, found.normal);
  };
  const marks = new Marks(data.findings, body.skin, choose);
  const stage = new Stage(body, slices, marks);
  const panel = makePanel(data, body, slices, stage, choose);
  root.replaceChildren(h('main', { class: 'viewer' },
    h('header', { class: 'top' },
      h('h1', {}, data.name), h('span', { class: 'case-name' }, data.description),
      h('span', { class: 'notice' }, 'Not a medical device')),
    stage.element, panel));
  // For tests and the curious: where the body lies in the CT's frame, mm.
  Object.assign(window, { morgagni: { box: body.box } });
  requestAnimationFrame(() => {
    stage.look('front', true);
    root.dataset['ready'] = 'true';
  });
}

const root = document.getElementById('viewer')!;
root.append(h('p', { class: 'wait' }, 'Opening the case …'));
open(root).catch((error: unknown) => {
  const words = error instanceof Error ? error.message : String(error);
  root.replaceChildren(h('p', { class: 'wait' },
    `This case cannot be shown: ${words}. A browser of 2023 or newer with WebGL is needed.`));
});
