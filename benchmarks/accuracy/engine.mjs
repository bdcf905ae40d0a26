#!/usr/bin/env node
// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// The field engine on cases of its own, made with the simulated camera from seeds that nothing was tuned on (5600 and above;
// the engine was tuned on seeds below 1000, from 2000 to 2999 and from 4000 to 5220):
//   node benchmarks/accuracy/engine.mjs HEAD_CASE TORSO_CASE [FRAMES] [STARTS] [FIRST_SEED] [CELLS]
// Prints two Markdown tables: every cell, and the clutter cells by how much of the body is bare. Recordings and JSON reports stay in
// build/accuracy/engine. `views` are camera places that have nothing to do with each other, each with clutter of its own; `orbit` is a
// hand that moves on, with one arrangement of clutter a seed. A clutter cell has several times the frames, whatever they show, so
// that enough of them leave most of the body bare. CELLS: a regular expression over "head, views, all" and so on.

import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';

const PROGRAM = 'build/release/bin/morgagni';
const WORK = 'build/accuracy/engine';
const CLUTTER = ['none', 'hand', 'parts', 'towel', 'all'];
const ROUGH = ['30', '20'];
const TRACKED = ['5', '2'];
const ARRANGEMENTS = 4; // Of a clutter cell: seeds of an orbit, or as many times the views.
// Shares of the body's pixels that clutter leaves; the recordings of the data folder leave 65 to 94 %.
const BARE = [[0.6, 1.01], [0.4, 0.6], [0, 0.4]];

const [head, torso, frames = '20', starts = '20', firstSeed = '5400', wanted = ''] = process.argv.slice(2);
if (!torso) {
  console.error('usage: engine.mjs HEAD_CASE TORSO_CASE [FRAMES] [STARTS] [FIRST_SEED] [CELLS]');
  process.exit(2);
}

function record(name, folder, options, count) {
  const out = path.join(WORK, name);
  if (!existsSync(path.join(out, 'targets.csv'))) {
    execFileSync(PROGRAM, ['record', '--case', folder, '--camera', `simulated:${options}`, '--frames', count, '--targets', '20', '--out', out],
      { stdio: ['ignore', 'ignore', 'inherit'] });
  }
  return out;
}

function evaluate(recording, folder, [mm, deg], far, seed) {
  const report = `${recording}-${mm}mm.json`;
  execFileSync(PROGRAM, [
    'evaluate', 'recording', recording, '--case', folder, '--truth', path.join(recording, 'groundtruth.txt'),
    '--targets', path.join(recording, 'targets.csv'), '--truth-frame', 'ct', '--method', 'field', '--far-mm', far, '--starts', starts,
    '--start-error-mm', mm, '--start-error-deg', deg, '--seed', String(seed), '--json', report, ...(mm === '5' ? ['--tracked'] : []),
  ], { stdio: ['ignore', 'ignore', 'inherit'] });
  return JSON.parse(readFileSync(report, 'utf8'));
}

// The recordings of a cell: each a name, what the simulated camera is asked for, and how many frames.
function recordingsOf(body, camera, clutter, seed) {
  // One frame a second of an orbit: thirty a second would all be alike.
  const of = (number, count) => ({
    name: `${body}-${camera}-${clutter}-${count}-${number}`,
    options: `seed=${number},path=${camera},clutter=${clutter},fps=1,speed=full`,
    seed: number,
    count: String(count),
  });
  const count = Number(frames);
  if (clutter === 'none') return [of(seed, count)];
  if (camera === 'views') return [of(seed, count * ARRANGEMENTS)];
  return Array.from({ length: ARRANGEMENTS }, (_, i) => of(seed + 100 * i, count));
}

// The frames of reports with what they allow, each with its runs.
function framesOf(reports) {
  return reports.flatMap((report) => report.difficulty.map((frame) => ({
    ...frame,
    runs: report.runs.filter((run) => run.frame === frame.frame),
  })));
}

