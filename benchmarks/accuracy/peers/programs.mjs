// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// The programs that register on request (answering.h), one process each.

import { spawn } from 'node:child_process';
import { createInterface } from 'node:readline';

// One thread each, whatever a library would take.
const ENVIRONMENT = { ...process.env, OMP_NUM_THREADS: '1', VTK_SMP_MAX_THREADS: '1', TBB_NUM_THREADS: '1' };

export class Program {
  constructor(command, args) {
    this.command = command;
    this.process = spawn(command, args, { env: ENVIRONMENT, stdio: ['pipe', 'pipe', 'inherit'] });
    this.lines = createInterface({ input: this.process.stdout })[Symbol.asyncIterator]();
    this.process.stdin.on('error', () => {}); // A program that died is noticed by its missing answer.
  }

  // The first `runs` runs of a frame: [{ pose, wall_ms, cpu_ms }, ...].
  async register(method, frame, runs) {
    this.process.stdin.write(`${method} ${frame} ${runs}\n`);
    const { value, done } = await this.lines.next();
    if (done) throw new Error(`${this.command} ended while it did ${method} on frame ${frame}`);
    const answer = JSON.parse(value);
    if (answer.error) throw new Error(`${this.command}, ${method}, frame ${frame}: ${answer.error}`);
    return answer.runs;
  }

  end() {
    this.process.stdin.end();
  }
}
