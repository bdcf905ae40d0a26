// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { LiveVideo } from './live_video';
import type { PictureInfo } from './picture_log';

/** The pixels of one shown picture and the words that came with exactly that picture. */
export interface GrabbedFrame {
  rtp: number;
  at_ms: number;
  width: number;
  height: number;
  /** RGBA rows, base64: what a test outside of the browser can take. */
  pixels: string;
  info: PictureInfo | null;
}

/** Waits for the next picture and takes it, inside the call in which the browser shows it. */
export function grabFrame(live: LiveVideo): Promise<GrabbedFrame> {
  return new Promise((resolve, reject) => {
    live.video.requestVideoFrameCallback((_now, frame) => {
      const canvas = new OffscreenCanvas(frame.width, frame.height);
      const context = canvas.getContext('2d', { willReadFrequently: true });
      const rtp = (frame as VideoFrameCallbackMetadata & { rtpTimestamp?: number }).rtpTimestamp;
      if (!context || rtp === undefined) {
        reject(new Error('this browser cannot tell which picture it shows'));
        return;
      }
      context.drawImage(live.video, 0, 0, frame.width, frame.height);
      const { data } = context.getImageData(0, 0, frame.width, frame.height);
      const finish = (): void =>
        resolve({
          rtp,
          at_ms: frame.expectedDisplayTime,
          width: frame.width,
          height: frame.height,
          pixels: toBase64(data),
          info: live.pictures.get(rtp) ?? null,
        });
      // The words may come a little after the picture.
      if (live.pictures.get(rtp)) finish();
      else setTimeout(finish, 100);
    });
  });
}

function toBase64(bytes: Uint8ClampedArray): string {
  const parts: string[] = [];
  for (let start = 0; start < bytes.length; start += 0x8000) {
    parts.push(String.fromCharCode(...bytes.subarray(start, start + 0x8000)));
  }
  return btoa(parts.join(''));
}
