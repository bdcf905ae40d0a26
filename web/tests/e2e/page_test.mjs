// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Usage: node page_test.mjs PATTERN_SERVER WEB_ROOT [FOLDER_FOR_SCREENSHOTS [PICTURE.png]]
// Everything a finger can do on the page, against a server that only remembers what it was told.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { LivePage, runSteps, startServer } from './live_page.mjs';

const [program, webRoot, shots, picture] = process.argv.slice(2);
const server = await startServer(
  [program, '--web-root', webRoot, ...(picture ? ['--picture', picture] : [])]);
const live = await LivePage.open(server.url);
const { page } = live;

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const key = (name) => page.getByRole('button', { name, exact: true });
const shoot = async (name) => {
  if (shots) await live.screenshot(join(shots, `${name}.png`));
};
const pretend = (change) =>
  fetch(`${server.url}/api/pretend`, { method: 'POST', body: JSON.stringify(change) });
/** Waits until the server tells a view that passes. */
async function view_becomes(check) {
  const end = Date.now() + 8000;
  while (!check((await live.status())?.view ?? {})) {
    assert.ok(Date.now() < end, `the view never became ${check}`);
    await pause(100);
  }
}

async function tap(selector, share_x, share_y) {
  const box = await page.locator(selector).boundingBox();
  await page.touchscreen.tap(box.x + box.width * share_x, box.y + box.height * share_y);
  await pause(250);
}

/** Gloves: nothing that is pressed is smaller than 48 px. */
async function check_targets(where) {
  const small = await page.evaluate(() =>
    [...document.querySelectorAll('button, input')]
      .map((element) => ({ name: element.textContent, box: element.getBoundingClientRect() }))
      .filter(({ box }) => box.width > 0 && (box.width < 48 || box.height < 48))
      .map(({ name, box }) => `${name} ${box.width}x${box.height}`));
  assert.deepEqual(small, [], `too small for a finger in ${where}`);
  const overflow = await page.evaluate(
    () => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  assert.ok(overflow <= 0, `${where} is wider than the screen`);
}

async function states_are_words() {
  for (const [state, words] of [['waiting', 'Waiting for start'], ['tracking', 'Tracking'],
    ['uncertain', 'Uncertain'], ['lost', 'Lost']]) {
    await pretend({ state, starting: state === 'waiting' ? 'placement' : null });
    await live.wait_for_state(state);
    await page.locator(`.state.${state}`, { hasText: words }).waitFor();
    await shoot(`state_${state}`);
  }
  await pretend({ state: 'tracking', bound_mm: 0.64 });
  await page.locator('.state', { hasText: 'Tracking ≤ 0.6 mm' }).waitFor();
  await pretend({ state: 'uncertain', doubts: ['little-seen'], bound_mm: 3.2 });
  await page.getByText('Uncertain: little of the body is seen').waitFor();
  await page.locator('.stage.uncertain').waitFor();
  await shoot('uncertain');
  await pretend({ held: true, doubts: ['no-body'], bound_mm: null });
  await page.locator('.state', { hasText: 'Uncertain, pose held' }).waitFor();
  await page.getByText('Old position held: no body in view').waitFor();
  await pretend({ state: 'tracking', held: false, doubts: [], bound_mm: 0.64 });
  await page.getByText('Pretended body 17').waitFor();
  await page.getByText('Not a medical device').waitFor();
}

async function view_follows_the_finger() {
  await page.getByRole('slider', { name: 'Opacity' }).fill('0.3');
  await view_becomes((view) => view.opacity === 0.3);
  await page.getByRole('slider', { name: 'Hole' }).fill('1');
  await view_becomes((view) => view.hole_radius === 2);
  await page.getByRole('slider', { name: 'Hole' }).fill('0.4');
  await key('bone').click();
  await view_becomes((view) => view.structures?.bone === false);
  const box = await page.locator('.stage').boundingBox();
  await page.mouse.move(box.x + box.width * 0.5, box.y + box.height * 0.5);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.25, box.y + box.height * 0.5, { steps: 6 });
  await shoot('hole_dragged');
  await page.mouse.up();
  await view_becomes((view) => Math.abs(view.hole_x - 0.25) < 0.01);
  await page.locator('.stage').dblclick();
  await view_becomes((view) => view.hole_x === 0.5 && view.hole_y === 0.5);
}

