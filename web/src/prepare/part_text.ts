// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { Doubt, Part } from './api';

export function volumeText(ml: number): string {
  return ml >= 1000 ? `${(ml / 1000).toFixed(1)}\u00a0l` : `${Math.round(ml)}\u00a0ml`;
}

/** "Behind the body". */
export function placeText({ place }: Part): string {
  const capital = place.charAt(0).toUpperCase() + place.slice(1);
  return `${capital} the body`;
}

/** "471 ml, 400 × 58 × 276 mm". */
export function sizeText({ volume_ml, size_mm }: Part): string {
  return `${volumeText(volume_ml)}, ${size_mm.map((side) => Math.round(side)).join(' × ')} mm`;
}

const WHY: Record<Doubt['why'], string> = {
  cover_taken: 'What lay on it was taken off',
  layer_taken: 'A thin layer was taken off it',
  taken_off: 'You took a thin layer off it',
  layer_left: 'A thin layer may lie on it, unseen',
};

/** "Back, 846 cm\u00b2". */
export function doubtTitle({ place, area_cm2 }: Doubt): string {
  return `${place.charAt(0).toUpperCase()}${place.slice(1)}, ${Math.round(area_cm2)}\u00a0cm\u00b2`;
}

/** "A thin layer was taken off it: up to 2.5 mm wrong". */
export function doubtText({ why, up_to_mm }: Doubt): string {
  return `${WHY[why]}: up to ${up_to_mm.toFixed(1)}\u00a0mm wrong`;
}
