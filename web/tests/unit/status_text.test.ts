// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { describe, expect, it } from 'vitest';
import type { Status } from '../../src/api';
import { sentenceOf } from '../../src/server_error';
import {
  adviceOf, bannerOf, calibrationText, colorsText, milliseconds, millimetres, snapshotName, stateWords, touchLines, waitingBanner,
} from '../../src/status_text';

const status = (change: Partial<Status>): Status => ({
  state: 'tracking', held: false, doubts: [], bound_mm: null, starting: null, search: null,
  frozen: false, camera_error: null, ...change,
}) as Status;

describe('bannerOf', () => {
  it('is silent over a live picture', () => {
    expect(bannerOf('live', 30, '', status({}))).toBeUndefined();
  });

  it('never lets an old picture pass for a live one', () => {
    expect(bannerOf('stale', 3200, '', status({}))).toEqual(
      { kind: 'bad', text: 'The picture stands still: 3 s old' });
    expect(bannerOf('gone', Infinity, 'The server does not answer.', undefined)).toEqual(
      { kind: 'bad', text: 'No live picture. The server does not answer. Trying again …' });
    expect(bannerOf('live', 30, '', status({ camera_error: 'unplugged' }))?.kind).toBe('bad');
  });

  it('is calm where the user froze the picture', () => {
    expect(bannerOf('stale', 3200, '', status({ frozen: true }))?.kind).toBe('calm');
  });

  it('knows that the picture stands while points are tapped here, and says so elsewhere', () => {
    const picking = status({ frozen: true, starting: 'landmarks' });
    expect(bannerOf('stale', 3200, '', picking, true)).toBeUndefined();
    expect(bannerOf('stale', 3200, '', picking)?.kind).toBe('calm');
  });
});

describe('a camera that is not there yet', () => {
  it('is waited for, in words, without its secrets', () => {
    const waiting = { waiting_for_camera: 'no device is connected', case: 'head', camera: 'push:8765,token=geheim12' };
    expect(waitingBanner(waiting)).toEqual(
      { kind: 'calm', text: 'Waiting for the first picture of push:8765 – no device is connected' });
    expect(stateWords('waiting', undefined)).toBe('Waiting for the camera');
  });
});

describe('the calibration in use', () => {
  it('says where it is from, how old it is, and whether depth is corrected', () => {
    const kept = { source: 'found with a board', made_at: null, age: '12 days old', depth_corrected: true, hint: null };
    expect(calibrationText(kept)).toBe('Calibration: found with a board, 12 days old, depth corrected');
    expect(calibrationText({ ...kept, age: null, depth_corrected: false })).toBe(
      'Calibration: found with a board, depth not corrected');
  });
});

describe('the free view', () => {
  const free = (change: Partial<Status>): Status =>
    status({ colors_age_ms: 40, view: { picture: 'free' } as Status['view'], ...change });
  it('is silent while its colours are of now', () => {
    expect(bannerOf('live', 30, '', free({}))).toBeUndefined();
    expect(colorsText(free({}))).toBe('Colours of now.');
  });
  it('never lets old colours pass for those of now', () => {
    const lost = free({ state: 'lost', colors_age_ms: 3200 });
    expect(bannerOf('live', 30, '', lost)?.text).toBe('Last good picture, 3.2 s old: lost');
    expect(colorsText(lost)).toBe('Colours of 3.2 s ago.');
    expect(bannerOf('live', 30, '', free({ state: 'uncertain', colors_age_ms: 61234 }))?.text).toBe(
      'Last good picture, 61 s old: uncertain');
  });
  it('says that there are none yet', () => {
    expect(bannerOf('live', 30, '', free({ state: 'waiting', colors_age_ms: null }))?.text).toBe(
      'No colours yet: the body has not been tracked');
  });
});

