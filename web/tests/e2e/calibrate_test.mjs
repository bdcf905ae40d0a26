// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Usage: node calibrate_test.mjs MORGAGNI WEB_ROOT SCRATCH [PICTURES]
// The page of `morgagni calibrate --page` before a simulated board, from the first hint to the kept
// calibration. With PICTURES, a folder, the page is photographed at each step in both orientations.

import assert from 'node:assert/strict';
import { mkdirSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { join } from 'node:path';
import { LivePage, startServer } from './live_page.mjs';

const [program, webRoot, scratch, pictures] = process.argv.slice(2);
const LANDSCAPE = { width: 1180, height: 820 };
const PORTRAIT = { width: 820, height: 1180 };
rmSync(scratch, { recursive: true, force: true });
mkdirSync(scratch, { recursive: true });
process.env.MORGAGNI_CAMERAS_DIR = scratch;

async function photograph(live, step) {
  if (!pictures) return;
  for (const [name, size] of [['landscape', LANDSCAPE], ['portrait', PORTRAIT]]) {
    await live.page.setViewportSize(size);
    await live.page.waitForTimeout(400);
    await live.screenshot(join(pictures, `${step}_${name}.png`));
  }
  await live.page.setViewportSize(LANDSCAPE);
}

/** What is shown lies within the window, the keys without scrolling. */
async function fits(live) {
  for (const size of [LANDSCAPE, PORTRAIT]) {
    await live.page.setViewportSize(size);
    const [wide, outside] = await live.page.evaluate(() => [
      document.documentElement.scrollWidth > window.innerWidth,
      [...document.querySelectorAll('.keys button:not([hidden])')].filter((key) => {
        const box = key.getBoundingClientRect();
        return box.bottom > window.innerHeight + 1 || box.right > window.innerWidth + 1;
      }).map((key) => key.textContent)]);
    assert.equal(wide, false, 'nothing is cut off at the side');
    assert.deepEqual(outside, []);
  }
  await live.page.setViewportSize(LANDSCAPE);
}

// Fewer views than a person should take: the page is tested here, not the accuracy.
const server = await startServer([program, 'calibrate', '--camera',
  'simulated-board:seed=21,hold=0.34,speed=full', '--device', 'sample-camera', '--page', '--port', '0',
  '--views', '12', '--wall-views', '5', '--web', webRoot]);
const live = await LivePage.open(`${server.url}/calibrate.html`, LANDSCAPE);
const { page } = live;
const key = (name) => page.getByRole('button', { name, exact: true });

await live.wait_for_picture();
await page.waitForFunction(() => window.morgagni.status?.views > 0, undefined, { timeout: 200000 });
assert.ok(await page.getByText('not calibrated so far').isVisible());
// At once: the camera may take several views between two looks at the page.
const [views, isDisabled] = await key('Calculate').evaluate((calculate) => [window.morgagni.status.views, calculate.disabled]);
assert.equal(isDisabled, views < 8, `of ${views} views`);
assert.ok((await page.locator('.hints li').count()) > 0, 'it says what is missing');
await photograph(live, 'begin');

await page.waitForFunction(
  () => window.morgagni.status.missing.some((words) => words.includes('flat wall')), undefined, { timeout: 200000 });
assert.ok(await page.getByText('hang the board on a flat wall').isVisible());
assert.equal(await page.locator('.grid .done').count(), 9, 'every part of the picture is ticked');
await photograph(live, 'wall');

await page.waitForFunction(() => window.morgagni.status.missing.length === 0, undefined, { timeout: 200000 });
assert.ok(await page.getByText('That is enough: calculate').isVisible());
const enough = await live.status();
assert.ok(enough.views_on_wall >= 5 && enough.views >= 17, `${enough.views_on_wall} of ${enough.views}`);
await key('Undo the last').click();
await page.waitForFunction((views) => window.morgagni.status.views === views - 1, enough.views);
await page.waitForFunction(() => window.morgagni.status.missing.length === 0, undefined, { timeout: 200000 });
await fits(live);
await photograph(live, 'enough');

await key('Calculate').click();
await page.waitForFunction(() => window.morgagni.status.result, undefined, { timeout: 200000 });
const { result } = await live.status();
assert.deepEqual(result.remarks, []);
const names = result.figures.map(({ name }) => name);
for (const name of ['colour camera', 'depth camera', 'from camera to camera', 'depth error, views held out']) {
  assert.ok(names.includes(name), name);
}
assert.ok(await page.getByText('Depth error, views held out').isVisible());
await fits(live);
await photograph(live, 'calculated');

await key('Keep it').click();
await page.waitForFunction(() => window.morgagni.status.kept !== '');
assert.ok(await key('Kept').isDisabled());
await page.getByText(/in use: .*less than an hour old/).waitFor();
await photograph(live, 'kept');
assert.deepEqual(live.errors, []);
await live.close();
assert.equal(await server.stop(), 0);

const files = readdirSync(join(scratch, 'sample-camera'));
assert.equal(files.length, 1);
const kept = JSON.parse(readFileSync(join(scratch, 'sample-camera', files[0]), 'utf8'));
assert.ok(JSON.stringify(kept).includes('depth_correction'), 'the depth is corrected');
console.log('calibration page: all well');
