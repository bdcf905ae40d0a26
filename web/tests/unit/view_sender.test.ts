// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { expect, it } from 'vitest';
import type { View } from '../../src/api';
import { holeOfSlider, sliderOfHole } from '../../src/controls';
import { ViewSender } from '../../src/view_sender';

it('sends one change at a time and merges those that wait', async () => {
  const sent: Partial<View>[] = [];
  const answers: (() => void)[] = [];
  const sender = new ViewSender((change) => {
    sent.push(change);
    return new Promise<void>((resolve) => answers.push(resolve));
  }, () => undefined);
  sender.change({ opacity: 0.1 });
  sender.change({ opacity: 0.2, structures: { bone: false } });
  sender.change({ opacity: 0.3, structures: { vessels: true } });
  expect(sent).toEqual([{ opacity: 0.1 }]);
  answers[0]?.();
  await Promise.resolve();
  await Promise.resolve();
  expect(sent[1]).toEqual({ opacity: 0.3, structures: { bone: false, vessels: true } });
  expect(sender.isBusy).toBe(true);
  answers[1]?.();
  await new Promise((resolve) => setTimeout(resolve));
  expect(sender.isBusy).toBe(false);
});

it('merges what is wanted of different structures', async () => {
  const sent: Partial<View>[] = [];
  let answer = (): void => undefined;
  const sender = new ViewSender((change) => {
    sent.push(change);
    return new Promise<void>((resolve) => (answer = resolve));
  }, () => undefined);
  sender.change({ opacity: 1 });
  sender.change({ structure_opacity: { bone: 0.5 } });
  sender.change({ structure_opacity: { skin: 0.25 }, slice: 'axial' });
  answer();
  await new Promise((resolve) => setTimeout(resolve));
  expect(sent[1]).toEqual({ structure_opacity: { bone: 0.5, skin: 0.25 }, slice: 'axial' });
});

it('goes on after an error', async () => {
  const errors: unknown[] = [];
  const sender = new ViewSender(() => Promise.reject(new Error('no')), (error) => errors.push(error));
  sender.change({ opacity: 1 });
  await new Promise((resolve) => setTimeout(resolve));
  expect(errors).toHaveLength(1);
  expect(sender.isBusy).toBe(false);
});

it('opens the hole over everything at the end of its slider', () => {
  expect(holeOfSlider(0)).toBe(0);
  expect(holeOfSlider(1)).toBe(2);
  for (const value of [0, 0.3, 0.99, 1]) expect(sliderOfHole(holeOfSlider(value))).toBeCloseTo(value, 9);
});
