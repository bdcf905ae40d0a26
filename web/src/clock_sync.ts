// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

/**
 * Relates the page's clock to the server's from round trips, so that latency is measured and not
 * guessed. The shortest of the recent round trips is the most honest one.
 */
export class ClockSync {
  private trips: { round_trip_ms: number; offset_ms: number }[] = [];

  /** @param sent_ms, received_ms page clock; @param server_ms the server's, in between. */
  add(sent_ms: number, server_ms: number, received_ms: number): void {
    const round_trip_ms = received_ms - sent_ms;
    if (!(round_trip_ms >= 0)) return;
    this.trips.push({ round_trip_ms, offset_ms: server_ms - (sent_ms + received_ms) / 2 });
    if (this.trips.length > 16) this.trips.shift();
  }

  /** A page time in the server's clock; undefined before the first round trip. */
  toServer(page_ms: number): number | undefined {
    if (this.trips.length === 0) return undefined;
    const best = this.trips.reduce((a, b) => (b.round_trip_ms < a.round_trip_ms ? b : a));
    return page_ms + best.offset_ms;
  }

  clear(): void {
    this.trips = [];
  }
}
