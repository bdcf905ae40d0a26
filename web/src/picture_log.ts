// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

/** What the server says about one picture; more members come through as they are. */
export interface PictureInfo {
  rtp: number;
  captured_ms: number;
  frame_id?: number;
  state?: string;
  [member: string]: unknown;
}

/**
 * Pairs pictures with what was said about them. The words travel beside the video and may come
 * before or after the picture they belong to; the 32-bit RTP stamp ties them together.
 */
export class PictureLog {
  private readonly infos = new Map<number, PictureInfo>();

  constructor(private readonly capacity = 240) {}

  add(info: PictureInfo): void {
    this.infos.delete(info.rtp);
    this.infos.set(info.rtp, info);
    if (this.infos.size > this.capacity) {
      this.infos.delete(this.infos.keys().next().value as number);
    }
  }

  get(rtp: number): PictureInfo | undefined {
    return this.infos.get(rtp);
  }

  clear(): void {
    this.infos.clear();
  }
}

/** A message of the data channel, if it is about a picture. */
export function asPictureInfo(message: unknown): PictureInfo | undefined {
  if (typeof message !== 'object' || message === null) return undefined;
  const { rtp, captured_ms } = message as Record<string, unknown>;
  return typeof rtp === 'number' && typeof captured_ms === 'number'
    ? (message as PictureInfo)
    : undefined;
}
