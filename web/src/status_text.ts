// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { Calibration, Doubt, Search, Status, Touched, TrackingState, Waiting } from './api';
import type { Connection } from './live_video';

/** `unknown`: the server says nothing. */
export type ShownState = TrackingState | 'unknown';

export const STATE_WORDS: Record<ShownState, string> = {
  unknown: 'No server',
  waiting: 'Waiting for start',
  tracking: 'Tracking',
  uncertain: 'Uncertain',
  lost: 'Lost',
};

const DOUBT_WORDS: Record<Doubt, string> = {
  'no-body': 'no body in view',
  residual: 'the surface does not fit the CT well',
  'little-seen': 'little of the body is seen',
  unexplained: 'most of the picture is not the body',
  floating: 'the CT would float before what is seen',
  'open-direction': 'too flat here: the CT could slide',
  jump: 'moved fast',
};

/** The state in words, with the error bound where there is one. */
export function stateWords(state: ShownState, status: Status | undefined): string {
  const bound = boundText(status?.bound_mm);
  if (state === 'waiting' && !status) return 'Waiting for the camera';
  if (state === 'waiting' && status?.starting === 'automatic') return 'Searching';
  if (state === 'uncertain' && status?.held) return 'Uncertain, pose held';
  return bound && (state === 'tracking' || state === 'uncertain')
    ? `${STATE_WORDS[state]} ${bound}` : STATE_WORDS[state];
}

/** An error bound as it is read: at most so much. */
export function boundText(bound_mm: number | null | undefined): string {
  return bound_mm === null || bound_mm === undefined ? '' : `≤ ${bound_mm.toFixed(1)} mm`;
}

/** What the user may do, or should know, while the tracking is not well. */
export function adviceOf(status: Status | undefined): string {
  if (!status || status.frozen) return '';
  if (status.state === 'uncertain') {
    const why = status.doubts.map((doubt) => DOUBT_WORDS[doubt]).join(', ');
    return status.held ? `Old position held: ${why}` : `Uncertain: ${why}`;
  }
  if (status.state === 'lost') return `Lost. ${searchWords(status.search)}`;
  if (status.state === 'waiting' && status.starting === 'automatic') return searchWords(status.search);
  return '';
}

function searchWords(search: Search | null): string {
  if (search?.last === 'ambiguous') {
    return 'Ambiguous: move the camera so that more of the body is seen.';
  }
  if (search?.last === 'not found') {
    return 'Not found yet: move slowly around the body, 50 to 100 cm away, so that more of it is seen.';
  }
  return 'Searching: point the camera at the body.';
}

/** The readout of a touched point: how sure it is, and which point of the CT. */
export function touchLines({ ct_mm, bound_mm }: Touched): [string, string] {
  const point = ct_mm.map((value) => value.toFixed(0)).join(', ');
  return [`error ${boundText(bound_mm) || 'not known'}`, `CT ${point} mm`];
}

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

/** What is waited for before there is a session. */
export function waitingBanner({ camera, waiting_for_camera }: Waiting): Banner {
  const name = camera.split(',')[0];  // The rest may be a secret.
  return { kind: 'calm', text: `Waiting for the first picture of ${name} – ${waiting_for_camera}` };
}

/** Where the calibration in use is from, in words. */
export function calibrationText({ source, age, depth_corrected }: Calibration): string {
  return `Calibration: ${[source, age, depth_corrected ? 'depth corrected' : 'depth not corrected']
    .filter(Boolean).join(', ')}`;
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
  if (status?.view?.picture === 'free' && status.view.free_colors !== 'fused') return oldColors(status);
  return undefined;
}

/** Of when the colours on the skin in the free view are. */
export function colorsText(status: Status): string {
  const { colors_age_ms: age_ms, state } = status;
  if (status.view?.free_colors === 'fused') return 'Colours of the fused texture, of many pictures.';
  if (age_ms === null) return 'No colours yet: the body has not been tracked.';
  if (status.frozen) return 'Colours of the frozen picture.';
  return state === 'tracking' ? 'Colours of now.' : `Colours of ${seconds(age_ms)} ago.`;
}

/** Over the free view, where its colours are not those of now. */
function oldColors(status: Status): Banner | undefined {
  const { colors_age_ms: age_ms, state } = status;
  if (age_ms === null) {
    return { kind: 'calm', text: 'No colours yet: the body has not been tracked' };
  }
  if (state === 'tracking') return undefined;
  return { kind: 'calm', text: `Last good picture, ${seconds(age_ms)} old: ${STATE_WORDS[state].toLowerCase()}` };
}

function seconds(age_ms: number): string {
  return age_ms < 10000 ? `${(age_ms / 1000).toFixed(1)} s` : `${Math.round(age_ms / 1000)} s`;
}

/** A file name that sorts by time and says which case it shows. */
export function snapshotName(caseName: string, at: Date): string {
  const two = (n: number): string => String(n).padStart(2, '0');
  const day = `${at.getFullYear()}-${two(at.getMonth() + 1)}-${two(at.getDate())}`;
  const time = `${two(at.getHours())}-${two(at.getMinutes())}-${two(at.getSeconds())}`;
  const name = caseName.replace(/[^\p{L}\p{N}]+/gu, '-').replace(/^-+|-+$/g, '').slice(0, 60);
  return `morgagni_${name || 'case'}_${day}_${time}.png`;
}
