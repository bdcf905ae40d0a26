// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Usage: node push_page_test.mjs MORGAGNI WEB_ROOT SCRATCH [FOLDER_FOR_SCREENSHOTS]
// examples/push_page in a real Chromium pushes a recording to `serve`, which finds and tracks the body in it, and to
// `calibrate --page`; both pages are there before any device is.

import assert from 'node:assert/strict';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { join } from 'node:path';

import { LivePage, startServer } from '../../web/tests/e2e/live_page.mjs';
import { makeDemoCase, recordDemoCase } from './demo_case.mjs';

const [program, webRoot, scratch, shots] = process.argv.slice(2);
const folder = makeDemoCase(program, scratch, '--vertices', '8000');
const recording = recordDemoCase(program, folder, 40);

const served = createServer((_, response) => {
  response.setHeader('Content-Type', 'text/html');
  response.end(readFileSync('examples/push_page/index.html'));
}).listen(0, '127.0.0.1');
// What is kept of the device: what it says itself, found with a board long ago.
const cameras = join(scratch, 'cameras');
const { width, height, fx, fy, cx, cy, distortion } = JSON.parse(readFileSync(join(recording, 'intrinsics.json'), 'utf8'));
const pinhole = { width, height, fx, fy, cx, cy, distortion };
mkdirSync(join(cameras, 'push-bench'), { recursive: true });
writeFileSync(join(cameras, 'push-bench', '2024-01-31T10-00-00Z.json'), JSON.stringify({ device_id: 'push-bench',
  made_at: '2024-01-31T10:00:00Z', made_by: 'board', figures: {},
  calibration: { depth: pinhole, color: pinhole, color_from_depth: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]],
    origin: 'board, 2024-01-31T10:00:00Z' } }));

const WINDOW = { width: 1180, height: 820 };
const PUSHED = /ws:\/\/127\.0\.0\.1:\d+/;

/** The program, whose camera is pushed, and where to. */
async function startForPush(...parameters) {
  const server = await startServer([program, ...parameters, '--camera', 'push:0', '--port', '0', '--web', webRoot],
    { env: { ...process.env, MORGAGNI_CAMERAS_DIR: cameras } });
  return { server, pushed: await server.says(PUSHED) };
}

const { server, pushed } = await startForPush('serve', '--case', folder);
// The page is there before any device is, and says what it waits for.
const live = await LivePage.open(server.url, WINDOW);
await live.page.getByText(`Waiting for the first picture of push:0 – no device is connected: it must push to ${pushed}`).waitFor();
await live.page.getByText('Waiting for the camera').waitFor();
if (shots) {
  await live.screenshot(join(shots, 'push_waiting.png'));
  await live.page.setViewportSize({ width: 820, height: 1180 });
  await live.screenshot(join(shots, 'push_waiting_portrait.png'));
  await live.page.setViewportSize(WINDOW);
}
const device = await LivePage.open(`http://localhost:${served.address().port}/`, { width: 820, height: 1180 });
await device.page.fill('#address', `${pushed}/?device=bench`);
await device.page.setInputFiles('#folder', recording);
await device.page.click('#start');
await live.wait_for_picture(60000); // By itself.
await live.wait_for_state('tracking', 120000);
assert.match(await device.page.textContent('#said'), /^\d+ frames pushed\.$/);
const { bound_mm, calibration: in_use } = await live.status();
assert.equal(in_use.source, 'found with a board');
assert.match(in_use.age, /^\d+ days old$/);
assert.match(in_use.hint, /half a year old/);
await live.page.getByText('Calibration: found with a board').waitFor();
if (shots) {
  await device.screenshot(join(shots, 'push_page.png'));
  await live.screenshot(join(shots, 'push_tracked.png'));
  await live.page.setViewportSize({ width: 820, height: 1180 });
  await live.screenshot(join(shots, 'push_tracked_portrait.png'));
}

// The page is gone: said; and back: it goes on by itself.
await device.page.click('#stop');
await live.page.waitForFunction(() => JSON.stringify(window.morgagni.status).includes('no device is connected'), undefined, { timeout: 10000 });
await device.page.click('#start');
await live.wait_for_state('tracking', 60000);

await live.close();
assert.equal(await server.stop(), 0, server.log.join('\n'));

// The same with the calibration's page: it waits, and goes on by itself once something is pushed.
const calibration = await startForPush('calibrate', '--page', '--device', 'push-bench');
const board = await LivePage.open(`${calibration.server.url}/calibrate.html`, WINDOW);
await board.page.getByText(`Waiting for the first picture of push:0 – no device is connected: it must push to ${calibration.pushed}`).waitFor();
assert.equal(await board.page.getByRole('button', { name: 'Calculate' }).isVisible(), false, 'nothing to press yet');
if (shots) await board.screenshot(join(shots, 'push_calibrate_waiting.png'));
await device.page.fill('#address', `${calibration.pushed}/?device=bench`);
await device.page.click('#start');
await board.wait_for_picture(60000);
await board.page.getByRole('button', { name: 'Calculate' }).waitFor();
assert.ok(await board.page.getByText('in use: board').isVisible());
if (shots) await board.screenshot(join(shots, 'push_calibrate.png'));

await device.close();
await board.close();
served.close();
assert.equal(await calibration.server.stop(), 0, calibration.server.log.join('\n'));
console.log(`tracked what a page pushed (bound ${bound_mm ?? 'none'} mm), and again after it had gone; calibrate waits for it too`);
