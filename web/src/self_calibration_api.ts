// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { call } from './api';

export type Verdict =
  | 'too-few-views' | 'too-little-motion' | 'other-body' | 'no-error' | 'small' | 'skin-changed'
  | 'error';

/** What is added to the depth over the picture, row by row. */
export interface CorrectionMap {
  columns: number;
  rows: number;
  at_mm: number;
  add_mm: number[];
}

export interface FoundError {
  verdict: Verdict;
  /** What a yes would do: correct the depth camera, register to the skin as it is now. */
  corrects_sensor: boolean;
  follows_skin: boolean;
  /** How far the overlay is off by what is proposed. */
  now_mm: number;
  /** How far the camera’s correction moves the overlay. */
  shift_mm: number;
  /** What the views cannot tell, one standard deviation. */
  remaining_mm: number;
  /** How far the body's skin has changed since its CT, root mean square. */
  skin_mm: number;
  /** The same, at most. */
  skin_most_mm: number;
  views: number;
  /** A table under the body told along: less stays unknown. */
  sees_table: boolean;
  parts_better: number;
  parts: number;
  map: CorrectionMap;
}

export interface AppliedCorrection {
  origin: string;
  corrects_sensor: boolean;
  follows_skin: boolean;
  skin_most_mm: number;
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
