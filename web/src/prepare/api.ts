// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { sentenceOf } from '../server_error';

export type Plane = 'axial' | 'coronal' | 'sagittal';

/** Something that people may decide about. */
export interface Part {
  place: string;
  volume_ml: number;
  size_mm: [number, number, number];
  /** Found as a part of the body, as ears are; else as its surroundings. */
  stands_out: boolean;
  kept: boolean;
  color: string;
  /** The slices through it. */
  at: Record<Plane, number>;
}

/** A stretch of the skin that the CT does not show for certain. */
export interface Doubt {
  place: string;
  area_cm2: number;
  /** How far off the skin may be there. */
  up_to_mm: number;
  why: 'cover_taken' | 'layer_taken' | 'taken_off' | 'layer_left';
  at: Record<Plane, number>;
}

export interface Check {
  title: string;
  state: 'checking' | 'preparing' | 'done' | 'failed' | 'cancelled';
  step: string;
  fraction: number;
  error: string | null;
  threshold_hu: number;
  closing_mm: number;
  body_ml: number;
  parts: Part[];
  doubts: Doubt[];
  /** Of each plane's picture: across, down, through. */
  planes_mm: Record<Plane, [number, number, number]>;
  version: number;
  took_ms: number;
}

export interface Settings {
  threshold_hu?: number;
  closing_mm?: number;
}

export interface Decision {
  part: number;
  keep: boolean;
  /** Of the list that the part is in. */
  version: number;
}

/** A thin layer that may go on unseen taken off there, or put back. */
export interface TakeOff {
  doubt: number;
  take_off: boolean;
  version: number;
}

async function asked(path: string, body?: unknown): Promise<Check> {
  const response = await fetch(path,
    body === undefined ? {} : { method: 'POST', body: JSON.stringify(body) });
  const text = await response.text();
  if (!response.ok) throw new Error(sentenceOf(text));
  return JSON.parse(text) as Check;
}

export const api = {
  state: () => asked('/api/check'),
  change: (change: Settings | Decision | TakeOff) => asked('/api/check/change', change),
  use: () => asked('/api/check/use', {}),
  cancel: () => asked('/api/check/cancel', {}),
  slicePath: (plane: Plane, position: number, height: number, version: number) =>
    `/api/check/slice.png?plane=${plane}&position=${position.toFixed(4)}&height=${height}&version=${version}`,
};

export interface Surface {
  positions: Float32Array;
  indices: Uint32Array;
}

/** `of`: "skin", what of it is not certain, or a part's number. */
export async function surface(of: 'skin' | 'doubtful' | number): Promise<Surface> {
  const response = await fetch(`/api/check/surface?of=${of}`);
  if (!response.ok) throw new Error(sentenceOf(await response.text()));
  const bytes = await response.arrayBuffer();
  const [vertices, triangles] = new Uint32Array(bytes, 0, 2);
  return {
    positions: new Float32Array(bytes, 8, 3 * vertices!),
    indices: new Uint32Array(bytes, 8 + 12 * vertices!, 3 * triangles!),
  };
}
