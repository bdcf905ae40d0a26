// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { Point3 } from './api';
import { clamp, type Point, type Size } from './geometry';
import { wrapAngle } from './landmarks';

/** Where the virtual camera of the free view is: members of the server's view. */
export interface FreeViewpoint {
  free_yaw: number;
  free_pitch: number;
  free_zoom: number;
  /** What is in the middle and turned about, from the middle of the skin, CT. */
  free_target_mm: Point3;
}

export const FIRST_VIEWPOINT: FreeViewpoint = {
  free_yaw: 0, free_pitch: 0, free_zoom: 1.3, free_target_mm: [0, 0, 0],
};

export const STANDARD_VIEWS: readonly (readonly [string, number, number])[] = [
  ['Front', 0, 0],
  ['Back', Math.PI, 0],
  ['Left', Math.PI / 2, 0],
  ['Right', -Math.PI / 2, 0],
  ['Head', 0, Math.PI / 2],
  ['Feet', 0, -Math.PI / 2],
];

const LEAST_ZOOM = 0.3;
const MOST_ZOOM = 20;
// As the server's virtual camera: how far away it stands, in radii of the skin, and how much of the
// picture's shorter side the skin fills at zoom 1.
const DISTANCE_IN_RADII = 4;
const FILL = 0.94;
// Nobody needs to move the body out of the picture by more than its own size.
const FARTHEST_TARGET_IN_RADII = 1.5;

/** Millimetres of the body, at its middle, on a pixel of the picture as it is shown. */
export function mmPerPixel(zoom: number, radius_mm: number, shown: Size): number {
  const outline = Math.tan(Math.asin(1 / DISTANCE_IN_RADII));
  const focal_px = (zoom * FILL * 0.5 * Math.min(shown.width, shown.height)) / outline;
  return (DISTANCE_IN_RADII * radius_mm) / focal_px;
}

/** By a drag of one finger: half a turn over the picture's width, slower where it is zoomed in. */
export function turned(from: FreeViewpoint, by: Point, shown: Size): FreeViewpoint {
  const speed = Math.PI / shown.width / Math.max(1, Math.sqrt(from.free_zoom));
  return {
    ...from,
    free_yaw: wrapAngle(from.free_yaw - by.x * speed),
    free_pitch: clamp(from.free_pitch + by.y * speed, -Math.PI / 2, Math.PI / 2),
  };
}

/** The body follows the fingers. */
export function panned(from: FreeViewpoint, by: Point, radius_mm: number, shown: Size): FreeViewpoint {
  return shifted(from, by, mmPerPixel(from.free_zoom, radius_mm, shown), radius_mm);
}

/** @param at  What stays where it is: from the picture's middle, px as shown. */
export function zoomed(
  from: FreeViewpoint, factor: number, at: Point, radius_mm: number, shown: Size,
): FreeViewpoint {
  const free_zoom = clamp(from.free_zoom * factor, LEAST_ZOOM, MOST_ZOOM);
  const before = mmPerPixel(from.free_zoom, radius_mm, shown);
  const after = mmPerPixel(free_zoom, radius_mm, shown);
  return shifted({ ...from, free_zoom }, at, after - before, radius_mm);
}

function shifted(from: FreeViewpoint, by: Point, mm_per_px: number, radius_mm: number): FreeViewpoint {
  const [sin_yaw, cos_yaw] = [Math.sin(from.free_yaw), Math.cos(from.free_yaw)];
  const [sin_pitch, cos_pitch] = [Math.sin(from.free_pitch), Math.cos(from.free_pitch)];
  // The virtual camera's axes in the CT (x to the left, y to the back, z to the head).
  const right: Point3 = [cos_yaw, sin_yaw, 0];
  const up: Point3 = [-sin_yaw * sin_pitch, cos_yaw * sin_pitch, cos_pitch];
  const limit = FARTHEST_TARGET_IN_RADII * radius_mm;
  const target = from.free_target_mm.map((value, i) =>
    clamp(value + mm_per_px * (by.y * up[i]! - by.x * right[i]!), -limit, limit));
  return { ...from, free_target_mm: target as Point3 };
}