async function start_automatically() {
  await key('Automatic').click();
  await page.locator('.state', { hasText: 'Searching' }).waitFor();
  await page.getByText('Searching: point the camera at the body').waitFor();
  await shoot('searching');
  await pretend({ search: { searching: true, last: 'ambiguous', reason: 'two poses' } });
  await page.getByText('move the camera so that more of the body is seen').waitFor();
  await shoot('ambiguous');
  await pretend({ state: 'tracking', starting: null, search: null });
  await page.locator('.state.tracking').waitFor();
}

async function touch_says_the_error() {
  await pause(500);
  await tap('.stage', 0.3, 0.4);
  await page.locator('.readout .words', { hasText: 'error ≤ 1.3 mm' }).waitFor();
  await shoot('touched');
  await tap('.stage', 0.02, 0.5);
  await page.getByText('The camera has no depth at that point.').waitFor();
  assert.ok(!(await page.locator('.readout .words').isVisible()), 'the old point stays');
}

async function start_by_placement() {
  await key('Placement').click();
  await page.waitForFunction(() => window.morgagni.status.starting === 'placement');
  await page.getByText('Move the camera until the body and the outline match').waitFor();
  await key('Back').click();
  assert.equal(await key('Back').getAttribute('aria-pressed'), 'true');
  await check_targets('placement');
  await shoot('placement');
  await key('Close').click();
  await page.waitForFunction(() => window.morgagni.status.starting === 'automatic');
  await key('Placement').click();
  await page.waitForFunction(() => window.morgagni.status.starting === 'placement');
  await pretend({ state: 'tracking', starting: null });
  await page.getByText('The body is found').waitFor();
  await key('Landmarks').waitFor();
}

async function start_by_landmarks() {
  await key('Landmarks').click();
  await page.locator('.skin img[data-ready]').waitFor();
  await page.waitForFunction(() => window.morgagni.status.starting === 'landmarks');
  await tap('.skin', 0.02, 0.02);
  await page.getByText('There is no skin at that point.').waitFor();
  await tap('.skin', 0.4, 0.4);
  await key('Accept').click();
  await page.getByText('At least 3 pairs are needed, got 0.').waitFor();
  await tap('.stage', 0.4, 0.4);
  await tap('.stage', 0.6, 0.45);
  await tap('.skin', 0.6, 0.45);
  await tap('.skin', 0.5, 0.6);
  assert.equal(await page.locator('.skin .mark').count(), 3);
  await tap('.stage', 0.5, 0.6);
  await page.locator('.fre', { hasText: '2.4' }).waitFor();
  await page.getByText('2.9 mm').waitFor();
  await check_targets('landmarks');
  await shoot('landmarks');
  await key('Undo').click();
  await page.locator('.fre', { hasText: '–' }).waitFor();
  await key('Head').click();
  await page.waitForFunction(() => document.querySelectorAll('.skin .mark').length === 0);
  await page.locator('.chip').first().click();
  await page.waitForFunction(() => document.querySelectorAll('.skin .mark').length === 2);
  await tap('.skin', 0.55, 0.6);
  await tap('.stage', 0.55, 0.6);
  await key('Accept').click();
  await key('Placement').waitFor();
  assert.equal(await page.locator('.mark').count(), 0, 'landmarks stay on the live picture');

  // At once again, while the last status still speaks of the first time.
  await key('Landmarks').click();
  await pause(1000);
  await key('Cancel').waitFor();
  await key('Cancel').click();
  await page.waitForFunction(() => window.morgagni.status.starting === null);
}

