// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { describe, expect, it } from 'vitest';
import type { Status } from '../../src/api';
import { sentenceOf } from '../../src/server_error';
import { bannerOf, milliseconds, millimetres, snapshotName } from '../../src/status_text';

const status = (change: Partial<Status>): Status => ({
  state: 'tracking', starting: null, frozen: false, camera_error: null, ...change,
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
