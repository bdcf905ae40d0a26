// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { describe, expect, it } from 'vitest';
import type { CorrectionMap, FoundError, SelfCalibration } from '../../src/self_calibration_api';
import {
  appliedLine, headline, mapAt, mapColor, mapEnd, proposalLines,
} from '../../src/self_calibration_text';

const map: CorrectionMap = { columns: 3, rows: 2, at_mm: 700, add_mm: [-2.2, 0, 1, 0, 0, 1] };
const found: FoundError = {
  verdict: 'error', corrects_sensor: true, follows_skin: false, now_mm: 1.94, shift_mm: 1.94,
  remaining_mm: 0.81, skin_mm: 0.1, skin_most_mm: 0.2, views: 60, sees_table: true, parts_better: 6, parts: 6, map,
};
const state: SelfCalibration = {
  phase: 'gathering', views: 12, wanted_views: 60, views_in_part: [0, 1, 0, 0, 9, 0, 0, 0, 0],
  missing: [], found: null, applied: null, device: 'freenect-1', problem: null,
};
const applied = {
  origin: 'self', corrects_sensor: true, follows_skin: false, skin_most_mm: 0, shift_mm: 1.94,
  remaining_mm: 0.81, kept: true,
};

describe('what the panel says', () => {
  it('asks for motion only while a body is tracked', () => {
    expect(headline(state, 'tracking')).toContain('Move the camera slowly');
    expect(headline(state, 'lost')).toContain('while a body is tracked');
    expect(headline({ ...state, applied }, 'tracking')).toContain('is being checked');
    expect(headline({ ...state, applied }, 'waiting')).toContain('in use. It is checked while');
  });

  it('says in millimetres what a yes would do, and how sure it is', () => {
    expect(headline({ ...state, phase: 'proposed', found }, 'tracking')).toContain('about 1.9 mm off');
    const [gain, sure] = proposalLines(found);
    expect(gain).toContain('about 0.8 mm');
    expect(sure).toContain('all 6 of 6');
    expect(proposalLines({ ...found, parts_better: 5 })[1]).toContain(': 5 of 6');
    expect(proposalLines(found)[2]).toContain('bound counts it in');
  });

  it('asks for the table where none was seen', () => {
    expect(proposalLines(found)[0]).not.toContain('table');
    expect(proposalLines({ ...found, sees_table: false })[0]).toMatch(/0\.8 mm\. No table was seen/);
    const rests = (sees_table: boolean): string => headline(
      { ...state, phase: 'resting', found: { ...found, verdict: 'too-little-motion', sees_table } }, 'tracking');
    expect(rests(true)).not.toContain('table');
    expect(rests(false)).toContain('A table in much of the picture helps.');
  });

  it('says how far the skin has changed, and that the CT stays as it is', () => {
    expect(proposalLines(found)).toHaveLength(3);
    const both = { ...found, follows_skin: true, skin_mm: 0.74, skin_most_mm: 1.83 };
    expect(proposalLines(both)[0]).toContain('up to 1.8 mm from the CT’s (0.7 mm');
    expect(proposalLines(both)[0]).toContain('exported stays the CT’s');
    const words = (of: FoundError): string => headline({ ...state, phase: 'proposed', found: of }, 'tracking');
    expect(words(both)).toContain('camera errs, and the body’s skin has changed');
    expect(words({ ...both, corrects_sensor: false })).toMatch(/^The body’s skin has changed/);
  });

  it('says why it rests', () => {
    const rests = (verdict: FoundError['verdict']): string =>
      headline({ ...state, phase: 'resting', found: { ...found, verdict } }, 'tracking');
    const all = (['no-error', 'other-body', 'too-little-motion'] as const).map(rests);
    expect(new Set(all).size).toBe(3);
    expect(rests('small')).toBe(rests('no-error'));
    expect(headline({ ...state, phase: 'resting' }, 'tracking')).toBe('Not looking.');
  });

  it('says for how long the correction holds', () => {
    expect(appliedLine(applied, 'freenect-1')).toContain('kept for this camera');
    expect(appliedLine({ ...applied, kept: false }, null)).toContain('no serial number');
    expect(appliedLine({ ...applied, kept: false }, 'freenect-1')).toMatch(/alone\.$/);
    const skin = { ...applied, corrects_sensor: false, follows_skin: true, skin_most_mm: 1.83, kept: false };
    expect(appliedLine(skin, 'freenect-1')).toMatch(/up to 1\.8 mm from the CT’s, for this session\.$/);
  });
});

describe('the map', () => {
  it('is drawn between round numbers', () => {
    expect(mapEnd(map)).toBe(3);
    expect(mapEnd({ ...map, add_mm: [0, 0, 0, 0, 0, 0.1] })).toBe(1);
  });

  it('is bilinear, to the edges', () => {
    expect(mapAt(map, 0, 0)).toBeCloseTo(-2.2);
    expect(mapAt(map, 1, 1)).toBeCloseTo(1);
    expect(mapAt(map, 0.25, 0.5)).toBeCloseTo(-0.55);
  });

  it('is white at nothing, and differs in sign', () => {
    expect(mapColor(0)).toEqual([244, 244, 244]);
    expect(mapColor(-1)).toEqual(mapColor(-7));
    expect(mapColor(-1)[2]).toBeGreaterThan(mapColor(1)[2]);
  });
});
