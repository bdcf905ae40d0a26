#!/usr/bin/env node
// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Morgagni's registrations and other libraries' on the same problems; ./run builds all and calls it.
// Prints Markdown; the report as JSON lies in WORK/report.json.

import { execFileSync } from 'node:child_process';
import { mkdirSync, writeFileSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { parseArgs } from 'node:util';

import { cells, isGlobal, makeProblems, methodsOf, ownMethod, startLabel } from './cells.mjs';
import { compare, judge, standings } from './comparison.mjs';
import { isPeer } from './methods.mjs';
import { selfTest } from './self_test.mjs';
import { FINE_HEAD, fineRow, GLOBAL_HEAD, globalRow, STANDING_HEAD, standingRow } from './tables.mjs';

const { values: options } = parseArgs({
  options: {
    cases: { type: 'string' }, // Folder with the prepared cases head and torso.
    own: { type: 'string' }, // Morgagni's build folder.
    peers: { type: 'string' }, // The peers' build folder.
    work: { type: 'string' }, // For recordings, problems and the report.
    data: { type: 'string' }, // Folder with synthetic_rgbd: its recordings are measured too.
    starts: { type: 'string', default: '20' }, // Most starts a frame.
    frames: { type: 'string', default: '20' }, // Most frames a cell.
    only: { type: 'string', default: '' }, // Cells whose name has this regular expression.
    methods: { type: 'string', default: '' }, // Peers whose name has this one; ours always run.
    'self-test': { type: 'boolean', default: false }, // Only check the comparison itself.
  },
});

const setting = { ...options, builds: { own: options.own, peers: options.peers } };

function machine() {
  const versions = execFileSync('dpkg-query', ['-W', '-f', '${Package} ${Version}\n', 'libpcl-dev', 'libopen3d-dev', 'libvtk9-dev'], { encoding: 'utf8' });
  const commit = execFileSync('git', ['rev-parse', '--short', 'HEAD'], { encoding: 'utf8' }).trim();
  return { cpu: os.cpus()[0].model, cores: os.cpus().length, peers: versions.trim().split('\n'), commit };
}

async function runCell(cell) {
  const methods = methodsOf(cell).filter(({ name }) => !isPeer(name) || new RegExp(options.methods).test(name));
  const { frames, runs } = await compare({
    problems: makeProblems(cell, setting),
    caseFolder: path.join(options.cases, cell.source.body),
    methods,
    maxFrames: Number(options.frames),
    maxStarts: Number(options.starts),
    builds: setting.builds,
  });
  const results = Object.fromEntries(Object.entries(runs).map(([name, list]) => [name, judge(list)]));
  return { cell: cell.source.name, start: startLabel(cell), frames, results, runs };
}

function printCell(cell, { frames, results }) {
  const own = results[ownMethod(cell)];
  for (const [method, result] of Object.entries(results)) {
    console.log(isGlobal(cell) ? globalRow(cell.source.name, method, result) : fineRow(cell.source.name, startLabel(cell), method, frames, result, own));
  }
}

async function main() {
  mkdirSync(options.work, { recursive: true });
  if (options['self-test']) return selfTest(setting);
  const report = { machine: machine(), cells: [] };
  const wanted = cells(options).filter(({ name }) => new RegExp(options.only).test(name));
  const standingRows = [];
  for (const [kind, head] of [[false, FINE_HEAD], [true, GLOBAL_HEAD]]) {
    const part = wanted.filter((cell) => isGlobal(cell) === kind);
    if (part.length > 0) console.log(`${head}`);
    for (const cell of part) {
      const measured = await runCell(cell);
      report.cells.push(measured);
      printCell(cell, measured);
      if (!kind) standingRows.push(standingRow(cell.source.name, startLabel(cell), standings(measured.runs, ownMethod(cell), isPeer)));
    }
    if (part.length > 0) console.log('');
  }
  if (standingRows.length > 0) console.log([STANDING_HEAD, ...standingRows].join('\n'));
  console.log(`\n${report.machine.cpu}, ${report.machine.peers.join(', ')}; commit ${report.machine.commit}`);
  return writeFileSync(path.join(options.work, 'report.json'), `${JSON.stringify(report)}\n`);
}

await main();
