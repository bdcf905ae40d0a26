#!/usr/bin/env node
// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Target registration error and time of every method on the simulated recordings with known truth:
//   node benchmarks/accuracy/synthetic_rgbd.mjs DATA [STARTS] [METHOD,METHOD...]
// DATA holds synthetic_rgbd/, ct_head_invesalius/ and ct_chest_lidc0314/. Prints a Markdown table; the
// JSON reports and the prepared cases stay in build/accuracy.

import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync } from 'node:fs';
import path from 'node:path';

const RECORDINGS = ['head_seq', 'head_clutter', 'head_clutter_real', 'torso_seq_clutter', 'torso_clutter', 'torso_clutter_real'];
const PROGRAM = 'build/release/bin/morgagni';
const WORK = 'build/accuracy';

const [data, starts = '20', methods = 'field,icp,trimmed-icp'] = process.argv.slice(2);
if (!data) {
  console.error('usage: synthetic_rgbd.mjs DATA [STARTS] [METHOD,METHOD...]');
  process.exit(2);
}

function prepare(body) {
  const folder = path.join(WORK, body);
  if (existsSync(path.join(folder, 'case.json'))) return folder;
  let ct = path.join(data, 'ct_head_invesalius/promed_ct_0051.nii.gz');
  if (body === 'torso') {
    ct = path.join(WORK, 'chest_dicom');
    mkdirSync(ct, { recursive: true });
    execFileSync('tar', ['xJf', path.join(data, 'ct_chest_lidc0314/lidc0314_138x2mm_dicom.tar.xz'), '-C', ct]);
  }
  execFileSync(PROGRAM, ['prepare', ct, '--case', folder], { stdio: 'inherit' });
  return folder;
}

function evaluate(recording, folder, method, extra) {
  const source = path.join(data, 'synthetic_rgbd', recording);
  const report = path.join(WORK, `${recording}-${method}${extra.length ? '-starts' : '-tracked'}.json`);
  execFileSync(PROGRAM, [
    'evaluate', 'recording', source, '--case', folder, '--truth', path.join(source, 'groundtruth.txt'),
    '--targets', path.join(source, 'targets.csv'), '--method', method, '--json', report, ...extra,
  ], { stdio: ['ignore', 'ignore', 'inherit'] });
  return JSON.parse(readFileSync(report, 'utf8'));
}

function row(recording, mode, { method, frames, starts, success_rate, tre_mm, tre_success_mm, registration_cpu_ms, points }) {
  const mm = (value) => (value === null ? '-' : value.toFixed(2));
  console.log(`| ${recording} | ${mode} | ${method} | ${frames} x ${Math.max(1, starts)} | ${(100 * success_rate).toFixed(1)} % `
    + `| ${mm(tre_success_mm.mean)} | ${mm(tre_mm.mean)} ± ${mm(tre_mm.sd)} | ${mm(tre_mm.median)} | ${mm(tre_mm.p95)} | ${mm(tre_mm.max)} `
    + `| ${registration_cpu_ms.median.toFixed(2)} / ${registration_cpu_ms.p95.toFixed(2)} | ${Math.round(points)} |`);
}

mkdirSync(WORK, { recursive: true });
console.log('| recording | start | method | runs | < 10 mm | mean TRE of successes | TRE mean ± SD | median | p95 | max | processor ms median / p95 | points |');
console.log('|---|---|---|---|---|---|---|---|---|---|---|---|');
for (const recording of RECORDINGS) {
  const folder = prepare(recording.split('_')[0]);
  for (const method of methods.split(',')) {
    if (recording.includes('seq')) row(recording, 'last pose', evaluate(recording, folder, method, []));
    row(recording, '30 mm / 20°', evaluate(recording, folder, method, ['--starts', starts, '--start-error-mm', '30', '--start-error-deg', '20']));
  }
}
