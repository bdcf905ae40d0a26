// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

/** Does one thing at a time; of what is asked for meanwhile only the last is done. */
export class Latest<T> {
  private running = false;
  private next: { value: T } | undefined;

  constructor(private readonly act: (value: T) => Promise<void>) {}

  get isBusy(): boolean {
    return this.running;
  }

  ask(value: T): void {
    this.next = { value };
    if (!this.running) void this.run();
  }

  private async run(): Promise<void> {
    this.running = true;
    while (this.next) {
      const { value } = this.next;
      this.next = undefined;
      await this.act(value);
    }
    this.running = false;
  }
}
