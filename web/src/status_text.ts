// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { Status, TrackingState } from './api';
import type { Connection } from './live_video';

/** `unknown`: the server says nothing. */
export type ShownState = TrackingState | 'unknown';

export const STATE_WORDS: Record<ShownState, string> = {
  unknown: 'No server',
  waiting: 'Waiting for start',
  tracking: 'Tracking',
  skipped: 'Skipped, pose held',
  lost: 'Lost',
};

export function millimetres(value: number | null | undefined): string {
  return value === null || value === undefined ? '–' : value.toFixed(1);
}

export function milliseconds(value: number | null | undefined): string {
  return value === null || value === undefined ? '–' : value.toFixed(0);
}

export interface Banner {
  kind: 'bad' | 'calm';
  text: string;
}

/** What must be said over the picture, because it is not what is now. */
export function bannerOf(
  connection: Connection,
  age_ms: number,
  problem: string,
  status: Status | undefined,
  isPicking = false,
): Banner | undefined {
  if (connection === 'connecting') return { kind: 'calm', text: 'Connecting …' };
  if (connection === 'gone') {
    return { kind: 'bad', text: `No live picture. ${problem} Trying again …` };
  }
  if (status?.camera_error) return { kind: 'bad', text: `Camera: ${status.camera_error}` };
  if (isPicking) return undefined;
  if (status?.frozen) return { kind: 'calm', text: 'Frozen: this is not the live picture' };
  if (connection === 'stale') {
    return { kind: 'bad', text: `The picture stands still: ${(age_ms / 1000).toFixed(0)} s old` };
  }
  return undefined;
}

/** A file name that sorts by time and says which case it shows. */
export function snapshotName(caseName: string, at: Date): string {
  const two = (n: number): string => String(n).padStart(2, '0');
  const day = `${at.getFullYear()}-${two(at.getMonth() + 1)}-${two(at.getDate())}`;
  const time = `${two(at.getHours())}-${two(at.getMinutes())}-${two(at.getSeconds())}`;
  const name = caseName.replace(/[^\p{L}\p{N}]+/gu, '-').replace(/^-+|-+$/g, '').slice(0, 60);
  return `morgagni_${name || 'case'}_${day}_${time}.png`;
}
