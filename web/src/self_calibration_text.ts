// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { AppliedCorrection, CorrectionMap, FoundError, SelfCalibration } from './self_calibration_api';
import type { TrackingState } from './api';

const mm = (value: number): string => `${value.toFixed(1)} mm`;

/** What goes on, in one sentence or two. */
export function headline(state: SelfCalibration, tracking: TrackingState | undefined): string {
  switch (state.phase) {
    case 'gathering':
      if (tracking !== 'tracking') {
        return state.applied ? 'The correction is in use. It is checked while a body is tracked.'
          : 'It checks the depth camera while a body is tracked.';
      }
      return state.applied
        ? 'The correction is in use and is being checked. Move the camera slowly.'
        : 'It checks the depth camera by itself. Move the camera slowly.';
    case 'estimating':
      return 'Enough views: working it out. The picture goes on.';
    case 'proposed':
      return state.found ? proposalHead(state.found) : '';
    case 'resting':
      return restWords(state);
  }
}

function proposalHead(found: FoundError): string {
  const off = `the overlay is about ${mm(found.now_mm)} off.`;
  if (!found.corrects_sensor) return `The body’s skin has changed since its CT: ${off}`;
  return found.follows_skin
    ? `The depth camera errs, and the body’s skin has changed since its CT: ${off}`
    : `The depth camera errs: ${off}`;
}

function restWords({ found, applied }: SelfCalibration): string {
  switch (found?.verdict) {
    case undefined:
    case 'error':
    case 'skin-changed':
      return 'Not looking.';
    case 'no-error':
    case 'small':
      return applied
        ? `Checked on ${found!.views} views: with the correction, nothing more is to be removed.`
        : `Checked on ${found!.views} views: nothing to correct.`;
    case 'other-body':
      return 'The skin is too far from the CT’s: another body, or a cover. Nothing can be checked on it.';
    case 'too-little-motion':
    case 'too-few-views':
      return 'The camera moved too little to tell its error from the body’s place.'
        + (found!.sees_table ? '' : ' A table in much of the picture helps.');
  }
}

/** What a yes would do and how sure it is. */
export function proposalLines(found: FoundError): string[] {
  const noTable = found.sees_table ? '' : ' No table was seen under the body: with much of it in the picture less stays.';
  const all = found.parts_better === found.parts ? 'all ' : '';
  const lines: string[] = [];
  if (found.follows_skin) {
    lines.push(`The skin lies up to ${mm(found.skin_most_mm)} from the CT’s (${mm(found.skin_mm)} in the`
      + ' mean). Apply registers to the skin as it is now, for this session; what is drawn, saved and'
      + ' exported stays the CT’s.');
  }
  lines.push(
    `Applying removes this. What this motion cannot show stays: about ${mm(found.remaining_mm)}.${noTable}`,
    `How sure: ${all}${found.parts_better} of ${found.parts} checks on views that were not used agree.`,
    'Until then, the error bound counts it in.',
  );
  return lines;
}

export function appliedLine(applied: AppliedCorrection, device: string | null): string {
  const skin = applied.follows_skin
    ? ` It follows the skin as it is now, up to ${mm(applied.skin_most_mm)} from the CT’s, for this session.`
    : '';
  const moved = `The overlay was moved by about ${mm(applied.shift_mm)}.${skin}`;
  if (!applied.corrects_sensor) return moved;
  if (applied.kept) return `${moved} The correction is kept for this camera.`;
  return device === null
    ? `${moved} For this session alone: the camera has no serial number to keep it under.`
    : `${moved} For this session alone.`;
}

/** The end of the colour scale: a round number of millimetres above all values. */
export function mapEnd(map: CorrectionMap): number {
  return Math.max(1, Math.ceil(Math.max(...map.add_mm.map(Math.abs))));
}

/** -1..1 from blue (read too far) over white to red (read too near). */
export function mapColor(share: number): [number, number, number] {
  const s = Math.max(-1, Math.min(1, share));
  const fade = (to: number): number => Math.round(244 + (to - 244) * Math.abs(s));
  return s < 0 ? [fade(34), fade(94), fade(190)] : [fade(196), fade(62), fade(40)];
}

/** Bilinear between control points; u, v 0..1 over the picture. */
export function mapAt(map: CorrectionMap, u: number, v: number): number {
  const x = u * (map.columns - 1);
  const y = v * (map.rows - 1);
  const left = Math.min(map.columns - 2, Math.floor(x));
  const top = Math.min(map.rows - 2, Math.floor(y));
  const at = (column: number, row: number): number => map.add_mm[row * map.columns + column] ?? 0;
  const above = at(left, top) + (x - left) * (at(left + 1, top) - at(left, top));
  const below = at(left, top + 1) + (x - left) * (at(left + 1, top + 1) - at(left, top + 1));
  return above + (y - top) * (below - above);
}
