// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { toServer, type Point } from './geometry';
import { sentenceOf } from './server_error';

export type TrackingState = 'waiting' | 'tracking' | 'uncertain' | 'lost';
export type Doubt =
  | 'no-body' | 'residual' | 'little-seen' | 'unexplained' | 'floating' | 'open-direction' | 'jump';
export type BodySide = 'anterior' | 'posterior' | 'left' | 'right';
export type Point3 = [number, number, number];

export type SlicePlane = 'none' | 'axial' | 'coronal' | 'sagittal' | 'camera';
export type VolumePreset = 'none' | 'bone' | 'soft-tissue' | 'lung' | 'vessels' | 'skin';

export interface View {
  opacity: number;
  hole_radius: number;
  hole_x: number;
  hole_y: number;
  hands_in_front: boolean;
  outlines: boolean;
  structures: Record<string, boolean>;
  structure_opacity: Record<string, number>;
  slice: SlicePlane;
  slice_position: number;
  slice_depth_mm: number;
  slice_level_hu: number;
  slice_window_hu: number;
  slice_cuts: boolean;
  volume: VolumePreset;
  volume_level_hu: number;
  volume_window_hu: number;
  picture: 'camera' | 'free';
  free_yaw: number;
  free_pitch: number;
  free_zoom: number;
  free_target_mm: Point3;
  free_colors: 'live' | 'fused';
  free_hole: boolean;
  free_bare_skin: boolean;
}

/** The search for a start. */
export interface Search {
  searching: boolean;
  last: 'found' | 'ambiguous' | 'not found' | null;
  /** Why the last one found none, in the server's words. */
  reason: string;
}

export interface Status {
  state: TrackingState;
  /** The pose is an earlier picture's: the newest gave none. */
  held: boolean;
  /** Why the pose is uncertain. */
  doubts: Doubt[];
  /** 95 % of the errors on the skin in the hole are smaller. */
  bound_mm: number | null;
  /** Of the picture whose colours the free view shows; null: there has been no good one. */
  colors_age_ms: number | null;
  starting: 'automatic' | 'placement' | 'landmarks' | null;
  search: Search | null;
  frozen: boolean;
  rms_distance_mm: number | null;
  e_valid_mm: number | null;
  explained_fraction: number | null;
  frame_rate: number;
  latency_ms: { median: number; p95: number };
  stage_ms: Record<string, number>;
  frames: { tracked: number; uncertain: number; lost: number; resumed: number; dropped: number };
  method: string;
  camera: string;
  camera_error: string | null;
  calibration: Calibration;
  viewers: number;
  view: View;
}

/** Where the calibration that the camera sees by is from. */
export interface Calibration {
  source: string;
  made_at: string | null;
  /** "12 days old". */
  age: string | null;
  depth_corrected: boolean;
  /** What to do about it. */
  hint: string | null;
}

/** The status while there is no camera yet, and so no session. */
export interface Waiting {
  waiting_for_camera: string;
  case: string;
  camera: string;
}

export function isWaiting(status: Status | Waiting): status is Waiting {
  return 'waiting_for_camera' in status;
}

export interface CaseInfo {
  name: string;
  structures: { name: string; color: string }[];
  has_ct: boolean;
  skin_radius_mm: number;
  start_options: { distance_mm: number; min: number; max: number };
  version: string;
}

export interface SkinViewpoint {
  yaw: number;
  pitch: number;
  zoom: number;
  width: number;
  height: number;
}

export interface LandmarkPair {
  ct_mm: Point3;
  depth_mm: Point3;
}

export interface LandmarkSolution {
  fre_mm: number;
  residuals_mm: number[];
}

export interface Touched {
  ct_mm: Point3;
  bound_mm: number | null;
  state: TrackingState;
}

/** Of the recording that goes on, or of the last one. */
export interface RecordingState {
  recording: boolean;
  file: string | null;
  seconds: number;
  frames: number;
  dropped: number;
  bytes: number;
  error: string | null;
}

export interface TextureInfo {
  ready: boolean;
  recording: boolean;
  /** Of the skin that could be seen, 0..1. */
  coverage: number;
  frames: number;
  /** What became of the newest picture. */
  last: string | null;
  /** Grows when the texture's pictures change; 0: there is none yet. */
  version: number;
  saving: boolean;
  saved: boolean;
  problem: string | null;
}

