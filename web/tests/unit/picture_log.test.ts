// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { describe, expect, it } from 'vitest';
import { asPictureInfo, PictureLog } from '../../src/picture_log';

describe('PictureLog', () => {
  it('forgets the oldest pictures first', () => {
    const log = new PictureLog(3);
    for (let rtp = 1; rtp <= 4; ++rtp) log.add({ rtp, captured_ms: rtp * 10 });
    expect(log.get(1)).toBeUndefined();
    expect(log.get(2)?.captured_ms).toBe(20);
    expect(log.get(4)?.captured_ms).toBe(40);
  });

  it('keeps the later words about the same stamp', () => {
    const log = new PictureLog(2);
    log.add({ rtp: 1, captured_ms: 10 });
    log.add({ rtp: 2, captured_ms: 20 });
    log.add({ rtp: 1, captured_ms: 30 });
    log.add({ rtp: 3, captured_ms: 40 });
    expect(log.get(1)?.captured_ms).toBe(30);
    expect(log.get(2)).toBeUndefined();
  });
});

describe('asPictureInfo', () => {
  it('takes messages about pictures only', () => {
    expect(asPictureInfo({ rtp: 4294967295, captured_ms: 1, frame_id: 7 })?.frame_id).toBe(7);
    for (const other of [null, 3, 'x', {}, { pong: 1, server_ms: 2 }, { rtp: '1', captured_ms: 1 }]) {
      expect(asPictureInfo(other)).toBeUndefined();
    }
  });
});
