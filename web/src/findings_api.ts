// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { call, type Point3 } from './api';
import { toServer, type Point } from './geometry';

export type FindingKind = 'point' | 'distance' | 'geodesic';

export interface FindingPoint {
  ct_mm: Point3;
  on_skin: boolean;
  /** 95 % of the errors there are smaller. */
  bound_mm: number | null;
}

export interface Finding {
  id: string;
  kind: FindingKind;
  note: string;
  points: FindingPoint[];
  length_mm: number | null;
  length_bound_mm: number | null;
  created_at: string;
  has_photo: boolean;
}

/** A tapped point that is not in a finding yet. */
export interface Pick extends FindingPoint {
  pick: number;
  on: 'skin' | 'structure' | 'slice' | 'volume';
  structure: string;
}

export interface FindingList {
  findings: Finding[];
  /** What undo would take back, in words. */
  undoable: string | null;
}

export const findingsApi = {
  list: () => call<FindingList>('/api/findings'),
  pick: (point: Point, frame_id: number | undefined) =>
    call<Pick>('/api/findings/pick', { ...toServer(point), frame_id: frame_id ?? null }),
  cancel: () => call<object>('/api/findings/cancel', {}),
  add: (kind: FindingKind, picks: number[], note: string) =>
    call<Finding>('/api/findings/add', { kind, picks, note }),
  setNote: (id: string, note: string) => call<FindingList>('/api/findings/note', { id, note }),
  remove: (id: string) => call<FindingList>('/api/findings/delete', { id }),
  undo: () => call<FindingList>('/api/findings/undo', {}),
  photoUrl: (id: string, overlay: boolean) =>
    `/api/findings/photo.png?id=${encodeURIComponent(id)}${overlay ? '&overlay=1' : ''}`,
};