/** Models, viewer and report: how far they are, and what was made last. */
export interface Documents {
  state: 'idle' | 'running' | 'done' | 'failed' | 'stopped';
  stage: string;
  fraction: number;
  error: string | null;
  folder: string | null;
  files: { name: string; bytes: number; sha256: string }[];
  remarks: string[];
}

export interface DocumentWishes {
  formats: string[];
  print: 'filled' | 'shell';
  wall_mm: number;
  author: string;
}

/** Says what to do next, in the server's words. */
export class ApiError extends Error {}

/** GET without a body, else POST. @throws ApiError */
export async function call<T>(path: string, body?: unknown): Promise<T> {
  let response: Response;
  try {
    response = await fetch(path, {
      method: body === undefined ? 'GET' : 'POST',
      headers: body === undefined ? {} : { 'Content-Type': 'application/json' },
      body: body === undefined ? null : JSON.stringify(body),
      signal: AbortSignal.timeout(10000),
    });
  } catch {
    throw new ApiError('The server does not answer.');
  }
  const text = await response.text();
  if (!response.ok) throw new ApiError(sentenceOf(text));
  return JSON.parse(text) as T;
}

export const api = {
  getCase: () => call<CaseInfo>('/api/case'),
  setView: (change: Partial<View>) => call<View>('/api/view', change),
  freeze: (frozen: boolean) => call<object>('/api/freeze', { frozen }),
  startAutomatically: () => call<object>('/api/start/automatic', {}),
  /** The CT point under a point of the picture shown. Points are the page's here, in px from its corner. */
  touch: (point: Point) => call<Touched>('/api/touch', toServer(point)),
  startByPlacement: (placement: { distance_mm: number; side: BodySide; roll_rad: number }) =>
    call<object>('/api/start/placement', placement),
  beginLandmarks: () => call<object>('/api/landmarks/begin', {}),
  pickOnCt: (viewpoint: SkinViewpoint, point: Point) =>
    call<{ ct_mm: Point3 }>('/api/landmarks/ct', { ...viewpoint, ...toServer(point) }),
  pickOnLive: (point: Point) =>
    call<{ depth_mm: Point3 }>('/api/landmarks/live', toServer(point)),
  solveLandmarks: (pairs: LandmarkPair[]) =>
    call<LandmarkSolution>('/api/landmarks/solve', { pairs }),
  acceptLandmarks: (pairs: LandmarkPair[]) =>
    call<object>('/api/landmarks/accept', { pairs }),
  documents: () => call<Documents>('/api/documents'),
  makeDocuments: (wishes: DocumentWishes) => call<Documents>('/api/documents', wishes),
  stopDocuments: () => call<Documents>('/api/documents/stop', {}),
  cancelLandmarks: () => call<object>('/api/landmarks/cancel', {}),
  getRecording: () => call<RecordingState>('/api/recording'),
  startRecording: () => call<RecordingState>('/api/recording/start', {}),
  stopRecording: () => call<RecordingState>('/api/recording/stop', {}),
  getTexture: () => call<TextureInfo>('/api/texture'),
  recordTexture: (recording: boolean) => call<object>('/api/texture/record', { recording }),
  clearTexture: () => call<object>('/api/texture/clear', {}),
  saveTexture: () => call<object>('/api/texture/save', {}),
};

export function documentUrl(name: string): string {
  return `/api/documents/file?name=${encodeURIComponent(name)}`;
}

export function skinViewUrl(viewpoint: SkinViewpoint): string {
  const query = new URLSearchParams(
    Object.entries(viewpoint).map(([name, value]): [string, string] => [name, String(value)]),
  );
  return `/api/skin-view.png?${query}`;
}

export function textureSidesUrl(version: number): string {
  return `/api/texture/sides.png?version=${version}`;
}

/** The newest status, again and again; `undefined` while the server is gone. */
export function listenToStatus(listener: (status: Status | Waiting | undefined) => void): void {
  const source = new EventSource('/api/events');
  source.addEventListener('status', (event) =>
    listener(JSON.parse((event as MessageEvent<string>).data) as Status | Waiting),
  );
  source.addEventListener('error', () => {
    listener(undefined);
    // The browser tries again by itself, except after an answer that is no event stream.
    if (source.readyState !== EventSource.CLOSED) return;
    setTimeout(() => listenToStatus(listener), 2000);
  });
}
