// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Usage: node findings_test.mjs MORGAGNI WEB_ROOT SCRATCH [FOLDER_FOR_SCREENSHOTS]
// Findings, stills and videos as somebody with a tablet makes them, on a real CT in a real browser: taps on the
// live picture, a hostile note, what is on disk afterwards, and what other people's programs say of it.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';

import { LivePage, startServer } from '../../web/tests/e2e/live_page.mjs';
import { makeDemoCase } from './demo_case.mjs';

const [program, webRoot, scratch, shots] = process.argv.slice(2);
const folder = makeDemoCase(program, scratch, '--vertices', '8000');

const json = (...parts) => JSON.parse(readFileSync(join(folder, ...parts), 'utf8'));
const sha256 = (...parts) => createHash('sha256').update(readFileSync(join(folder, ...parts))).digest('hex');
const serve = () => startServer([program, 'serve', '--case', folder, '--camera', 'simulated:seed=5,distance=450',
  '--port', '0', '--web', webRoot]);
let server = await serve();
let live = await LivePage.open(server.url, { width: 1180, height: 820 });
let { page } = live;

async function post(path, body) {
  const response = await fetch(server.url + path, { method: 'POST', body: JSON.stringify(body) });
  assert.equal(response.status, 200, await response.clone().text());
  return response.json();
}
async function shot(name) {
  if (shots) await page.screenshot({ path: join(shots, `${name}.png`) });
}
/** Taps a pixel of the picture. */
async function tap(x, y) {
  const at = await page.evaluate(([px, py]) => {
    const video = document.querySelector('video');
    const box = video.getBoundingClientRect();
    const scale = Math.min(box.width / video.videoWidth, box.height / video.videoHeight);
    return { x: box.left + (box.width - video.videoWidth * scale) / 2 + px * scale,
      y: box.top + (box.height - video.videoHeight * scale) / 2 + py * scale };
  }, [x, y]);
  await page.touchscreen.tap(at.x, at.y);
}
const item = (id) => page.locator(`.finding-item[data-id=${id}]`);
async function mark(kind, ...pixels) {
  await page.getByRole('button', { name: kind, exact: true }).click();
  const before = await page.locator('.finding-item').count();
  for (const [x, y] of pixels) {
    const answered = page.waitForResponse((response) => response.url().endsWith('/api/findings/pick'));
    await tap(x, y);
    const response = await answered;
    assert.equal(response.status(), 200, await response.text());
  }
  await page.waitForFunction((count) => document.querySelectorAll('.finding-item').length > count, before);
}

await live.wait_for_picture(60000);
await live.wait_for_state('tracking', 120000);
await post('/api/view', { hole_radius: 0.22 });
await post('/api/freeze', { frozen: true });
await page.waitForFunction(() => window.morgagni.status?.frozen);

// A finding with a note that a careless page would run.
await page.getByRole('tab', { name: 'Findings' }).click();
await mark('Point', [320, 240]);
const note = '<img src=x onerror="window.pwned=1"> bruise, 3 × 2 cm\n<script>window.pwned=1</script>';
await page.getByLabel('Note of F1', { exact: true }).fill(note);
await page.getByRole('button', { name: 'Save', exact: true }).click();
await item('F1').locator('.finding-note').waitFor();
assert.equal(await item('F1').locator('.finding-note').textContent(), note);
assert.equal(await page.evaluate(() => window.pwned), undefined, 'the note was run');
assert.equal(json('findings', 'findings.json').findings[0].note, note);

// It is marked where it was tapped, and goes with the body while the picture moves.
const drawn = () => page.evaluate(() => {
  const circle = document.querySelector('.finding-marks [data-id=F1] circle');
  return circle && [Number(circle.getAttribute('cx')), Number(circle.getAttribute('cy'))];
});
await page.waitForFunction(() => document.querySelector('.finding-marks [data-id=F1] circle'));
const [x, y] = await drawn();
assert.ok(Math.hypot(x - 320, y - 240) < 1, `tapped at 320, 240, marked at ${x}, ${y}`);



// Measurements, on skin that the hole leaves.
await post('/api/view', { hole_radius: 0.03 });
await page.waitForTimeout(500);
await mark('Straight', [295, 262], [345, 266]);
await page.getByLabel('Note of F2', { exact: true }).fill('gone on from without Save');
await mark('Over skin', [295, 262], [345, 266]);
await page.getByRole('button', { name: 'Save', exact: true }).click();
const [, straight, over] = json('findings', 'findings.json').findings;
assert.ok(over.length_mm >= straight.length_mm - 0.01 && over.length_mm < 2 * straight.length_mm,
  `${straight.length_mm} straight, ${over.length_mm} over the skin`);
