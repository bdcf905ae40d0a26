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

type PictureMetadata = VideoFrameCallbackMetadata & { rtpTimestamp?: number };

/**
 * Waits for the next picture and takes it. The picture is held first and named by what is held:
 * on a busy machine the browser may already show the next one when it calls back.
 */
export function grabFrame(live: LiveVideo): Promise<GrabbedFrame> {
  return new Promise((resolve, reject) => {
    const take = (_now: number, metadata: PictureMetadata): void => {
      const held = new VideoFrame(live.video);
      const rtp = stampOf(held, metadata);
      if (rtp === undefined) {
        held.close();
        live.video.requestVideoFrameCallback(take);
        return;
      }
      const { displayWidth: width, displayHeight: height } = held;
      const context = new OffscreenCanvas(width, height).getContext('2d');
      context?.drawImage(held, 0, 0);
      held.close();
      if (!context) {
        reject(new Error('this browser gives no canvas'));
        return;
      }
      const pixels = toBase64(context.getImageData(0, 0, width, height).data);
      const at_ms = metadata.expectedDisplayTime;
      const finish = (): void =>
        resolve({ rtp, at_ms, width, height, pixels, info: live.pictures.get(rtp) ?? null });
      // The words may come a little after the picture.
      if (live.pictures.get(rtp)) finish();
      else setTimeout(finish, 200);
    };
    live.video.requestVideoFrameCallback(take);
  });
}

/** The RTP stamp of the held picture; undefined where it is not the one of the metadata. */
function stampOf(held: VideoFrame, metadata: PictureMetadata): number | undefined {
  const own = (held as VideoFrame & { metadata?: () => { rtpTimestamp?: number } }).metadata?.();
  if (own?.rtpTimestamp !== undefined) return own.rtpTimestamp;
  const isSame = Math.abs(held.timestamp - metadata.mediaTime * 1e6) < 1;
  return isSame ? metadata.rtpTimestamp : undefined;
}

function toBase64(bytes: Uint8ClampedArray): string {
  const parts: string[] = [];
  for (let start = 0; start < bytes.length; start += 0x8000) {
    parts.push(String.fromCharCode(...bytes.subarray(start, start + 0x8000)));
  }
  return btoa(parts.join(''));
}
