// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { expect, it } from 'vitest';
import type { Part } from '../../src/prepare/api';
import { Latest } from '../../src/prepare/latest';
import { placeText, sizeText, volumeText } from '../../src/prepare/part_text';

it('does one thing at a time and forgets what came between', async () => {
  const done: number[] = [];
  const ends: (() => void)[] = [];
  const latest = new Latest<number>((value) => {
    done.push(value);
    return new Promise((resolve) => ends.push(resolve));
  });
  latest.ask(1);
  latest.ask(2);
  latest.ask(3);
  expect(done).toEqual([1]);
  ends[0]!();
  await Promise.resolve();
  expect(done).toEqual([1, 3]);
  expect(latest.isBusy).toBe(true);
  ends[1]!();
  await Promise.resolve();
  expect(latest.isBusy).toBe(false);
});

it('says where a part lies and how large it is', () => {
  const part: Part = { place: 'in front of', volume_ml: 471.4, size_mm: [400, 57.8, 275.9], stands_out: false,
    kept: false, color: '#e8483c', at: { axial: 0.5, coronal: 0.5, sagittal: 0.5 } };
  expect(placeText(part)).toBe('In front of the body');
  expect(sizeText(part)).toBe('471\u00a0ml, 400 × 58 × 276 mm');
  expect(volumeText(16830)).toBe('16.8\u00a0l');
});
