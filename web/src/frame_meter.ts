// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

/** Frame rate and latency of what is really shown, over the last two seconds. */
export class FrameMeter {
  private shown: { at_ms: number; latency_ms: number | undefined }[] = [];

  constructor(private readonly window_ms = 2000) {}

  add(at_ms: number, latency_ms: number | undefined): void {
    this.shown.push({ at_ms, latency_ms });
    this.forget(at_ms);
  }

  /** Pictures a second; 0 while fewer than two are known. */
  frameRate(now_ms: number): number {
    this.forget(now_ms);
    const first = this.shown[0];
    const last = this.shown[this.shown.length - 1];
    if (!first || !last || first === last) return 0;
    return ((this.shown.length - 1) * 1000) / Math.max(last.at_ms - first.at_ms, 1);
  }

  latencyMs(): number | undefined {
    const known = this.shown
      .map((picture) => picture.latency_ms)
      .filter((latency): latency is number => latency !== undefined)
      .sort((a, b) => a - b);
    return known[Math.floor(known.length / 2)];
  }

  private forget(now_ms: number): void {
    while (this.shown.length > 0 && now_ms - this.shown[0]!.at_ms > this.window_ms) {
      this.shown.shift();
    }
  }
}