assert.ok(straight.length_bound_mm > 0);
assert.equal(straight.note, 'gone on from without Save');
assert.ok(over.path_ct_mm.length > 2);
assert.match(await item('F2').locator('.finding-title').textContent(), /^Straight \d+\.\d mm ± \d+\.\d mm$/);
await shot('findings-landscape');
if (shots) {
  await page.setViewportSize({ width: 820, height: 1180 });
  await page.waitForTimeout(600);
  await shot('findings-portrait');
  await page.setViewportSize({ width: 1180, height: 820 });
}

// Deleted and taken back.
await page.getByRole('button', { name: 'Delete F1' }).click();
await item('F1').waitFor({ state: 'detached' });
assert.equal(json('findings', 'findings.json').findings.length, 2);
await page.getByRole('button', { name: 'Undo the deletion of F1' }).click();
await item('F1').waitFor();

// A tap beside the body is answered with a sentence.
await page.getByRole('button', { name: 'Point', exact: true }).click();
await tap(4, 4);
await page.getByText('there is no body at this point').waitFor();
await page.getByRole('button', { name: 'Cancel', exact: true }).click();

// A still of each kind.
await post('/api/freeze', { frozen: false });
await page.getByRole('tab', { name: 'Take away' }).click();
for (const [key, style, width] of [['Below', 'beside', 1280], ['On it', 'burned-in', 1280], ['None', 'plain', 640]]) {
  await page.getByRole('button', { name: key, exact: true }).click();
  const downloading = page.waitForEvent('download');
  await page.getByRole('button', { name: 'Save a still' }).click();
  const download = await downloading;
  const name = download.suggestedFilename();
  const bytes = readFileSync(await download.path());
  assert.equal(bytes.readUInt32BE(16), width, `${style}: width of the PNG`);
  const beside = json('pictures', name.replace('.png', '.json'));
  assert.equal(beside.style, style);
  assert.equal(beside.sha256[name], createHash('sha256').update(bytes).digest('hex'));
  assert.equal(beside.sha256[name], sha256('pictures', name));
  assert.equal(beside.ct_from_camera.length, 12);
}

// A video, as ffprobe sees it.
await page.getByRole('button', { name: 'Record the video' }).click();
await page.waitForFunction(() => /0:0[3-9]/.test(document.querySelector('.video-figures')?.textContent ?? ''),
  undefined, { timeout: 60000 });
await shot('take-away-landscape');
await page.getByRole('button', { name: 'Stop recording' }).click();
await page.waitForFunction(() => /^Saved /.test(document.querySelector('.video-figures')?.textContent ?? ''),
  undefined, { timeout: 30000 });
const names = readdirSync(join(folder, 'videos'));
const video = names.find((name) => name.endsWith('.webm'));
assert.deepEqual(names.sort(), ['.json', '.jsonl', '.webm'].map((end) => video.replace('.webm', end)).sort());
const probed = JSON.parse(execFileSync('ffprobe', ['-v', 'error', '-count_frames', '-show_streams', '-show_format',
  '-of', 'json', join(folder, 'videos', video)], { encoding: 'utf8' }));
assert.equal(probed.streams[0].codec_name, 'vp8');
const poses = readFileSync(join(folder, 'videos', video.replace('.webm', '.jsonl')), 'utf8').trim().split('\n')
  .map((line) => JSON.parse(line));
assert.equal(poses.length, Number(probed.streams[0].nb_read_frames), 'one line a picture');
assert.ok(Math.abs(poses.at(-1).time_s - Number(probed.format.duration)) < 0.2);
assert.ok(poses.every((pose) => typeof pose.frame_id === 'number' && typeof pose.state === 'string'));
const tracked = poses.filter((pose) => pose.state === 'tracking');
assert.ok(tracked.length >= 5 && tracked.every((pose) => pose.ct_from_camera.length === 12 && pose.bound_mm > 0));
assert.ok(tracked.some((pose) => pose.marks.some((each) => each.id === 'F1')), 'the findings are in the poses');
const proof = json('videos', video.replace('.webm', '.json'));
assert.equal(proof.sha256[video], sha256('videos', video));

assert.deepEqual(live.errors.filter((error) => !/status of 400/.test(error)), []);
await live.close();
await server.stop();

// The next day.
server = await serve();
live = await LivePage.open(server.url);
({ page } = live);
await page.getByRole('tab', { name: 'Findings' }).click();
await item('F1').waitFor();
assert.equal(await page.locator('.finding-item').count(), 3);
assert.equal(await page.evaluate(() => window.pwned), undefined);
await live.close();
await server.stop();
console.log(`3 findings, 3 stills, a video of ${poses.length} pictures: all as they should be`);
