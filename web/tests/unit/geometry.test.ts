// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { describe, expect, it } from 'vitest';
import { containedBox, fromPicture, toPicture, toServer } from '../../src/geometry';

const picture = { width: 640, height: 480 };

describe('pictures in boxes', () => {
  it('lies in the middle of a box that is too high', () => {
    expect(containedBox({ width: 320, height: 400 }, picture)).toEqual(
      { x: 0, y: 80, width: 320, height: 240 });
  });

  it('lies in the middle of a box that is too wide', () => {
    expect(containedBox({ width: 1000, height: 480 }, picture)).toEqual(
      { x: 180, y: 0, width: 640, height: 480 });
  });

  it('finds the pixel under a finger, and none beside the picture', () => {
    const box = { width: 320, height: 400 };
    expect(toPicture({ x: 160, y: 200 }, box, picture)).toEqual({ x: 320, y: 240 });
    expect(toPicture({ x: 160, y: 79 }, box, picture)).toBeUndefined();
    expect(toPicture({ x: 160, y: 321 }, box, picture)).toBeUndefined();
    expect(toPicture({ x: 1, y: 1 }, { width: 0, height: 0 }, picture)).toBeUndefined();
  });

  it('names pixels as the server does, from the middle of the first one', () => {
    const middle = toPicture({ x: 0.25, y: 80.25 }, { width: 320, height: 400 }, picture);
    expect(toServer(middle!)).toEqual({ x: 0, y: 0 });
  });

  it('comes back to where it was', () => {
    const box = { width: 747, height: 613 };
    const there = fromPicture({ x: 100.5, y: 400.25 }, box, picture);
    const back = toPicture(there, box, picture);
    expect(back?.x).toBeCloseTo(100.5, 9);
    expect(back?.y).toBeCloseTo(400.25, 9);
  });
});
