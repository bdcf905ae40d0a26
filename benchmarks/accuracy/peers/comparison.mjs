// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Runs the methods on one set of problems, in turns frame by frame, so that all meet the same
// moments of the machine, and judges the poses.

import { readFileSync } from 'node:fs';
import path from 'node:path';

import { Program } from './programs.mjs';
import { quantile, summarize, targetRegistrationErrorMm } from './statistics.mjs';

export const SUCCESS_MM = 10;
export const WRONG_MM = 15;

function startPrograms(methods, problems, caseFolder, builds) {
  const programs = new Map();
  for (const { program } of methods) {
    if (programs.has(program)) continue;
    programs.set(program, program === 'morgagni'
      ? new Program(path.join(builds.own, 'benchmarks/registration_problems'), ['answer', problems, '--case', caseFolder])
      : new Program(path.join(builds.peers, program), [problems]));
  }
  return programs;
}

// { frames, runs: { method: [{ frame, start, tre_mm, cpu_ms, wall_ms }] } }; tre_mm is null where a
// method said that it found nothing.
export async function compare({
  problems, caseFolder, methods, maxFrames = Infinity, maxStarts = Infinity, builds,
}) {
  const set = JSON.parse(readFileSync(path.join(problems, 'problems.json'), 'utf8'));
  const frames = set.frames.slice(0, maxFrames);
  const programs = startPrograms(methods, problems, caseFolder, builds);
  const runs = Object.fromEntries(methods.map(({ name }) => [name, []]));
  try {
    for (const [index, frame] of frames.entries()) {
      for (const { name, program, starts, frames: mostFrames = Infinity } of methods) {
        if (index >= mostFrames) continue;
        const num_runs = Math.min(starts, maxStarts, frame.runs.length);
        const answers = await programs.get(program).register(name, index, num_runs);
        for (const [start, { pose, cpu_ms, wall_ms }] of answers.entries()) {
          const tre_mm = pose && targetRegistrationErrorMm(pose, frame.truth, set.targets);
          runs[name].push({ frame: index, start, tre_mm, cpu_ms, wall_ms });
        }
      }
    }
  } finally {
    for (const program of programs.values()) program.end();
  }
  return { frames: frames.length, runs };
}

export function judge(runs) {
  const tre = runs.map(({ tre_mm }) => tre_mm).filter((value) => value !== null);
  const successes = tre.filter((value) => value < SUCCESS_MM);
  const times = (key) => ({ median: quantile(runs.map((run) => run[key]), 0.5), p95: quantile(runs.map((run) => run[key]), 0.95) });
  return {
    runs: runs.length,
    success_rate: successes.length / runs.length,
    wrong_rate: tre.filter((value) => value > WRONG_MM).length / runs.length,
    refused_rate: 1 - tre.length / runs.length,
    tre_mm: tre.length > 0 ? summarize(tre) : null,
    tre_success_mm: successes.length > 0 ? summarize(successes) : null,
    cpu_ms: times('cpu_ms'),
    wall_ms: times('wall_ms'),
  };
}

// How each peer stands to `own`, over the starts that both did.
export function standings(runs, own, isPeer) {
  return Object.keys(runs).filter(isPeer).map((name) => {
    const starts = 1 + Math.max(...runs[name].map(({ start }) => start));
    const ours = judge(runs[own].filter(({ start }) => start < starts));
    const theirs = judge(runs[name]);
    return {
      name,
      is_as_good: theirs.success_rate >= ours.success_rate && theirs.tre_mm.mean <= ours.tre_mm.mean,
      is_as_sure: theirs.success_rate >= ours.success_rate,
      ratio: theirs.cpu_ms.median / ours.cpu_ms.median,
      tre_mm: { theirs: theirs.tre_mm.mean, ours: ours.tre_mm.mean },
      success_rate: { theirs: theirs.success_rate, ours: ours.success_rate },
    };
  });
}
