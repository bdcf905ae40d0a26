// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Runs the methods on one set of problems, in turns frame by frame, so that all meet the same
// moments of the machine; judges the poses and makes the table.

import { readFileSync } from 'node:fs';
import path from 'node:path';

import { OWN } from './methods.mjs';
import { Program } from './programs.mjs';
import { quantile, summarize, targetRegistrationErrorMm } from './statistics.mjs';

const SUCCESS_MM = 10;

// { runs: { method: [{ frame, tre_mm, cpu_ms, wall_ms }] }, frames }. `maxStarts` cuts all methods.
export async function compare({ problems, caseFolder, methods, maxStarts, builds }) {
  const { frames, targets } = JSON.parse(readFileSync(path.join(problems, 'problems.json'), 'utf8'));
  const programs = new Map();
  for (const { program } of methods) {
    if (programs.has(program)) continue;
    const own = program === 'morgagni';
    programs.set(program, own
      ? new Program(path.join(builds.own, 'registration_problems'), ['answer', problems, '--case', caseFolder])
      : new Program(path.join(builds.peers, program), [problems]));
  }
  const runs = Object.fromEntries(methods.map(({ name }) => [name, []]));
  for (const [index, frame] of frames.entries()) {
    for (const { name, program, starts } of methods) {
      const answers = await programs.get(program).register(name, index, Math.min(starts, maxStarts));
      for (const { pose, cpu_ms, wall_ms } of answers) {
        runs[name].push({ frame: index, tre_mm: targetRegistrationErrorMm(pose, frame.truth, targets), cpu_ms, wall_ms });
      }
    }
  }
  for (const program of programs.values()) program.end();
  return { frames: frames.length, runs };
}

export function judge(runs) {
  const tre = runs.map(({ tre_mm }) => tre_mm);
  const successes = tre.filter((value) => value < SUCCESS_MM);
  const cpu = runs.map(({ cpu_ms }) => cpu_ms);
  return {
    runs: runs.length,
    success_rate: successes.length / runs.length,
    tre_mm: summarize(tre),
    tre_success_mm: successes.length > 0 ? summarize(successes) : null,
    cpu_ms: { median: quantile(cpu, 0.5), p95: quantile(cpu, 0.95) },
    wall_ms_median: quantile(runs.map(({ wall_ms }) => wall_ms), 0.5),
  };
}

const mm = (value) => (value < 1000 ? value.toFixed(2) : '> 1000');
const ms = (value) => (value < 10 ? value.toFixed(2) : value.toFixed(0));

export const TABLE_HEAD = [
  '| case | method | frames x starts | < 10 mm | TRE of successes | TRE mean ± SD | median | p95 | max | CPU ms median / p95 | x field |',
  '|---|---|---|---|---|---|---|---|---|---|---|',
];

export function tableRow(cell, method, frames, result, own) {
  const { tre_mm: tre } = result;
  const ratio = own && method !== OWN ? (result.cpu_ms.median / own.cpu_ms.median).toFixed(1) : '';
  return `| ${cell} | ${method} | ${frames} x ${Math.round(result.runs / frames)} | ${(100 * result.success_rate).toFixed(1)} % `
    + `| ${result.tre_success_mm ? mm(result.tre_success_mm.mean) : '-'} | ${mm(tre.mean)} ± ${mm(tre.sd)} | ${mm(tre.median)} | ${mm(tre.p95)} | ${mm(tre.max)} `
    + `| ${ms(result.cpu_ms.median)} / ${ms(result.cpu_ms.p95)} | ${ratio} |`;
}

// The fastest peer that is right at least as often as ours and at least as near on average; none: the
// fastest one among those that are right most often.
export function bestPeer(results, isPeer) {
  const own = results[OWN];
  const peers = Object.entries(results).filter(([name]) => isPeer(name));
  const fastest = (list) => list.reduce((a, b) => (b[1].cpu_ms.median < a[1].cpu_ms.median ? b : a));
  const asGood = peers.filter(([, result]) => result.success_rate >= own.success_rate && result.tre_mm.mean <= own.tre_mm.mean);
  const most = Math.max(...peers.map(([, result]) => result.success_rate));
  const [name, result] = fastest(asGood.length > 0 ? asGood : peers.filter((peer) => peer[1].success_rate === most));
  return { name, as_good: asGood.length > 0, ratio: result.cpu_ms.median / own.cpu_ms.median, result };
}
