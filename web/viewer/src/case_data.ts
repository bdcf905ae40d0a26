// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { Point3 } from '../../src/api';

export interface FindingPoint {
  ct_mm: Point3;
  on_skin: boolean;
  bound_mm: number | null;
}

export interface Finding {
  id: string;
  kind: 'point' | 'distance' | 'geodesic';
  note: string;
  points: FindingPoint[];
  path_ct_mm: Point3[];
  length_mm: number | null;
  length_bound_mm: number | null;
  created_at: string;
  photo: string | null;
}

export interface VolumeInfo {
  size: Point3;
  spacing_mm: Point3;
  origin_mm: Point3;
  /** The grid's x, y and z in the CT's frame. */
  axes: [Point3, Point3, Point3];
  source_spacing_mm: Point3;
  /** [code, HU]; straight in between; code 0 is not the body. */
  codes: [number, number][];
}

export interface CaseData {
  name: string;
  description: string;
  made_at: string;
  version: string;
  textured: boolean;
  seen_share: number;
  facts: [string, string][];
  findings: Finding[];
  remarks: string[];
  volume: VolumeInfo | null;
}

/** A block of data in this page. */
function block(name: string): string {
  return document.getElementById(`morgagni-${name}`)?.textContent ?? '';
}

export function caseData(): CaseData {
  return JSON.parse(block('case')) as CaseData;
}

/** Bytes that stand in the page as gzip in base64. */
export async function unpacked(name: string): Promise<ArrayBuffer> {
  const text = atob(block(name));
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Response(stream).arrayBuffer();
}

export function lengthWords(finding: Finding): string {
  if (finding.length_mm === null) return '';
  const bound = finding.length_bound_mm === null ? '' : ` ± ${finding.length_bound_mm.toFixed(1)}`;
  return `${finding.length_mm.toFixed(1)}${bound} mm`;
}
