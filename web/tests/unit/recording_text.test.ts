// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { expect, test } from 'vitest';
import type { RecordingState } from '../../src/api';
import { recordingLine } from '../../src/recording_text';

const state: RecordingState = {
  recording: true, file: 'a.mcap', seconds: 65.9, frames: 1977, dropped: 0, bytes: 123456789, error: null,
};

test('says how long and how large it is', () => {
  expect(recordingLine(undefined)).toContain('replayed');
  expect(recordingLine({ ...state, file: null })).toContain('replayed');
  expect(recordingLine(state)).toBe('1:05, 123\u00a0MB');
  expect(recordingLine({ ...state, recording: false })).toBe('a.mcap: 1:05, 123\u00a0MB');
});

test('says what is missing', () => {
  expect(recordingLine({ ...state, dropped: 3 })).toContain('3 pictures missed');
  expect(recordingLine({ ...state, error: 'a.mcap: the disk is full' })).toBe('Stopped: a.mcap: the disk is full');
});
