// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Usage: node push_page_test.mjs MORGAGNI WEB_ROOT SCRATCH [FOLDER_FOR_SCREENSHOTS]
// examples/push_page in a real Chromium pushes a recording to `serve`, which finds and tracks the body in it, and to
// `calibrate --page`; both pages are there before any device is.

import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { join } from 'node:path';
import { createInterface } from 'node:readline';

import { LivePage } from '../../web/tests/e2e/live_page.mjs';

const [program, webRoot, scratch, shots] = process.argv.slice(2);
const DEMO_PROJECT = '/usr/share/doc/invesalius-examples/examples/Cranium.inv3';
if (!existsSync(DEMO_PROJECT)) {
  console.log(`skipped: ${DEMO_PROJECT} is not installed (Debian package invesalius-examples)`);
  process.exit(77);
}

rmSync(scratch, { recursive: true, force: true });
mkdirSync(scratch, { recursive: true });
const folder = join(scratch, 'case');
const recording = join(scratch, 'recording');
execFileSync('bash', ['-c', `. scripts/demo_ct.sh && make_demo_ct '${scratch}'`]);
execFileSync(program, ['prepare', join(scratch, 'head.mhd'), '--case', folder, '--vertices', '8000']);
execFileSync(program, ['record', '--case', folder, '--camera', 'simulated:seed=5,distance=450', '--frames', '40', '--out', recording]);

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

/** The program with a camera that is pushed: `says` waits for what it prints, `stop` ends it well. */
function startForPush(args) {
  const server = spawn(program, [...args, '--camera', 'push:0', '--port', '0', '--web', webRoot],
    { stdio: ['ignore', 'pipe', 'pipe'], env: { ...process.env, MORGAGNI_CAMERAS_DIR: cameras } });
  const log = [];
  for (const stream of [server.stdout, server.stderr]) createInterface(stream).on('line', (line) => log.push(line));
  return {
    async says(pattern, timeout_ms = 120000) {
      const until = Date.now() + timeout_ms;
      while (Date.now() < until) {
        const found = log.map((line) => pattern.exec(line)).find(Boolean);
        if (found) return found[0];
        await new Promise((resolve) => setTimeout(resolve, 50));
      }
      throw new Error(`morgagni never said ${pattern}:\n${log.join('\n')}`);
    },
    async stop() {
      server.kill('SIGTERM');
      const code = await new Promise((resolve) => server.once('exit', resolve));
      assert.equal(code, 0, log.join('\n'));
    },
  };
}

const { says, stop } = startForPush(['serve', '--case', folder]);

const pushed = await says(/ws:\/\/127\.0\.0\.1:\d+/);
// The page is there before any device is, and says what it waits for.
const live = await LivePage.open(await says(/http:\/\/127\.0\.0\.1:\d+/), { width: 1180, height: 820 });
await live.page.getByText(`Waiting for the first picture of push:0 – no device is connected: it must push to ${pushed}`).waitFor();
await live.page.getByText('Waiting for the camera').waitFor();
if (shots) {
  await live.screenshot(join(shots, 'push_waiting.png'));
  await live.page.setViewportSize({ width: 820, height: 1180 });
  await live.screenshot(join(shots, 'push_waiting_portrait.png'));
  await live.page.setViewportSize({ width: 1180, height: 820 });
}
const device = await LivePage.open(`http://localhost:${served.address().port}/`, { width: 820, height: 1180 });
await device.page.fill('#address', `${pushed}/?device=bench`);
await device.page.setInputFiles('#folder', recording);
await device.page.click('#start');
await live.wait_for_picture(60000); // By itself.
await live.wait_for_state('tracking', 120000);
assert.match(await device.page.textContent('#said'), /^\d+ frames pushed\.$/);
const { bound_mm, calibration } = await live.status();
assert.equal(calibration.source, 'found with a board');
assert.match(calibration.age, /^\d+ days old$/);
assert.match(calibration.hint, /half a year old/);
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
await stop();

// The same with the calibration's page: it waits, and goes on by itself once something is pushed.
const calibration_server = startForPush(['calibrate', '--page', '--device', 'push-bench']);
const pushed_there = await calibration_server.says(/ws:\/\/127\.0\.0\.1:\d+/);
const board = await LivePage.open(await calibration_server.says(/http:\/\/127\.0\.0\.1:\d+\/calibrate\.html/),
  { width: 1180, height: 820 });
await board.page.getByText(`Waiting for the first picture of push:0 – no device is connected: it must push to ${pushed_there}`).waitFor();
assert.equal(await board.page.getByRole('button', { name: 'Calculate' }).isVisible(), false, 'nothing to press yet');
if (shots) await board.screenshot(join(shots, 'push_calibrate_waiting.png'));
await device.page.fill('#address', `${pushed_there}/?device=bench`);
await device.page.click('#start');
await board.wait_for_picture(60000);
await board.page.getByRole('button', { name: 'Calculate' }).waitFor();
assert.ok(await board.page.getByText('in use: board').isVisible());
if (shots) await board.screenshot(join(shots, 'push_calibrate.png'));

await device.close();
await board.close();
served.close();
await calibration_server.stop();
console.log(`tracked what a page pushed (bound ${bound_mm ?? 'none'} mm), and again after it had gone; calibrate waits for it too`);
