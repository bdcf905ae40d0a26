// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Usage: node stream_test.mjs PATTERN_SERVER WEB_ROOT
// The stream in a real Chromium: pictures come fast enough, and each one is the picture that its
// words speak of. Prints the measures as JSON; exit code 1 and a sentence where one fails.

import assert from 'node:assert/strict';
import { LivePage, startServer } from './live_page.mjs';

const BIT_PX = 16;
const NUM_BITS = 24;

/** The number that the test pattern wrote into its lower edge. */
function numberInPixels({ width, height, pixels }) {
  let number = 0;
  for (let bit = 0; bit < NUM_BITS; ++bit) {
    const x = bit * BIT_PX + BIT_PX / 2;
    const y = height - BIT_PX / 2;
    const value = pixels[(y * width + x) * 4];
    assert.ok(value < 64 || value > 192, `bit ${bit} is neither black nor white: ${value}`);
    number = number * 2 + (value > 128 ? 1 : 0);
  }
  return number;
}

function checkStep(frames, what) {
  for (const frame of frames) {
    assert.ok(frame.info, `${what}: a picture came without its words`);
    assert.equal(frame.info.rtp, frame.rtp);
    assert.equal(numberInPixels(frame), frame.info.frame_id, `${what}: words of another picture`);
  }
  const ids = frames.map((frame) => frame.info.frame_id);
  assert.deepEqual(ids, [...new Set(ids)].sort((a, b) => a - b), `${what}: out of order`);
}

async function pretend(url, change) {
  const response = await fetch(`${url}/api/pretend`, { method: 'POST', body: JSON.stringify(change) });
  assert.equal(response.status, 200);
}

async function until(what, check, timeout_ms = 15000) {
  const end = Date.now() + timeout_ms;
  while (!(await check())) {
    assert.ok(Date.now() < end, `not in time: ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
}

const [program, webRoot] = process.argv.slice(2);
const command = [program, '--web-root', webRoot, '--max-viewers', '2'];
let server = await startServer(command);
const port = new URL(server.url).port;
const pages = [];
const open = async () => {
  pages.push(await LivePage.open(server.url));
  return pages.at(-1);
};
const live = await open();
const report = {};
try {
  report.first_picture_ms = await live.wait_for_picture();

  const measured = await live.measure(5000);
  Object.assign(report, measured);
  assert.ok(measured.frame_rate >= 20, `only ${measured.frame_rate.toFixed(1)} pictures a second`);
  assert.ok(measured.with_info >= measured.frames * 0.95, 'the words come too late');

  checkStep(await live.grab_frames(20), '640x480');

  await pretend(server.url, { width: 641, height: 479 });
  await live.page.waitForFunction(() => window.morgagni.live.video.videoWidth === 641);
  checkStep(await live.grab_frames(5), '641x479');
  await pretend(server.url, { width: 640, height: 480 });

  // A second viewer changes nothing for the first; a third is told why it has to wait.
  const second = await open();
  await second.wait_for_picture();
  checkStep(await second.grab_frames(3), 'the second viewer');
  const third = await open();
  await third.page.getByText('All places for viewers are taken').waitFor();
  await second.close();
  await third.wait_for_picture();
  await third.close();
  assert.equal(await live.page.evaluate(() => window.morgagni.live.state()), 'live');

  // A standing picture is called old, and is live again afterwards.
  await pretend(server.url, { stalls: true });
  await live.page.getByText('The picture stands still').waitFor();
  await pretend(server.url, { stalls: false });
  await until('live again', () => live.page.evaluate(() => window.morgagni.live.state() === 'live'));

  // Who comes to a standing picture sees it all the same.
  await pretend(server.url, { stalls: true });
  const late = await open();
  await until('a standing picture is shown',
    () => late.page.evaluate(() => window.morgagni.live.video.videoWidth === 640));
  await late.close();
  await pretend(server.url, { stalls: false });

  // The server goes and comes again: the page finds it by itself.
  await server.stop();
  await live.page.getByText('No live picture').waitFor();
  await live.page.getByText('No server').waitFor();
  server = await startServer([...command, '--port', port]);
  await until('connected again',
    () => live.page.evaluate(() => window.morgagni.live.state() === 'live'), 20000);
  checkStep(await live.grab_frames(5), 'after a restart');
  console.log(JSON.stringify(report, null, 2));
} catch (error) {
  console.error(error.message, '\n', server.log.slice(-10).join('\n'));
  process.exitCode = 1;
} finally {
  await Promise.all(pages.map((page) => page.close()));
  await server.stop();
}
