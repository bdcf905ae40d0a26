// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { View } from './api';

/**
 * Sends changes of the view one after the other: while one is on its way, those that follow are
 * merged, so that a finger on a slider never queues up commands.
 */
export class ViewSender {
  private waiting: Partial<View> | undefined;
  private busy = false;

  constructor(
    private readonly send: (change: Partial<View>) => Promise<unknown>,
    private readonly onError: (error: unknown) => void,
  ) {}

  /** True while the server does not yet know all that the user did. */
  get isBusy(): boolean {
    return this.busy;
  }

  change(change: Partial<View>): void {
    this.waiting = merged(this.waiting, change);
    if (!this.busy) void this.run();
  }

  private async run(): Promise<void> {
    this.busy = true;
    while (this.waiting) {
      const next = this.waiting;
      this.waiting = undefined;
      try {
        await this.send(next);
      } catch (error) {
        this.onError(error);
      }
    }
    this.busy = false;
  }
}

function merged(before: Partial<View> | undefined, change: Partial<View>): Partial<View> {
  const all = { ...before, ...change };
  if (before?.structures) all.structures = { ...before.structures, ...change.structures };
  if (before?.structure_opacity) {
    all.structure_opacity = { ...before.structure_opacity, ...change.structure_opacity };
  }
  return all;
}
