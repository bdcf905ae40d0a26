// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { TextureInfo } from './api';

const OF_LAST: Record<string, string> = {
  fused: 'Recording. Move slowly around the body, over what is striped.',
  'nothing new': 'This is recorded already: move on to what is striped.',
  uncertain: 'The body is not placed surely enough: hold still, show more of it.',
  moving: 'Too fast: move more slowly.',
  'no skin': 'No bare skin in view: come nearer, take away what covers it.',
  misfit: 'The picture does not fit what is recorded: hold still, or start again.',
  full: 'The texture has as many pictures as it can keep.',
};

/** What to do next, in one sentence. */
export function textureAdvice(info: TextureInfo | undefined): string {
  if (!info) return 'The server does not answer.';
  if (info.problem) return info.problem;
  if (!info.ready) return 'The skin is being unwrapped …';
  if (info.recording) return OF_LAST[info.last ?? ''] ?? 'Recording begins when the body is tracked.';
  if (info.frames === 0) return 'Record, and move the tablet slowly around the body.';
  return `Paused, ${info.frames} ${info.frames === 1 ? 'picture' : 'pictures'}. Record goes on from here.`;
}

export function textureSaved(info: TextureInfo | undefined): string {
  if (!info || info.frames === 0) return '';
  if (info.saving) return 'Saving …';
  return info.saved ? 'Saved in the case.' : 'Not saved yet.';
}