function quantile(values, share) {
  const sorted = [...values].sort((a, b) => a - b);
  const place = share * (sorted.length - 1);
  const low = Math.floor(place);
  return sorted[low] + (place - low) * ((sorted[low + 1] ?? sorted[low]) - sorted[low]);
}

const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;

// What a row of either table says of some frames.
function results(list) {
  const runs = list.flatMap((frame) => frame.runs);
  const tre = runs.map((run) => run.tre_mm);
  const good = tre.filter((mm) => mm < 10);
  const average = mean(good);
  return {
    frames: list.length,
    runs: runs.length,
    success: good.length / tre.length,
    mean: average,
    sd: Math.sqrt(mean(good.map((mm) => (mm - average) ** 2))),
    least: quantile(list.map((frame) => frame.least_tre_mm ?? Infinity), 0.5),
    median: quantile(tre, 0.5),
    p95: quantile(tre, 0.95),
    max: Math.max(...tre),
    ms: quantile(runs.map((run) => run.cpu_ms), 0.5),
    msP95: quantile(runs.map((run) => run.cpu_ms), 0.95),
  };
}

const fixed = (value, digits) => (Number.isFinite(value) ? value.toFixed(digits) : '-');

function row(labels, r) {
  return `| ${labels.join(' | ')} | ${r.frames} x ${(r.runs / r.frames).toFixed(0)} | ${fixed(100 * r.success, 1)} % | ${fixed(r.mean, 3)} ± ${fixed(r.sd, 3)} `
    + `| ${fixed(r.least, 3)} | ${fixed(r.median, 3)} | ${fixed(r.p95, 3)} | ${fixed(r.max, 1)} | ${fixed(r.ms, 2)} / ${fixed(r.msP95, 2)} |`;
}

const COLUMNS = 'runs | < 10 mm | TRE of successes, mean ± SD | Cramér-Rao bound, median frame | TRE median | p95 | max | processor ms median / p95 |';
const RULE = '---|---|---|---|---|---|---|---|';

mkdirSync(WORK, { recursive: true });
console.log(`| body | camera | clutter | bare, median / least | start | ${COLUMNS}`);
console.log(`|---|---|---|---|---|${RULE}`);
const cells = [];
let seed = Number(firstSeed);
for (const [body, folder] of [['torso', torso], ['head', head]]) {
  for (const camera of ['orbit', 'views']) {
    for (const clutter of CLUTTER) {
      seed += 1;
      if (!new RegExp(wanted).test(`${body}, ${camera}, ${clutter}`)) continue;
      const recordings = recordingsOf(body, camera, clutter, seed);
      for (const start of camera === 'orbit' ? [ROUGH, TRACKED] : [ROUGH]) {
        const list = framesOf(recordings.map(({ name, options, count, seed: own }) => evaluate(
          record(name, folder, options, count), folder, start, camera === 'views' ? '1500' : '1000', own)));
        const bare = list.map((frame) => frame.bare_share);
        cells.push({ body, camera, clutter, start, seeds: recordings.map((recording) => recording.seed), list });
        console.log(row([body, camera, clutter, `${(100 * quantile(bare, 0.5)).toFixed(0)} / ${(100 * Math.min(...bare)).toFixed(0)} %`, `${start[0]} mm / ${start[1]}°`], results(list)));
      }
    }
  }
}
console.log(`\n| body | camera | clutter | start | bare | ${COLUMNS}`);
console.log(`|---|---|---|---|---|${RULE}`);
for (const { body, camera, clutter, start, list } of cells.filter((cell) => cell.clutter !== 'none')) {
  for (const [from, to] of BARE) {
    const part = list.filter((frame) => frame.bare_share >= from && frame.bare_share < to);
    if (part.length === 0) continue;
    const label = from === 0 ? `< ${100 * to} %` : from === 0.6 ? '>= 60 %' : `${100 * from} to ${100 * to} %`;
    console.log(row([body, camera, clutter, `${start[0]} mm / ${start[1]}°`, label], results(part)));
  }
}
writeFileSync(path.join(WORK, 'engine.json'), `${JSON.stringify(cells, null, 1)}\n`);
