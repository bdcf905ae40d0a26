// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { describe, expect, it } from 'vitest';
import { ClockSync } from '../../src/clock_sync';
import { FrameMeter } from '../../src/frame_meter';

describe('ClockSync', () => {
  it('knows nothing before the first round trip', () => {
    expect(new ClockSync().toServer(5)).toBeUndefined();
  });

  it('trusts the shortest round trip', () => {
    const clock = new ClockSync();
    // True offset 1000; the slow trip spent all of its time on the way back.
    clock.add(0, 1000, 80);
    clock.add(100, 1102, 104);
    expect(clock.toServer(200)).toBe(1200);
  });

  it('ignores clocks that run backwards', () => {
    const clock = new ClockSync();
    clock.add(100, 1, 50);
    expect(clock.toServer(0)).toBeUndefined();
  });

  it('follows the recent trips', () => {
    const clock = new ClockSync();
    clock.add(0, 500, 2);
    for (let i = 1; i <= 16; ++i) clock.add(i * 100, i * 100 + 702, i * 100 + 4);
    expect(clock.toServer(0)).toBe(700);
  });
});

describe('FrameMeter', () => {
  it('measures the rate of the last two seconds', () => {
    const meter = new FrameMeter();
    for (let i = 0; i < 100; ++i) meter.add(i * 40, undefined);
    expect(meter.frameRate(3960)).toBeCloseTo(25, 6);
    expect(meter.frameRate(99999)).toBe(0);
  });

  it('gives the median latency of the pictures that have one', () => {
    const meter = new FrameMeter();
    expect(meter.latencyMs()).toBeUndefined();
    [30, undefined, 900, 35].forEach((latency, i) => meter.add(i, latency));
    expect(meter.latencyMs()).toBe(35);
  });
});
