// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { Part } from './api';

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
