// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { describe, expect, it } from 'vitest';
import { FIRST_VIEWPOINT, mmPerPixel, panned, turned, zoomed, type FreeViewpoint } from '../../src/free_view';

const shown = { width: 800, height: 600 };
const radius_mm = 200;
const from = (change: Partial<FreeViewpoint>): FreeViewpoint => ({ ...FIRST_VIEWPOINT, ...change });

describe('turned', () => {
  it('turns the body with the finger, and stops over its head', () => {
    const view = turned(from({ free_zoom: 1 }), { x: 400, y: 0 }, shown);
    expect(view.free_yaw).toBeCloseTo(-Math.PI / 2);
    expect(turned(view, { x: 0, y: 5000 }, shown).free_pitch).toBe(Math.PI / 2);
  });

  it('is slower where it is zoomed in', () => {
    const fast = turned(from({ free_zoom: 1 }), { x: 80, y: 0 }, shown).free_yaw;
    const slow = turned(from({ free_zoom: 9 }), { x: 80, y: 0 }, shown).free_yaw;
    expect(slow).toBeCloseTo(fast / 3);
  });
});

describe('panned', () => {
  it('lets the body follow the finger: from the front, right is the left of the body', () => {
    const by = 10 * mmPerPixel(1.3, radius_mm, shown);
    const [x, y, z] = panned(from({}), { x: 10, y: -10 }, radius_mm, shown).free_target_mm;
    expect(x).toBeCloseTo(-by);
    expect(y).toBeCloseTo(0);
    expect(z).toBeCloseTo(-by);
  });

  it('keeps the body within reach', () => {
    const target = panned(from({}), { x: 1e6, y: 0 }, radius_mm, shown).free_target_mm;
    expect(Math.abs(target[0])).toBe(300);
  });
});

describe('zoomed', () => {
  it('leaves what is under the fingers where it is', () => {
    const before = from({ free_yaw: 0.7, free_pitch: 0.4 });
    const at = { x: 120, y: -70 };
    const after = zoomed(before, 2, at, radius_mm, shown);
    expect(after.free_zoom).toBeCloseTo(2.6);
    // What was there, in the picture of now: back to where it was.
    const there = panned(before, { x: -at.x, y: -at.y }, radius_mm, shown).free_target_mm;
    const now = panned(after, { x: -at.x, y: -at.y }, radius_mm, shown).free_target_mm;
    there.forEach((value, i) => expect(now[i]).toBeCloseTo(value));
  });

  it('has ends', () => {
    expect(zoomed(from({}), 1e9, { x: 0, y: 0 }, radius_mm, shown).free_zoom).toBe(20);
    expect(zoomed(from({}), 1e-9, { x: 0, y: 0 }, radius_mm, shown).free_zoom).toBe(0.3);
  });
});
