// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { describe, expect, it } from 'vitest';
import { hintOf, partOf } from '../../src/calibrate/hint';
import { countOf, shareOf } from '../../src/calibrate/progress';
import { asSentence } from '../../src/calibrate/sentence';

describe('the calibration page', () => {
  it('finds the picture for each thing that the server asks for', () => {
    expect(hintOf('tilt the board so that its left edge is nearer to the camera')).toBe('left');
    expect(hintOf('tilt the board so that its right edge is nearer to the camera')).toBe('right');
    expect(hintOf('tilt the board so that its upper edge is nearer to the camera')).toBe('upper');
    expect(hintOf('tilt the board so that its lower edge is nearer to the camera')).toBe('lower');
    expect(hintOf('change the distance: so far the board was 50 to 60 cm away')).toBe('distance');
    expect(hintOf('hold the board at the left edge of the picture')).toBe('place');
    expect(hintOf('now hang the board on a flat wall, or lay it on a wide table, for 10 views from 50 to 120 cm')).toBe('wall');
    expect(hintOf('4 more of the board on the wall, each from another distance')).toBe('wall');
    expect(hintOf('take 3 more, each in another pose')).toBe('more');
  });

  it('finds the part of the picture that is meant', () => {
    expect(partOf('hold the board at the upper left corner of the picture')).toEqual([0, 0]);
    expect(partOf('hold the board at the right edge of the picture')).toEqual([2, 1]);
    expect(partOf('hold the board at the lower edge of the picture')).toEqual([1, 2]);
    expect(partOf('hold the board at the middle of the picture')).toEqual([1, 1]);
  });

  it('counts the hand and the wall apart', () => {
    const counts = { views: 26, wanted_views: 20, views_on_wall: 2, wanted_on_wall: 10 };
    expect(countOf(counts)).toBe('24 of 20 views in the hand, 2 of 10 on the wall');
    expect(shareOf(counts)).toBeCloseTo(22 / 30);
    const lensesOnly = { views: 5, wanted_views: 20, views_on_wall: 0, wanted_on_wall: 0 };
    expect(countOf(lensesOnly)).toBe('5 of 20 views in the hand');
    expect(shareOf(lensesOnly)).toBeCloseTo(0.25);
  });

  it('writes whole sentences', () => {
    expect(asSentence('hold still')).toBe('Hold still.');
    expect(asSentence('Is it flat?')).toBe('Is it flat?');
    expect(asSentence('')).toBe('');
  });
});
