// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { describe, expect, it } from 'vitest';
import { freeLine, marksOf } from '../../src/finding_marks';
import { adviceFor, lengthText, titleOf } from '../../src/finding_text';
import type { Finding } from '../../src/findings_api';
import { videoFigures } from '../../src/takeaway_panel';

const POINT: Finding = {
  id: 'F1', kind: 'point', note: '', created_at: '', has_photo: false,
  points: [{ ct_mm: [1, 2, 3], on_skin: true, bound_mm: 2.06 }], length_mm: null, length_bound_mm: null,
};

describe('finding text', () => {
  it('says lengths with their uncertainty, or that it is not known', () => {
    expect(lengthText({ length_mm: 123.44, length_bound_mm: 2.06 })).toBe('123.4 mm ± 2.1 mm');
    expect(lengthText({ length_mm: 7, length_bound_mm: null })).toBe('7.0 mm, uncertainty not known');
    expect(lengthText({ length_mm: null, length_bound_mm: null })).toBe('');
  });

  it('says what a finding is', () => {
    expect(titleOf(POINT)).toBe('Point on the skin, ± 2.1 mm');
    expect(titleOf({ ...POINT, points: [{ ct_mm: [1, 2, 3], on_skin: false, bound_mm: null }] }))
      .toBe('Point inside');
    expect(titleOf({ ...POINT, kind: 'geodesic', length_mm: 50, length_bound_mm: 1 }))
      .toBe('Over the skin 50.0 mm ± 1.0 mm');
  });

  it('says what to tap next', () => {
    expect(adviceFor('point', 0)).toBe('Tap the point on the body');
    expect(adviceFor('geodesic', 1)).toBe('Tap the second point on the skin');
  });

  it('takes no marks from what has none', () => {
    expect(marksOf(undefined)).toEqual([]);
    expect(marksOf({ marks: 'F1' })).toEqual([]);
  });

  it('puts no words on others', () => {
    const labels: [number, number][] = [];
    expect(freeLine(labels, 100, 50, 1)).toBe(50);
    expect(freeLine(labels, 110, 52, 1)).toBe(71);
    expect(freeLine(labels, 105, 50, 1)).toBe(107);
    expect(freeLine(labels, 400, 50, 1)).toBe(50);
  });

  it('says how long and how large a video is', () => {
    expect(videoFigures({ seconds: 65.9, bytes: 12_340_000 })).toBe('1:05, 12.3 MB');
  });
});
