// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { call } from './api';
import { section } from './controls';
import { h, setClass, setText } from './dom';
import { icon } from './icons';
import { button, choice, type Toast } from './widgets';

type StillStyle = 'beside' | 'burned-in' | 'plain';

const STYLES = [
  ['beside', 'Below'],
  ['burned-in', 'On it'],
  ['plain', 'None'],
] as const satisfies readonly (readonly [StillStyle, string])[];

export interface VideoStatus {
  state: 'idle' | 'recording' | 'finishing';
  seconds: number;
  bytes: number;
  pictures: number;
  name: string;
  said: string;
  failed: boolean;
}

const LOOK_MS = 500;
const IDLE_LOOKS = 8;

/** "1:05, 12.3 MB". */
export function videoFigures({ seconds, bytes }: Pick<VideoStatus, 'seconds' | 'bytes'>): string {
  const whole = Math.floor(seconds);
  const clock = `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, '0')}`;
  return `${clock}, ${(bytes / 1e6).toFixed(1)} MB`;
}

/** Pictures and videos to take away. */
export class TakeawayPanel {
  readonly element: HTMLElement;

  private style: StillStyle = 'beside';
  private readonly stillKey = button('Save a still', 'snapshot', () => void this.takeStill());
  private readonly videoKey = button('Record the video', 'record', () => void this.toggleVideo(),
    'video-key');
  private readonly figures = h('p', { class: 'tip video-figures', role: 'status', hidden: true });
  private video: VideoStatus | undefined;
  private looks = 0;

  constructor(private readonly toast: Toast) {
    const style = choice('Scale, orientation, case, error', STYLES, (value) => (this.style = value));
    style.show(this.style);
    this.element = h('div', { class: 'take-away' },
      section('Still picture', style.element, this.stillKey),
      section('Video', this.videoKey, this.figures));
    setInterval(() => this.look(), LOOK_MS);
  }

  private async takeStill(): Promise<void> {
    this.stillKey.disabled = true;
    try {
      const { name } = await call<{ name: string }>('/api/still', { style: this.style });
      const response = await fetch(`/api/still.png?name=${encodeURIComponent(name)}`);
      if (!response.ok) throw new Error('The still is in the case, but could not be fetched.');
      const url = URL.createObjectURL(await response.blob());
      h('a', { href: url, download: name }).click();
      setTimeout(() => URL.revokeObjectURL(url), 10000);
      this.toast.say(`Saved in the case as pictures/${name}`, 'good');
    } catch (error) {
      this.toast.sayError(error);
    } finally {
      this.stillKey.disabled = false;
    }
  }

  private async toggleVideo(): Promise<void> {
    const verb = this.video?.state === 'recording' ? 'stop' : 'start';
    try {
      this.showVideo(await call<VideoStatus>(`/api/video/${verb}`, {}));
    } catch (error) {
      this.toast.sayError(error);
    }
    void this.poll();
  }

  /** Asks again and again: another tablet may start and stop it as well. Not while the tab is closed. */
  private look(): void {
    const isBusy = this.video !== undefined && this.video.state !== 'idle';
    const isSeen = this.element.offsetParent !== null;
    if (!isSeen && !isBusy) this.looks = 0;
    else if (isBusy || this.looks++ % IDLE_LOOKS === 0) void this.poll();
  }

  private async poll(): Promise<void> {
    const status = await call<VideoStatus>('/api/video').catch(() => undefined);
    if (status) this.showVideo(status);
  }

  private showVideo(status: VideoStatus): void {
    const before = this.video;
    this.video = status;
    const isRecording = status.state === 'recording';
    setClass(this.videoKey, `key video-key${isRecording ? ' recording' : ''}`);
    this.videoKey.setAttribute('aria-pressed', String(isRecording));
    this.videoKey.disabled = status.state === 'finishing';
    const words = { idle: 'Record the video', recording: 'Stop recording', finishing: 'Finishing …' };
    if (before?.state !== status.state) {
      this.videoKey.replaceChildren(icon(isRecording ? 'stop' : 'record'),
        h('span', {}, words[status.state]));
    }
    const text = isRecording ? videoFigures(status) : status.said;
    this.figures.hidden = text === '';
    setText(this.figures, text);
    if (status.state === 'idle' && before && before.state !== 'idle' && status.said !== '') {
      this.toast.say(status.said, status.failed ? 'bad' : 'good');
    }
  }
}
