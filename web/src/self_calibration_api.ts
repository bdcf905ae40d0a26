// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { call } from './api';

export type Verdict =
  | 'too-few-views' | 'too-little-motion' | 'skin-changed' | 'no-error' | 'small' | 'error';

/** What is added to the depth over the picture, row by row. */
export interface CorrectionMap {
  columns: number;
  rows: number;
  at_mm: number;
  add_mm: number[];
}

export interface FoundError {
  verdict: Verdict;
  /** How far the correction moves the overlay. */
  shift_mm: number;
  /** What the views cannot tell, one standard deviation. */
  remaining_mm: number;
  /** How far the body's skin has changed since its CT, root mean square. */
  skin_mm: number;
  views: number;
  parts_better: number;
  parts: number;
  map: CorrectionMap;
}

export interface AppliedCorrection {
  origin: string;
  shift_mm: number;
  remaining_mm: number;
  /** For the next sessions with this camera. */
  kept: boolean;
}

export interface SelfCalibration {
  phase: 'gathering' | 'estimating' | 'proposed' | 'resting';
  views: number;
  wanted_views: number;
  /** Views in which the body fills each of 3 x 3 parts of the picture, row by row. */
  views_in_part: number[];
  missing: string[];
  found: FoundError | null;
  applied: AppliedCorrection | null;
  device: string | null;
  problem: string | null;
}

export const selfCalibration = {
  get: () => call<SelfCalibration>('/api/self-calibration'),
  apply: () => call<SelfCalibration>('/api/self-calibration/apply', {}),
  discard: () => call<SelfCalibration>('/api/self-calibration/discard', {}),
  undo: () => call<SelfCalibration>('/api/self-calibration/undo', {}),
  again: () => call<SelfCalibration>('/api/self-calibration/again', {}),
};
