// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { ClockSync } from './clock_sync';
import { FrameMeter } from './frame_meter';
import { asPictureInfo, PictureLog, type PictureInfo } from './picture_log';
import { sentenceOf } from './server_error';

export type Connection = 'connecting' | 'live' | 'stale' | 'gone';

/** A picture as the page showed it. */
export interface ShownPicture {
  rtp: number;
  at_ms: number;
  width: number;
  height: number;
  info: PictureInfo | undefined;
}

const STALE_AFTER_MS = 1000;
const RESTART_AFTER_MS = 6000;
const CONNECT_LIMIT_MS = 10000;
const PING_EVERY_MS = 1000;

/**
 * The live picture: WHEP to the server, a data channel with the words to each picture, and the
 * measure of how old what is shown is. Connects again by itself, for ever.
 */
export class LiveVideo {
  readonly pictures = new PictureLog();
  /** Why there is no picture, in the server's words where it has some. */
  problem = '';

  private readonly clock = new ClockSync();
  private readonly meter = new FrameMeter();
  private readonly listeners: ((picture: ShownPicture) => void)[] = [];
  private peer: RTCPeerConnection | undefined;
  private channel: RTCDataChannel | undefined;
  private resource: string | undefined;
  private attempt = 0;
  private started_ms = 0;
  private heard_ms = 0;
  private last: ShownPicture | undefined;

  constructor(readonly video: HTMLVideoElement) {
    // The attribute of an element made by a script does not mute it, and only a muted one plays by itself.
    video.muted = true;
    this.watchPictures();
    setInterval(() => this.tick(), PING_EVERY_MS);
    window.addEventListener('pagehide', () => this.leave());
    window.addEventListener('pageshow', (event) => {
      if (event.persisted) void this.connect();
    });
  }

  onPicture(listener: (picture: ShownPicture) => void): void {
    this.listeners.push(listener);
  }

  /** Milliseconds since the last new picture was shown. */
  ageMs(): number {
    return this.last ? performance.now() - this.last.at_ms : Infinity;
  }

  frameRate(): number {
    return this.meter.frameRate(performance.now());
  }

  /** Capture to display, median of the last two seconds. */
  latencyMs(): number | undefined {
    return this.meter.latencyMs();
  }

  state(): Connection {
    const connected = this.peer?.connectionState === 'connected';
    if (connected && this.ageMs() < STALE_AFTER_MS) return 'live';
    if (connected && this.last) return 'stale';
    return this.problem ? 'gone' : 'connecting';
  }

  lastPicture(): ShownPicture | undefined {
    return this.last;
  }

  async connect(): Promise<void> {
    this.leave();
    const attempt = ++this.attempt;
    this.started_ms = performance.now();
    this.heard_ms = this.started_ms;
    const peer = new RTCPeerConnection();
    this.peer = peer;
    peer.addTransceiver('video', { direction: 'recvonly' });
    peer.addEventListener('track', (event) => this.play(event));
    this.openChannel(peer);
    try {
      await peer.setLocalDescription(await peer.createOffer());
      const response = await fetch('/whep', {
        method: 'POST',
        headers: { 'Content-Type': 'application/sdp' },
        body: peer.localDescription?.sdp ?? '',
        signal: AbortSignal.timeout(CONNECT_LIMIT_MS),
      });
      const text = await response.text();
      if (!response.ok) throw new Error(sentenceOf(text));
      const resource = response.headers.get('Location') ?? undefined;
      if (attempt !== this.attempt) {
        if (resource) hangUp(resource);
        return;
      }
      this.resource = resource;
      await peer.setRemoteDescription({ type: 'answer', sdp: text });
      this.problem = '';
    } catch (error) {
      if (attempt !== this.attempt) return;
      this.problem = error instanceof Error && error.message ? error.message : String(error);
      if (error instanceof TypeError) this.problem = 'The server does not answer.';
      this.leave();
    }
  }

  private play(event: RTCTrackEvent): void {
    // What is shown must be what is now: no buffer for smoothness.
    const receiver = event.receiver as RTCRtpReceiver & {
      jitterBufferTarget?: number;
      playoutDelayHint?: number;
    };
    receiver.jitterBufferTarget = 0;
    receiver.playoutDelayHint = 0;
    this.video.srcObject = new MediaStream([event.track]);
    this.video.play().catch(() => undefined);
  }

  private openChannel(peer: RTCPeerConnection): void {
    const channel = peer.createDataChannel('pictures', { ordered: false });
    this.channel = channel;
    channel.addEventListener('open', () => this.ping());
    channel.addEventListener('message', (event) => {
      this.heard_ms = performance.now();
      const message: unknown = JSON.parse(String(event.data));
      const info = asPictureInfo(message);
      if (info) {
        this.pictures.add(info);
        return;
      }
      const { pong, server_ms } = message as { pong?: number; server_ms?: number };
      if (pong !== undefined && server_ms !== undefined) {
        this.clock.add(pong, server_ms, this.heard_ms);
      }
    });
  }

  private ping(): void {
    if (this.channel?.readyState !== 'open') return;
    this.channel.send(JSON.stringify({ ping: performance.now() }));
  }

  private tick(): void {
    this.ping();
    const now = performance.now();
    const state = this.peer?.connectionState;
    // A server that stands still answers pings; one that is gone does not.
    const silent_ms = now - this.heard_ms;
    const lost = state === 'connected' ? silent_ms > RESTART_AFTER_MS
      : now - this.started_ms > (this.peer ? CONNECT_LIMIT_MS : 1000);
    if (lost || state === 'failed') {
      if (this.peer) this.problem = 'The connection to the server is lost.';
      void this.connect();
    }
  }

  private leave(): void {
    this.peer?.close();
    this.peer = undefined;
    this.channel = undefined;
    if (this.resource) hangUp(this.resource);
    this.resource = undefined;
    this.pictures.clear();
    this.clock.clear();
  }

  private watchPictures(): void {
    this.video.requestVideoFrameCallback((_now, frame) => {
      const rtp = (frame as VideoFrameCallbackMetadata & { rtpTimestamp?: number }).rtpTimestamp;
      const at_ms = frame.expectedDisplayTime;
      const info = rtp === undefined ? undefined : this.pictures.get(rtp);
      const shown_ms = this.clock.toServer(at_ms);
      const latency_ms =
        info && shown_ms !== undefined ? Math.max(shown_ms - info.captured_ms, 0) : undefined;
      this.meter.add(at_ms, latency_ms);
      this.last = { rtp: rtp ?? -1, at_ms, width: frame.width, height: frame.height, info };
      for (const listener of this.listeners) listener(this.last);
      this.watchPictures();
    });
  }
}

function hangUp(resource: string): void {
  fetch(resource, { method: 'DELETE', keepalive: true }).catch(() => undefined);
}
