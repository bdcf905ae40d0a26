// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { sizeWords } from '../../src/documents_panel';
import { lengthWords, type Finding } from '../../viewer/src/case_data';
import { lettersOf } from '../../viewer/src/stage';

describe('lettersOf', () => {
  it('names the way of the body that a side of the picture shows', () => {
    expect(lettersOf(new Vector3(1, 0, 0))).toBe('L');
    expect(lettersOf(new Vector3(0, -1, 0))).toBe('A');
    expect(lettersOf(new Vector3(0, 0, -1))).toBe('F');
  });

  it('puts the larger share first between two', () => {
    expect(lettersOf(new Vector3(-0.8, 0.6, 0))).toBe('RP');
    expect(lettersOf(new Vector3(0, 0.6, 0.8))).toBe('HP');
    expect(lettersOf(new Vector3(0.99, 0.14, 0))).toBe('L');
  });
});

describe('lengthWords', () => {
  const finding = { length_mm: 53.94, length_bound_mm: 1.86 } as Finding;

  it('says the uncertainty where it is known, and no length of a place', () => {
    expect(lengthWords(finding)).toBe('53.9 ± 1.9 mm');
    expect(lengthWords({ ...finding, length_bound_mm: null })).toBe('53.9 mm');
    expect(lengthWords({ ...finding, length_mm: null })).toBe('');
  });
});

describe('sizeWords', () => {
  it('never says that a file is nothing', () => {
    expect(sizeWords(12)).toBe('1 kB');
    expect(sizeWords(7_538_700)).toBe('7.5 MB');
  });
});