describe('stateWords', () => {
  it('says how far off the picture may be', () => {
    expect(stateWords('tracking', status({ bound_mm: 0.64 }))).toBe('Tracking ≤ 0.6 mm');
    expect(stateWords('tracking', status({}))).toBe('Tracking');
    expect(stateWords('uncertain', status({ bound_mm: 7 }))).toBe('Uncertain ≤ 7.0 mm');
  });
  it('gives no figure to a pose of an earlier picture, or to none', () => {
    expect(stateWords('uncertain', status({ held: true }))).toBe('Uncertain, pose held');
    expect(stateWords('lost', status({ bound_mm: 1 }))).toBe('Lost');
    expect(stateWords('unknown', undefined)).toBe('No server');
  });
  it('tells searching from waiting for the user', () => {
    expect(stateWords('waiting', status({ starting: 'automatic' }))).toBe('Searching');
    expect(stateWords('waiting', status({ starting: 'placement' }))).toBe('Waiting for start');
  });
});

describe('adviceOf', () => {
  const search = (last: 'ambiguous' | 'not found' | null) => ({ searching: true, last, reason: '' });
  it('is silent while all is well, and over a frozen picture', () => {
    expect(adviceOf(status({}))).toBe('');
    expect(adviceOf(status({ state: 'lost', frozen: true }))).toBe('');
    expect(adviceOf(undefined)).toBe('');
  });
  it('says why a pose is uncertain', () => {
    const doubts = ['little-seen', 'jump'] as const;
    expect(adviceOf(status({ state: 'uncertain', doubts: [...doubts] }))).toBe(
      'Uncertain: little of the body is seen, moved fast');
    expect(adviceOf(status({ state: 'uncertain', held: true, doubts: ['no-body'] }))).toBe(
      'Old position held: no body in view');
  });
  it('says what helps the search', () => {
    const waiting = { state: 'waiting', starting: 'automatic' } as const;
    expect(adviceOf(status(waiting))).toContain('Searching');
    expect(adviceOf(status({ ...waiting, search: search('ambiguous') }))).toContain('more of the body');
    expect(adviceOf(status({ ...waiting, search: search('not found') }))).toContain('50 to 100 cm');
    expect(adviceOf(status({ state: 'lost', search: search(null) }))).toContain('Lost.');
    expect(adviceOf(status({ state: 'waiting', starting: 'placement' }))).toBe('');
  });
});

describe('touchLines', () => {
  it('has the point and its error, also where that is not known', () => {
    expect(touchLines({ ct_mm: [-12.4, 3.6, 700], bound_mm: 0.81, state: 'tracking' })).toEqual(
      ['error ≤ 0.8 mm', 'CT -12, 4, 700 mm']);
    expect(touchLines({ ct_mm: [0, 0, 0], bound_mm: null, state: 'tracking' })[0]).toContain('not known');
  });
});

describe('figures', () => {
  it('shows a dash for what is not known', () => {
    expect(millimetres(null)).toBe('–');
    expect(milliseconds(undefined)).toBe('–');
    expect(millimetres(0)).toBe('0.0');
    expect(milliseconds(34.6)).toBe('35');
  });
});

describe('snapshotName', () => {
  const at = new Date(2026, 0, 2, 3, 4, 5);
  it('has the case and the time', () => {
    expect(snapshotName('Kopf 17/b', at)).toBe('morgagni_Kopf-17-b_2026-01-02_03-04-05.png');
  });
  it('is a plain file name whatever the case is called', () => {
    expect(snapshotName('../../Müller <x>', at)).toBe('morgagni_Müller-x_2026-01-02_03-04-05.png');
    expect(snapshotName('', at)).toBe('morgagni_case_2026-01-02_03-04-05.png');
  });
});

describe('sentenceOf', () => {
  it('gives the server\'s words as a sentence', () => {
    expect(sentenceOf('{"error":"there is no skin at this point"}')).toBe('There is no skin at this point.');
  });
  it('has words for everything else', () => {
    for (const body of ['', '<html>', '{}', 'null', '{"error":3}']) {
      expect(sentenceOf(body)).toBe('The server gives no reason.');
    }
  });
});
