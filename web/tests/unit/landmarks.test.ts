// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { describe, expect, it } from 'vitest';
import { dragged, Landmarks, wrapAngle, type CtPick, type LivePick } from '../../src/landmarks';

const viewpoint = { yaw: 0, pitch: 0, zoom: 1, width: 500, height: 400 };
const ct = (x: number): CtPick => ({ mm: [x, 0, 0], viewpoint, pixel: { x, y: 0 } });
const live = (x: number): LivePick => ({ mm: [x, 1, 700], pixel: { x, y: 0 } });

describe('Landmarks', () => {
  it('pairs points that are tapped in either order', () => {
    const landmarks = new Landmarks();
    landmarks.addCt(ct(1));
    landmarks.addLive(live(2));
    landmarks.addLive(live(4));
    landmarks.addCt(ct(3));
    expect(landmarks.pairs()).toEqual([
      { ct_mm: [1, 0, 0], depth_mm: [2, 1, 700] },
      { ct_mm: [3, 0, 0], depth_mm: [4, 1, 700] },
    ]);
  });

  it('moves the half of a pair that is tapped again', () => {
    const landmarks = new Landmarks();
    landmarks.addCt(ct(1));
    landmarks.addCt(ct(9));
    expect(landmarks.all).toHaveLength(1);
    landmarks.addLive(live(2));
    expect(landmarks.pairs()[0]?.ct_mm[0]).toBe(9);
  });

  it('takes back the last one, half or whole', () => {
    const landmarks = new Landmarks();
    landmarks.addCt(ct(1));
    landmarks.addLive(live(1));
    landmarks.addLive(live(2));
    landmarks.undo();
    expect(landmarks.pairs()).toHaveLength(1);
    landmarks.undo();
    expect(landmarks.all).toHaveLength(0);
    landmarks.undo();
    expect(landmarks.all).toHaveLength(0);
  });

  it('says what to do next', () => {
    const landmarks = new Landmarks();
    expect(landmarks.advice()).toContain('point 1 on the CT');
    landmarks.addCt(ct(1));
    expect(landmarks.advice()).toContain('point 1 on the live picture too');
    landmarks.addLive(live(1));
    for (let i = 2; i <= 3; ++i) {
      landmarks.addLive(live(i));
      expect(landmarks.advice()).toContain(`point ${i} on the CT skin too`);
      landmarks.addCt(ct(i));
    }
    expect(landmarks.advice()).toContain('Accept');
  });
});

describe('turning the CT', () => {
  it('follows the finger: to the right shows the body\'s right side', () => {
    expect(dragged(viewpoint, 250, 0).yaw).toBeCloseTo(-Math.PI / 2, 9);
    expect(dragged(viewpoint, 0, 100).pitch).toBeCloseTo(Math.PI / 4, 9);
  });

  it('stops over the head and under the feet', () => {
    expect(dragged(viewpoint, 0, 9999).pitch).toBe(Math.PI / 2);
    expect(dragged(viewpoint, 0, -9999).pitch).toBe(-Math.PI / 2);
  });

  it('keeps angles within a turn', () => {
    expect(wrapAngle(2.5 * Math.PI)).toBeCloseTo(Math.PI / 2, 9);
    expect(wrapAngle(-1.5 * Math.PI)).toBeCloseTo(Math.PI / 2, 9);
  });
});
