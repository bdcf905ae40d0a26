// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// What the tables say of a sample of poses. Poses are 16 numbers, row by row.

// The value below which a share of the sorted samples lies (type 7, as morgagni/core/statistics.h).
export function quantile(samples, share) {
  if (samples.length === 0) return NaN;
  const sorted = [...samples].sort((a, b) => a - b);
  const rank = share * (sorted.length - 1);
  const below = Math.floor(rank);
  const above = Math.min(below + 1, sorted.length - 1);
  return sorted[below] + (rank - below) * (sorted[above] - sorted[below]);
}

export function summarize(samples) {
  const mean = samples.reduce((sum, value) => sum + value, 0) / samples.length;
  const squares = samples.reduce((sum, value) => sum + (value - mean) ** 2, 0);
  return {
    mean,
    sd: samples.length > 1 ? Math.sqrt(squares / (samples.length - 1)) : 0,
    median: quantile(samples, 0.5),
    p95: quantile(samples, 0.95),
    max: Math.max(...samples),
  };
}

function moved(pose, [x, y, z]) {
  return [0, 4, 8].map((row) => pose[row] * x + pose[row + 1] * y + pose[row + 2] * z + pose[row + 3]);
}

function movedBack(pose, point) {
  const shifted = point.map((value, axis) => value - pose[4 * axis + 3]);
  return [0, 1, 2].map((column) => shifted.reduce((sum, value, row) => sum + pose[4 * row + column] * value, 0));
}

// Root mean square over the targets of how far `pose` puts them from where they are. NaN (a method
// that lost itself) counts as infinitely far.
export function targetRegistrationErrorMm(pose, truth, targets) {
  let squares = 0;
  for (const target of targets) {
    const found = moved(pose, movedBack(truth, target));
    squares += found.reduce((sum, value, axis) => sum + (value - target[axis]) ** 2, 0);
  }
  const tre = Math.sqrt(squares / targets.length);
  return Number.isNaN(tre) ? Infinity : tre;
}
