// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// The case that ./run shows without a CT of the user's own, made anew for a test.

import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, rmSync } from 'node:fs';
import { join } from 'node:path';

const DEMO_PROJECT = '/usr/share/doc/invesalius-examples/examples/Cranium.inv3';

/**
 * Prepares the case in an emptied folder; ends the test as skipped where its CT is not installed.
 * @returns {string} The case's folder.
 */
export function makeDemoCase(program, scratch, ...options) {
  if (!existsSync(DEMO_PROJECT)) {
    console.log(`skipped: ${DEMO_PROJECT} is not installed (Debian package invesalius-examples)`);
    process.exit(77);
  }
  rmSync(scratch, { recursive: true, force: true });
  mkdirSync(scratch, { recursive: true });
  execFileSync('bash', ['-c', `. scripts/demo_ct.sh && make_demo_ct '${scratch}'`]);
  const folder = join(scratch, 'case');
  execFileSync(program, ['prepare', join(scratch, 'head.mhd'), '--case', folder, ...options]);
  return folder;
}

/** Records so many frames of the simulated camera before it. @returns {string} The recording's folder. */
export function recordDemoCase(program, folder, frames) {
  const recording = join(folder, '..', 'recording');
  execFileSync(program, ['record', '--case', folder, '--camera', 'simulated:seed=5,distance=450',
    '--frames', `${frames}`, '--out', recording]);
  return recording;
}
