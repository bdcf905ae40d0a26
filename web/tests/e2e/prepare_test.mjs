// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Usage: node prepare_test.mjs MORGAGNI WEB_ROOT SCRATCH
// The page of `morgagni prepare --check`: a trunk, an arm that does not touch it and a table are
// looked at, corrected and used; or not.

import assert from 'node:assert/strict';
import { existsSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { LivePage, startServer } from './live_page.mjs';

const [program, webRoot, scratch] = process.argv.slice(2);
rmSync(scratch, { recursive: true, force: true });
mkdirSync(scratch, { recursive: true });
const SIDE = 100;
const ct = join(scratch, 'body.mha');
const onShell = join(scratch, 'shell.mha');

function write(file, side, spacing, huAt) {
  const voxels = new Int16Array(side ** 3);
  for (let z = 0, i = 0; z < side; ++z)
    for (let y = 0; y < side; ++y) for (let x = 0; x < side; ++x, ++i) voxels[i] = huAt(x, y, z);
  const head = 'ObjectType = Image\nNDims = 3\nBinaryData = True\n' +
    `ElementSpacing = ${spacing} ${spacing} ${spacing}\nDimSize = ${side} ${side} ${side}\n` +
    'ElementType = MET_SHORT\nElementDataFile = LOCAL\n';
  writeFileSync(file, Buffer.concat([Buffer.from(head), Buffer.from(voxels.buffer)]));
}

function writeCt() {
  write(ct, SIDE, 2, (x, y) => {
    const trunk = Math.hypot(x - 40, y - 40) < 25;
    const arm = Math.hypot(x - 80, y - 40) < 8;
    const table = Math.abs(y - 72) < 2;
    return trunk || arm || table ? 40 : -1000;
  });
}

/** A trunk and a shell of its HU behind it, which comes down to the skin from both sides. */
function writeTrunkOnShell() {
  const spacing = 1.3;
  write(onShell, 90, spacing, (i, j) => {
    const [x, y] = [spacing * (i - 45), spacing * (j - 40)];
    const trunk = 30 - Math.hypot(x, y);
    const shell = Math.min(1.3 - Math.abs(y - 31.2 + 0.011 * x * x), y - 5);
    const inside = Math.min(1, Math.max(0, Math.max(trunk, shell) / spacing + 0.5));
    return Math.round(1040 * inside - 1000);
  });
}

async function opened(name, file = ct, shows = () => window.morgagni?.check?.parts.length === 2) {
  const folder = join(scratch, name);
  const server = await startServer([program, 'prepare', file, '--case', folder, '--check', '--web', webRoot,
    '--vertices', '2000']);
  const live = await LivePage.open(`${server.url}/prepare.html`, { width: 1180, height: 820 });
  await live.page.waitForFunction(shows);
  return { folder, server, live };
}

const check = (live) => live.page.evaluate(() => window.morgagni.check);

/** A picture of the page is not black. */
async function looksAt(live, selector) {
  await live.page.waitForFunction((pane) => {
    const picture = document.querySelector(`${pane} img`);
    return picture?.complete && picture.naturalHeight > 100;
  }, selector);
}

async function usesWhatWasCorrected() {
  const { folder, server, live } = await opened('used');
  const { page } = live;
  for (const plane of ['axial', 'coronal', 'sagittal']) await looksAt(live, `.pane.${plane}`);
  const before = await check(live);
  assert.deepEqual(before.parts.map(({ place, kept }) => [place, kept]), [['behind', false], ['left of', false]]);

  const slider = page.getByRole('slider', { name: 'Threshold' });
  const asked = performance.now();
  await slider.focus();
  await page.keyboard.press('ArrowLeft');
  await page.waitForFunction(() => window.morgagni.check.threshold_hu === -310);
  const redrawn_ms = performance.now() - asked;
  assert.ok(redrawn_ms < 3000, `a slider's step took ${redrawn_ms} ms`);

  const arm = page.getByRole('switch', { name: 'Keep what is left of the body' });
  await arm.click();
  await page.waitForFunction(() => window.morgagni.check.parts[1].kept);
  assert.equal(await arm.getAttribute('aria-checked'), 'true');
  const after = await check(live);
  assert.ok(after.body_ml > before.body_ml + 100, 'the arm belongs to the body');

  await page.getByRole('button', { name: 'Use it' }).click();
  await page.waitForFunction(() => window.morgagni.check.state === 'done', undefined, { timeout: 60000 });
  assert.ok(await page.getByText('The case is made').isVisible());
  assert.deepEqual(live.errors, []);
  await live.close();
  const json = JSON.parse(readFileSync(join(folder, 'case.json'), 'utf8'));
  assert.equal(json.options.skin.threshold_hu, -310);
  assert.ok(json.options.skin.keep_mm.length > 0);
  assert.deepEqual(json.cut.map(({ place }) => place), ['behind']);
  assert.equal(await server.stop(), 0, 'the program has ended by itself, all well');
}

async function leavesNothingBehind() {
  const { folder, server, live } = await opened('cancelled');
  await live.page.getByRole('button', { name: 'Cancel' }).click();
  await live.page.getByText('Nothing was made').waitFor();
  await live.close();
  assert.notEqual(await server.stop(), 0);
  assert.ok(!existsSync(folder));
  assert.deepEqual(readdirSync(scratch).filter((name) => name.startsWith('cancelled')), []);
}

/** A layer that was left is taken off, put back, and taken off for good. */
async function takesALayerOff() {
  writeTrunkOnShell();
  const isLeft = () => window.morgagni?.check?.doubts.some(({ why }) => why === 'layer_left');
  const { folder, server, live } = await opened('taken_off', onShell, isLeft);
  const { page } = live;
  const isTaken = () => window.morgagni.check.doubts.some(({ why }) => why === 'taken_off');
  const before = await check(live);
  await page.getByRole('button', { name: 'Take off' }).first().click();
  await page.waitForFunction(isTaken);
  assert.ok((await check(live)).body_ml < before.body_ml - 2, 'the layer is no body');
  await page.getByRole('button', { name: 'Put back' }).click();
  await page.waitForFunction(() => !window.morgagni.check.doubts.some(({ why }) => why === 'taken_off'));
  assert.equal((await check(live)).body_ml, before.body_ml);
  await page.getByRole('button', { name: 'Take off' }).first().click();
  await page.waitForFunction(isTaken);
  await page.getByRole('button', { name: 'Use it' }).click();
  await page.waitForFunction(() => window.morgagni.check.state === 'done', undefined, { timeout: 60000 });
  assert.deepEqual(live.errors, []);
  await live.close();
  const json = JSON.parse(readFileSync(join(folder, 'case.json'), 'utf8'));
  assert.equal(json.options.skin.take_off_mm.length, 1);
  assert.ok(json.doubtful_skin.some(({ why }) => why === 'layer taken off on demand'));
  assert.equal(await server.stop(), 0);
}

writeCt();
await usesWhatWasCorrected();
await leavesNothingBehind();
await takesALayerOff();
console.log('prepare page: all well');
