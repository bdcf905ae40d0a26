// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Usage: node overlay_truth_test.mjs MORGAGNI WEB_ROOT SCRATCH [FOLDER_FOR_SCREENSHOTS]
// The whole line on a real CT: prepare, record with a simulated camera that knows its true poses, serve
// the recording, and look at the video that arrives in a real browser. The bones must be seen where
// the true pose of each frame projects them, computed here from scratch.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';

import { LivePage, startServer } from '../../web/tests/e2e/live_page.mjs';
import { makeDemoCase, recordDemoCase } from './demo_case.mjs';
import { overlap, readPly, readTruth, silhouette } from './silhouette.mjs';

const NUM_FRAMES = 45;
const NUM_GRABBED = 60;
const MIN_COMPARED = 8;
/** The hole darkens the skin in it, to no less than this share. A pixel that is no darker form of the plain one,
 * by more than the codec changes it, shows bone. Sum of three channels, of 765. */
const DARKEST = 0.4;
const CHANGED = 20;
const MIN_OVERLAP = 0.85;
/** The seen bones fit best where they are expected, to within this many px each way. */
const MAX_SHIFT_PX = 1;
const SEARCH_PX = 4;

const [program, webRoot, scratch, shots] = process.argv.slice(2);
const folder = makeDemoCase(program, scratch);
const recording = recordDemoCase(program, folder, NUM_FRAMES);

const bones = await readPly(join(folder, 'bone.ply'));
const truth = await readTruth(recording);
const camera = JSON.parse(readFileSync(join(recording, 'intrinsics.json'), 'utf8'));

const server = await startServer([
  program, 'serve', '--case', folder, '--camera', `tum:${recording},loop=1`, '--port', '0',
  '--web', webRoot, '--bitrate-kbps', '20000']);
const live = await LivePage.open(server.url);

async function grab(opacity) {
  const response = await fetch(`${server.url}/api/view`, {
    method: 'POST', body: JSON.stringify({ opacity, hole_radius: 2 }) });
  assert.equal(response.status, 200, await response.text());
  await new Promise((resolve) => setTimeout(resolve, 1000));
  const byFrame = new Map();
  for (const frame of await live.grab_frames(NUM_GRABBED)) {
    if (frame.info?.state === 'tracking') byFrame.set(frame.info.frame_id, frame.pixels);
  }
  return byFrame;
}

function bonePixels(plain, seen) {
  const mask = new Uint8Array(plain.length / 4);
  for (let i = 0; i < mask.length; i++) {
    const a = [0, 1, 2].map((channel) => plain[4 * i + channel]);
    const b = [0, 1, 2].map((channel) => seen[4 * i + channel]);
    const dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    const share = Math.min(1, Math.max(DARKEST, dot(a, b) / Math.max(dot(a, a), 1)));
    mask[i] = a.reduce((sum, value, channel) => sum + Math.abs(b[channel] - share * value), 0) > CHANGED ? 1 : 0;
  }
  return mask;
}

function bestShift(seen, expected) {
  let best = { overlap: -1 };
  for (let dy = -SEARCH_PX; dy <= SEARCH_PX; dy++) {
    for (let dx = -SEARCH_PX; dx <= SEARCH_PX; dx++) {
      const share = overlap(seen, expected, camera.width, camera.height, dx, dy);
      if (share > best.overlap) best = { overlap: share, dx, dy };
    }
  }
  return best;
}

try {
  const first_picture_ms = await live.wait_for_picture();
  await live.wait_for_state('tracking', 60000);
  if (shots) await live.screenshot(join(shots, 'live.png'));
  const plain = await grab(0);
  const withBones = await grab(1);
  const results = [];
  for (const [frameId, pixels] of withBones) {
    if (!plain.has(frameId)) continue;
    const expected = silhouette(bones, camera, truth[frameId]);
    results.push({ frameId, ...bestShift(bonePixels(plain.get(frameId), pixels), expected) });
  }
  console.log(JSON.stringify({ first_picture_ms, results, page: await live.measure(5000), status: await live.status() }, null, 1));
  assert.ok(results.length >= MIN_COMPARED, `only ${results.length} frames were seen with and without bones`);
  for (const { frameId, overlap: share, dx, dy } of results) {
    assert.ok(share >= MIN_OVERLAP, `frame ${frameId}: seen and expected bones share only ${share.toFixed(3)}`);
    assert.ok(Math.max(Math.abs(dx), Math.abs(dy)) <= MAX_SHIFT_PX, `frame ${frameId}: the bones are off by (${dx}, ${dy}) px`);
  }
  assert.deepEqual(live.errors, []);
} finally {
  await live.close();
  assert.equal(await server.stop(), 0, 'serve ends cleanly');
}
