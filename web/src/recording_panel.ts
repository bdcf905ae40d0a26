// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import './recording_panel.css';
import { api, type RecordingState } from './api';
import { h, setText } from './dom';
import { recordingLine } from './recording_text';
import { button, type Toast } from './widgets';

const REFRESH_MS = 1000;

/** Records what the camera sees and where the body was found, into the case. */
export class RecordingPanel {
  readonly element: HTMLElement;

  private state: RecordingState | undefined;
  private busy = false;
  private readonly line = h('p', { class: 'recording-line', role: 'status' });
  private readonly key = button('Record for replay', 'record', () => void this.press());

  constructor(private readonly toast: Toast) {
    this.element = h('section', { class: 'group', 'aria-label': 'Sensor recording' },
      h('h2', {}, 'Sensor recording'), this.key, this.line);
    this.paint();
    setInterval(() => void this.refresh(), REFRESH_MS);
    void this.refresh();
  }

  /** Another tablet may have begun or ended it. */
  private async refresh(): Promise<void> {
    if (this.busy || this.element.offsetParent === null) return;
    const state = await api.getRecording().catch(() => undefined);
    if (!state || this.busy) return;
    this.state = state;
    this.paint();
  }

  private async press(): Promise<void> {
    if (this.busy) return;
    this.busy = true;
    this.key.disabled = true;
    try {
      const ending = this.state?.recording === true;
      this.state = await (ending ? api.stopRecording() : api.startRecording());
      if (ending) this.toast.say(`Recorded as ${this.state.file}`, 'good');
    } catch (error) {
      this.toast.sayError(error);
    } finally {
      this.busy = false;
      this.key.disabled = false;
      this.paint();
    }
  }

  private paint(): void {
    const recording = this.state?.recording === true;
    this.key.classList.toggle('recording', recording);
    this.key.setAttribute('aria-pressed', String(recording));
    setText(this.key.querySelector('span')!, recording ? 'Stop recording' : 'Record for replay');
    setText(this.line, recordingLine(this.state));
  }
}
