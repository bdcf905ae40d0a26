// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Usage: node modes_test.mjs PATTERN_SERVER WEB_ROOT [FOLDER_FOR_SCREENSHOTS [PICTURE.png]]
// What is shown in the hole, set by finger: the server is told, and the panel shows what it has.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { LivePage, runSteps, startServer } from './live_page.mjs';

const [program, webRoot, shots, picture] = process.argv.slice(2);
const server = await startServer(
  [program, '--web-root', webRoot, ...(picture ? ['--picture', picture] : [])]);
const live = await LivePage.open(server.url);
const { page } = live;
const modes = page.locator('.modes');
const key = (name) => modes.getByRole('button', { name, exact: true });
const slider = (name) => modes.getByRole('slider', { name, exact: true });

const shoot = async (name) => {
  if (shots) await live.screenshot(join(shots, `modes_${name}.png`));
};

async function view_becomes(wanted) {
  const end = Date.now() + 8000;
  for (;;) {
    const view = (await live.status())?.view ?? {};
    const missing = Object.entries(wanted).filter(([name, value]) => view[name] !== value);
    if (missing.length === 0) return;
    assert.ok(Date.now() < end,
      `the view never got ${JSON.stringify(Object.fromEntries(missing))}: ${JSON.stringify(view)}`);
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
}

async function toggles(name, member, first) {
  await key(name).click();
  await view_becomes({ [member]: !first });
  assert.equal(await key(name).getAttribute('aria-pressed'), String(!first));
  await key(name).click();
  await view_becomes({ [member]: first });
  assert.equal(await key(name).getAttribute('aria-pressed'), String(first));
}

async function what_is_before_and_behind() {
  await modes.locator('summary').click();
  await toggles('Hands stay in front', 'hands_in_front', true);
  await toggles('Outline what is hidden', 'outlines', false);
  await slider('Opacity of bone').fill('0.4');
  const end = Date.now() + 8000;
  while ((await live.status())?.view?.structure_opacity?.bone !== 0.4) {
    assert.ok(Date.now() < end, 'the bone never became transparent');
  }
}

async function slices() {
  assert.ok(!(await slider('Position').isVisible()), 'no slice, and yet its position');
  for (const [word, slice] of [['Axial', 'axial'], ['Coronal', 'coronal'], ['Sagittal', 'sagittal']]) {
    await key(word).click();
    await view_becomes({ slice });
    assert.ok(await slider('Position').isVisible());
    assert.ok(!(await slider('Depth below the skin').isVisible()));
  }
  await slider('Position').fill('0.25');
  await view_becomes({ slice_position: 0.25 });
  await key('Camera').click();
  await slider('Depth below the skin').fill('80');
  await view_becomes({ slice: 'camera', slice_depth_mm: 80 });
  assert.ok(!(await slider('Position').isVisible()));
  await modes.getByRole('button', { name: 'Lung', exact: true }).first().click();
  await view_becomes({ slice_level_hu: -600, slice_window_hu: 1500 });
  await key('Inverted greys').click();
  await view_becomes({ slice_window_hu: -1500 });
  await slider('Window').first().fill('600');
  await view_becomes({ slice_window_hu: -600 });
  await key('Inverted greys').click();
  await view_becomes({ slice_window_hu: 600 });
  await toggles('Cut away what is before it', 'slice_cuts', false);
  await shoot('slice');
}

async function volumes() {
  for (const [word, volume] of [['Bone', 'bone'], ['Soft tissue', 'soft-tissue'], ['Lung', 'lung'],
    ['Vessels', 'vessels'], ['Skin', 'skin']]) {
    // Slice windows have some of the same words, and stand before.
    await modes.getByRole('button', { name: word, exact: true }).last().click();
    await view_becomes({ volume });
  }
  await slider('Level').last().fill('-250');
  await view_becomes({ volume_level_hu: -250 });
  await slider('Window').last().fill('750');
  await view_becomes({ volume_window_hu: 750 });
  await shoot('volume');
}

async function nothing_again() {
  for (const group of ['Slice', 'Volume']) {
    await modes.getByRole('group', { name: group }).getByRole('button', { name: 'None' }).click();
  }
  await view_becomes({ slice: 'none', volume: 'none' });
  assert.ok(!(await slider('Window').first().isVisible()));
}

/** Gloves, and both ways to hold a tablet. */
async function fingers_fit() {
  await key('Camera').click();
  for (const [width, height] of [[1180, 820], [820, 1180]]) {
    await page.setViewportSize({ width, height });
    const small = await page.evaluate(() =>
      [...document.querySelectorAll('.modes button, .modes input')]
        .map((element) => ({ name: element.textContent, box: element.getBoundingClientRect() }))
        .filter(({ box }) => box.width > 0 && (box.width < 48 || box.height < 48))
        .map(({ name, box }) => `${name} ${box.width}x${box.height}`));
    assert.deepEqual(small, [], `too small for a finger at ${width}x${height}`);
    await shoot(`${width}x${height}`);
  }
}

await runSteps({ live, server, shoot }, [what_is_before_and_behind, slices, volumes, nothing_again, fingers_fit]);
