// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { RecordingState } from './api';

/** What a recording says of itself, below its button. */
export function recordingLine(state: RecordingState | undefined): string {
  if (!state?.file) return 'Keeps colour, depth and poses in the case, to be replayed at any time.';
  if (state.error) return `Stopped: ${state.error}`;
  const minutes = Math.floor(state.seconds / 60);
  const seconds = String(Math.floor(state.seconds % 60)).padStart(2, '0');
  const size = `${(state.bytes / 1e6).toFixed(0)}\u00a0MB`;
  const dropped = state.dropped > 0 ? `, ${state.dropped} pictures missed` : '';
  const line = `${minutes}:${seconds}, ${size}${dropped}`;
  return state.recording ? line : `${state.file}: ${line}`;
}
