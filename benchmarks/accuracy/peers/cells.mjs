// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// The cells of the comparison, and how their problems are made by Morgagni's programs.

import { execFileSync } from 'node:child_process';
import { existsSync, rmSync } from 'node:fs';
import path from 'node:path';

import { FINE_METHODS, GLOBAL_METHODS, OWN_FINE, OWN_GLOBAL } from './methods.mjs';

const FRAMES = 20;

const STARTS = {
  rough: { label: '30 mm / 20°', args: ['--start', 'rough', '--starts', '20'] },
  tracked: { label: '5 mm / 2°', args: ['--start', 'tracked', '--starts', '20', '--start-error-mm', '5', '--start-error-deg', '2'] },
  none: { label: 'none', args: ['--start', 'none'] },
};

// Own recordings: every frame a camera place of its own, 0.8 m from the skin it looks at; clouds end
// at 1 m, as by default, so that little of the table is in them. Seeds from 1000 on: never tuned on.
const OWN = ['torso', 'torso_clutter', 'head', 'head_clutter'].map((name, index) => ({
  name,
  body: name.split('_')[0],
  camera: `simulated:path=views,distance=800,clutter=${name.endsWith('clutter') ? 'all' : 'none'},seed=${1001 + index},speed=full`,
}));
// The recordings of the data folder, on which Morgagni's engine and the peers' settings were tuned.
const SHARED = ['torso_clutter', 'torso_seq_clutter', 'head_clutter', 'head_seq'].map((name) => ({
  name: `data/${name}`,
  body: name.split('_')[0],
  folder: name,
}));

export function cells({ data }) {
  const cell = (source, start, share = 1) => ({ source, start, name: `${source.name}, ${start}`, share });
  return [
    ...OWN.map((source) => cell(source, 'rough')),
    ...OWN.map((source) => cell(source, 'tracked', 0.25)),
    ...(data ? SHARED.map((source) => cell(source, 'rough', 0.25)) : []),
    ...OWN.map((source) => cell(source, 'none')),
  ];
}

export const startLabel = ({ start }) => STARTS[start].label;
export const isGlobal = ({ start }) => start === 'none';
export const ownMethod = (cell) => (isGlobal(cell) ? OWN_GLOBAL : OWN_FINE);

// `share` of the starts for cells that only back the main ones up.
export function methodsOf(cell) {
  if (isGlobal(cell)) return GLOBAL_METHODS;
  return FINE_METHODS.map((method) => ({ ...method, starts: Math.max(1, Math.round(cell.share * method.starts)) }));
}

function record({ name, body, camera }, { builds, cases, work }) {
  const folder = path.join(work, 'recordings', name);
  if (existsSync(path.join(folder, 'groundtruth.txt'))) return folder;
  rmSync(folder, { recursive: true, force: true });
  execFileSync(path.join(builds.own, 'bin/morgagni'), [
    'record', '--case', path.join(cases, body), '--camera', camera, '--frames', String(FRAMES), '--targets', '50', '--out', folder,
  ], { stdio: ['ignore', 'ignore', 'inherit'] });
  return folder;
}

// Makes the cell's problems and returns their folder.
export function makeProblems(cell, setting) {
  const { source } = cell;
  const { builds, cases, work, data } = setting;
  const recording = source.folder ? path.join(data, 'synthetic_rgbd', source.folder) : record(source, setting);
  const problems = path.join(work, 'problems', cell.name.replace(/\W+/g, '_'));
  rmSync(problems, { recursive: true, force: true });
  execFileSync(path.join(builds.own, 'benchmarks/registration_problems'), [
    'export', problems, '--case', path.join(cases, source.body), '--recording', recording, '--frames', String(FRAMES),
    '--seed', '1000', ...STARTS[cell.start].args,
  ], { stdio: ['ignore', 'ignore', 'inherit'] });
  return problems;
}

// Problems whose answer is known to the last digit.
export function makeExactProblems(body, { builds, cases, work }) {
  const problems = path.join(work, 'problems', `exact_${body}`);
  execFileSync(path.join(builds.own, 'benchmarks/registration_problems'), [
    'export-exact', problems, '--case', path.join(cases, body),
  ], { stdio: ['ignore', 'ignore', 'inherit'] });
  return problems;
}
