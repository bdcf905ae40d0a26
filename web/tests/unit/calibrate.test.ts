// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { describe, expect, it } from 'vitest';
import { hintOf, partOf } from '../../src/calibrate/hint';
import { asSentence } from '../../src/calibrate/sentence';

describe('the calibration page', () => {
  it('finds the picture for each thing that the server asks for', () => {
    expect(hintOf('tilt the board so that its left edge is nearer to the camera')).toBe('left');
    expect(hintOf('tilt the board so that its right edge is nearer to the camera')).toBe('right');
    expect(hintOf('tilt the board so that its upper edge is nearer to the camera')).toBe('upper');
    expect(hintOf('tilt the board so that its lower edge is nearer to the camera')).toBe('lower');
    expect(hintOf('change the distance: so far the board was 50 to 60 cm away')).toBe('distance');
    expect(hintOf('hold the board at the left edge of the picture')).toBe('place');
    expect(hintOf('take 3 more, each in another pose')).toBe('more');
  });

  it('finds the part of the picture that is meant', () => {
    expect(partOf('hold the board at the upper left corner of the picture')).toEqual([0, 0]);
    expect(partOf('hold the board at the right edge of the picture')).toEqual([2, 1]);
    expect(partOf('hold the board at the lower edge of the picture')).toEqual([1, 2]);
    expect(partOf('hold the board at the middle of the picture')).toEqual([1, 1]);
  });

  it('writes whole sentences', () => {
    expect(asSentence('hold still')).toBe('Hold still.');
    expect(asSentence('Is it flat?')).toBe('Is it flat?');
    expect(asSentence('')).toBe('');
  });
});
