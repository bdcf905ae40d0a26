// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// The comparison as Markdown.

const mm = (value) => (value < 1000 ? value.toFixed(2) : '> 1000');
const ms = (value) => (value < 10 ? value.toFixed(2) : value.toFixed(0));
const percent = (value) => `${(100 * value).toFixed(1)} %`;

export const FINE_HEAD = [
  '| case | start | method | frames x starts | < 10 mm | TRE of these | TRE mean ± SD | median | p95 | max | CPU ms median / p95 | x field |',
  '|---|---|---|---|---|---|---|---|---|---|---|---|',
].join('\n');

export function fineRow(cell, start, method, frames, result, own) {
  const { tre_mm: tre } = result;
  const ratio = result === own ? '1' : (result.cpu_ms.median / own.cpu_ms.median).toFixed(1);
  return `| ${cell} | ${start} | ${method} | ${frames} x ${Math.round(result.runs / frames)} | ${percent(result.success_rate)} `
    + `| ${result.tre_success_mm ? mm(result.tre_success_mm.mean) : '-'} | ${mm(tre.mean)} ± ${mm(tre.sd)} | ${mm(tre.median)} | ${mm(tre.p95)} | ${mm(tre.max)} `
    + `| ${ms(result.cpu_ms.median)} / ${ms(result.cpu_ms.p95)} | ${ratio} |`;
}

export const GLOBAL_HEAD = [
  '| case | method | frames | < 10 mm | > 15 mm | refused | TRE of those < 10 mm: mean, max | CPU ms median / p95 |',
  '|---|---|---|---|---|---|---|---|',
].join('\n');

export function globalRow(cell, method, result) {
  const good = result.tre_success_mm;
  return `| ${cell} | ${method} | ${result.runs} | ${percent(result.success_rate)} | ${percent(result.wrong_rate)} | ${percent(result.refused_rate)} `
    + `| ${good ? `${mm(good.mean)}, ${mm(good.max)}` : '-'} | ${ms(result.cpu_ms.median)} / ${ms(result.cpu_ms.p95)} |`;
}

export const STANDING_HEAD = [
  '| case | start | fastest peer as often right and as near | x field | fastest peer as often right | x field, its TRE / ours |',
  '|---|---|---|---|---|---|',
].join('\n');

const fastest = (list) => list.reduce((best, item) => (best === null || item.ratio < best.ratio ? item : best), null);

export function standingRow(cell, start, standings) {
  const good = fastest(standings.filter(({ is_as_good }) => is_as_good));
  const sure = fastest(standings.filter(({ is_as_sure }) => is_as_sure));
  return `| ${cell} | ${start} | ${good ? good.name : 'none'} | ${good ? good.ratio.toFixed(1) : '-'} `
    + `| ${sure ? sure.name : 'none'} | ${sure ? `${sure.ratio.toFixed(1)}, ${mm(sure.tre_mm.theirs)} / ${mm(sure.tre_mm.ours)} mm` : '-'} |`;
}
