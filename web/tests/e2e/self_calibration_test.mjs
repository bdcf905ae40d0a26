// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Usage: node self_calibration_test.mjs PATTERN_SERVER WEB_ROOT [FOLDER_FOR_SCREENSHOTS]
// The sensor's panel in a browser, from gathering to the proposal, yes, undo and no. What the
// server would answer is told by this test; that the server does so is session/self_calibrator_test.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { LivePage, runSteps, startServer } from './live_page.mjs';

const [program, webRoot, shots] = process.argv.slice(2);
const server = await startServer([program, '--web-root', webRoot]);
const live = await LivePage.open(server.url, { width: 1180, height: 820 });
const { page } = live;
const panel = page.locator('.sensor');
const tab = page.getByRole('tab', { name: 'Sensor' });
const key = (name) => panel.getByRole('button', { name, exact: true });

const map = { columns: 13, rows: 10, at_mm: 720, add_mm: [] };
for (let i = 0; i < 130; ++i) {
  const x = (i % 13) / 6 - 1;
  const y = Math.floor(i / 13) / 4.5 - 1;
  map.add_mm.push(2.4 * x - 1.1 * y + 1.5 * (x * x + y * y - 0.7));
}
const found = {
  verdict: 'error', corrects_sensor: true, follows_skin: true, now_mm: 1.94, shift_mm: 1.7,
  remaining_mm: 0.81, skin_mm: 0.62, skin_most_mm: 1.83, views: 60, sees_table: false, parts_better: 6, parts: 6, map,
};
const gathering = {
  phase: 'gathering', views: 23, wanted_views: 60, views_in_part: [0, 3, 0, 2, 23, 8, 0, 11, 0],
  missing: ['Move nearer to the body and farther away, by 30 cm in all.',
    'Roll the camera to the left and to the right.', 'Look at the body from its sides.'],
  found: null, applied: null, device: 'freenect-A00361D08047310A', problem: null,
};
const applied = {
  origin: 'self-calibration on the CT skin, built on [the camera\'s own], 2026-11-27T00:10:00Z',
  corrects_sensor: true, follows_skin: true, skin_most_mm: 1.83, shift_mm: 1.94, remaining_mm: 0.81,
  kept: true,
};

let state = gathering;
const asked = [];
await page.route('**/api/self-calibration**', async (route) => {
  const what = new URL(route.request().url()).pathname.split('/')[3];
  if (what) asked.push(what);
  if (what === 'apply') state = { ...gathering, views: 0, missing: [], applied };
  if (what === 'undo' || what === 'discard') state = { ...gathering, phase: 'resting', views: 0 };
  if (what === 'again') state = gathering;
  await route.fulfill({ json: state });
});

const shoot = async (name) => {
  if (shots) await live.screenshot(join(shots, `sensor_${name}.png`));
};

const stage_box = () => page.locator('.stage').boundingBox();

async function gathers() {
  await tab.click();
  await panel.getByText('23 of 60 views in motion').waitFor();
  assert.equal(await panel.locator('.sensor-parts .seen').count(), 5);
  const hints = await panel.locator('.sensor-hints li').allTextContents();
  assert.deepEqual(hints, gathering.missing.slice(0, 2), 'two hints at a time, the first ones');
  assert.ok(!(await key('Apply').isVisible()));
  await shoot('gathering');
}

/** Elsewhere on the page a dot says so, and nothing else: no window, no sound, no cover. */
async function proposes_quietly() {
  const box = await stage_box();
  await page.getByRole('tab', { name: 'Look' }).click();
  state = { ...gathering, phase: 'proposed', views: 60, missing: [], found };
  await page.waitForFunction(() => document.querySelector('#tab-sensor.marked'), undefined,
    { timeout: 15000 });
  assert.deepEqual(await stage_box(), box, 'the picture moved');
  assert.equal(await page.getByRole('tab', { name: 'Look' }).getAttribute('aria-selected'), 'true');
  assert.ok(!(await page.locator('.toast').isVisible()), 'it must not nag');
  await shoot('proposed_elsewhere');
  await tab.click();
  await panel.getByText('the overlay is about 1.9 mm off').waitFor();
  await panel.getByText('up to 1.8 mm from the CT’s').waitFor();
  await panel.getByText('all 6 of 6 checks').waitFor();
  const colors = await page.evaluate(() => {
    const canvas = document.querySelector('.sensor-map canvas');
    const at = (x, y) => [...canvas.getContext('2d').getImageData(x, y, 1, 1).data].slice(0, 3);
    return [at(2, 45), at(117, 45)];
  });
  assert.ok(colors[0][2] > colors[0][0] && colors[1][0] > colors[1][2],
    `the map is not blue to the left and red to the right: ${JSON.stringify(colors)}`);
  await shoot('proposed');
}

async function applies_and_takes_back() {
  await key('Apply').click();
  await panel.getByText('The correction is in use').waitFor();
  await panel.getByText('kept for this camera').waitFor();
  assert.ok(!(await page.locator('#tab-sensor.marked').count()), 'the dot stays');
  await shoot('applied');
  await key('Undo the correction').click();
  await panel.getByText('Not looking.').waitFor();
  assert.ok(!(await key('Undo the correction').isVisible()));
  await key('Check again').click();
  await panel.getByText('23 of 60').waitFor();
  state = { ...gathering, phase: 'proposed', views: 60, missing: [], found };
  await key('Not now').click();
  await panel.getByText('Not looking.').waitFor();
  assert.deepEqual(asked, ['apply', 'undo', 'again', 'discard']);
}

/** Gloves, and both ways to hold a tablet. */
async function fingers_fit() {
  state = { ...gathering, phase: 'proposed', views: 60, missing: [], found, applied };
  await key('Apply').waitFor();
  for (const [width, height] of [[1180, 820], [820, 1180]]) {
    await page.setViewportSize({ width, height });
    const bad = await page.evaluate(() =>
      [...document.querySelectorAll('.sensor button, .tab')]
        .map((element) => ({ name: element.textContent, box: element.getBoundingClientRect(),
          cut: element.scrollWidth > element.clientWidth + 1 }))
        .filter(({ box, cut }) => box.width > 0 && (box.width < 48 || box.height < 48 || cut))
        .map(({ name, box }) => `${name} ${box.width}x${box.height}`));
    assert.deepEqual(bad, [], `too small for a finger, or cut, at ${width}x${height}`);
    if (width === 1180) {
      const apply = await key('Apply').boundingBox();
      assert.ok(apply.y + apply.height < height - 60, 'a yes needs scrolling');
    }
    await shoot(`${width}x${height}`);
  }
}

await runSteps({ live, server, shoot }, [gathers, proposes_quietly, applies_and_takes_back, fingers_fit]);
