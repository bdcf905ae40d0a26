// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Checks the comparison itself: the measure on poses with known errors, and every method on problems
// whose moving cloud is a part of the skin. From the truth, none may leave it.

import assert from 'node:assert/strict';
import path from 'node:path';

import { makeExactProblems } from './cells.mjs';
import { compare } from './comparison.mjs';
import { FINE_METHODS, GLOBAL_METHODS, OWN_GLOBAL } from './methods.mjs';
import { quantile, summarize, targetRegistrationErrorMm } from './statistics.mjs';

// Methods that do not pair points with points or surfaces come no nearer.
const LIMIT_MM = { 'pcl-ndt': 5, 'pcl-gicp': 0.5 };
const DEFAULT_LIMIT_MM = 0.1;
// Point-to-point methods end early on smooth skin; the start is up to 3 mm / 1 degree off.
const DISTURBED_LIMIT_MM = 5;

function checkMeasures() {
  assert.equal(quantile([4, 1, 3, 2], 0.5), 2.5);
  assert.equal(quantile([1, 2, 3, 4, 5], 0.95), 4.8);
  const { mean, sd, max } = summarize([1, 2, 3]);
  assert.deepEqual([mean, sd, max], [2, 1, 3]);
  const truth = [0, -1, 0, 10, 1, 0, 0, 20, 0, 0, 1, 30, 0, 0, 0, 1];
  const targets = [[1, 2, 3], [-40, 50, 60]];
  assert.ok(targetRegistrationErrorMm(truth, truth, targets) < 1e-12);
  const shifted = truth.map((value, i) => (i === 7 ? value + 3 : value));
  assert.ok(Math.abs(targetRegistrationErrorMm(shifted, truth, targets) - 3) < 1e-12);
  assert.equal(targetRegistrationErrorMm(truth.map(() => NaN), truth, targets), Infinity);
}

export async function selfTest(setting) {
  checkMeasures();
  const methods = [...FINE_METHODS, ...GLOBAL_METHODS].filter(({ name }) => name !== OWN_GLOBAL);
  for (const body of ['head', 'torso']) {
    const { runs } = await compare({
      problems: makeExactProblems(body, setting), caseFolder: path.join(setting.cases, body), methods, builds: setting.builds,
    });
    for (const { name } of methods) {
      for (const { start, tre_mm } of runs[name]) {
        const limit_mm = start === 0 ? LIMIT_MM[name] ?? DEFAULT_LIMIT_MM : DISTURBED_LIMIT_MM;
        assert.ok(tre_mm < limit_mm, `${body}, ${name}, start ${start}: ${tre_mm} mm off, allowed are ${limit_mm}`);
      }
    }
  }
}