/** Fingers on the free view, as the browser makes events of them. */
async function fingers(...steps) {
  const session = await page.context().newCDPSession(page);
  const box = await page.locator('.stage').boundingBox();
  for (const [type, ...points] of steps) {
    await session.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) =>
      ({ x: box.x + x * box.width, y: box.y + y * box.height, id })) });
    await pause(60);
  }
  await session.detach();
}

async function free_view_by_hand() {
  await page.getByRole('tab', { name: 'Surface' }).click();
  await check_targets('the surface topic');
  await page.getByRole('button', { name: 'Free view' }).click();
  await view_becomes((view) => view.picture === 'free');
  await page.getByText('Colours of now.').waitFor();
  const { hole_x } = (await live.status()).view;
  await fingers(['touchStart', [0.5, 0.5]], ['touchMove', [0.4, 0.5]], ['touchMove', [0.3, 0.6]], ['touchEnd']);
  await view_becomes((view) => view.free_yaw > 0.3 && view.free_pitch > 0.1);
  assert.equal((await live.status()).view.hole_x, hole_x, 'the hole moved with the body');
  await fingers(['touchStart', [0.4, 0.5], [0.6, 0.5]], ['touchMove', [0.35, 0.5], [0.65, 0.5]],
    ['touchMove', [0.3, 0.4], [0.7, 0.4]], ['touchEnd']);
  await view_becomes((view) => view.free_zoom > 2 && view.free_target_mm[2] < 0);
  await page.mouse.move(500, 400);
  await page.mouse.wheel(0, 120);
  await view_becomes((view) => view.free_zoom < 2.5);
  await key('Left').click();
  await view_becomes((view) => view.free_yaw === Math.PI / 2 && view.free_pitch === 0);
  await key('Fused').click();
  await view_becomes((view) => view.free_colors === 'fused' && view.free_bare_skin);
  await page.getByText('Colours of the fused texture').waitFor();
  await key('Live').click();
  await key('Skin without colours').click();
  await view_becomes((view) => view.free_colors === 'live' && !view.free_bare_skin);
  await key('Skin without colours').click();
  await key('Hole in the skin').click();
  await view_becomes((view) => view.free_bare_skin && view.free_hole);
  await shoot('surface');
  await pretend({ state: 'lost', colors_age_ms: 4200 });
  await page.locator('.banner', { hasText: 'Last good picture, 4.2 s old: lost' }).waitFor();
  await shoot('surface_lost');
  await pretend({ state: 'tracking', colors_age_ms: 40 });
  await key('Reset').click();
  await view_becomes((view) => view.free_yaw === 0 && view.free_zoom === 1.3 && view.free_target_mm[0] === 0);
  await page.getByRole('tab', { name: 'Look' }).click();
  await key('Placement').click();
  await view_becomes((view) => view.picture === 'camera');
  await key('Close').click();
  await pretend({ state: 'tracking', starting: null });
}

async function freeze_and_snapshot() {
  await key('Freeze').click();
  await page.getByText('Frozen: this is not the live picture').waitFor();
  await shoot('frozen');
  await key('Live again').click();
  await key('Freeze').waitFor();
  const download = page.waitForEvent('download');
  await key('Snapshot').click();
  assert.match((await download).suggestedFilename(),
    /^morgagni_Pretended-body-17_\d{4}-\d\d-\d\d_\d\d-\d\d-\d\d\.png$/);
}

async function other_screens() {
  for (const [width, height] of [[1180, 820], [820, 1180], [768, 1024], [390, 844], [844, 390],
    [1024, 768]]) {
    await page.setViewportSize({ width, height });
    await pause(300);
    await check_targets(`${width}x${height}`);
    await shoot(`screen_${width}x${height}`);
  }
}

async function fingers_fit() {
  await check_targets('the live view');
}

await runSteps({ live, server, shoot, is_expected: (text) => text.includes('422') }, [
  fingers_fit, states_are_words, view_follows_the_finger, start_automatically, touch_says_the_error,
  start_by_placement, start_by_landmarks, free_view_by_hand, freeze_and_snapshot, other_screens,
]);
