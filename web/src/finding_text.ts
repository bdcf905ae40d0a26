// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { Finding, FindingKind } from './findings_api';

/** "123.4 mm ± 2.1 mm"; without the bound where that is not known. */
export function lengthText(finding: Pick<Finding, 'length_mm' | 'length_bound_mm'>): string {
  if (finding.length_mm === null) return '';
  const length = `${finding.length_mm.toFixed(1)} mm`;
  return finding.length_bound_mm === null
    ? `${length}, uncertainty not known`
    : `${length} ± ${finding.length_bound_mm.toFixed(1)} mm`;
}

/** What a finding is, in one line. */
export function titleOf(finding: Finding): string {
  switch (finding.kind) {
    case 'distance':
      return `Straight ${lengthText(finding)}`;
    case 'geodesic':
      return `Over the skin ${lengthText(finding)}`;
    case 'point': {
      const [point] = finding.points;
      const place = point?.on_skin ? 'Point on the skin' : 'Point inside';
      return point?.bound_mm == null ? place : `${place}, ± ${point.bound_mm.toFixed(1)} mm`;
    }
  }
}

/** What to do next while a finding is made. */
export function adviceFor(kind: FindingKind, numPicked: number): string {
  if (kind === 'point') return 'Tap the point on the body';
  const where = kind === 'geodesic' ? ' on the skin' : '';
  return numPicked === 0 ? `Tap the first point${where}` : `Tap the second point${where}`;
}
