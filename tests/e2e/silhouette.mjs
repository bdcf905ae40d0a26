// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Where a mesh must appear in a picture, computed from scratch: independent of the program under test.

import { readFile } from 'node:fs/promises';
import path from 'node:path';

const BYTES = { float: 4, float32: 4, double: 8, int: 4, uint: 4, int32: 4, uint32: 4, uchar: 1, uint8: 1 };

/** Vertices (LPS mm, flat) and triangles (flat) of a binary little-endian PLY. */
export async function readPly(file) {
  const bytes = await readFile(file);
  const end = bytes.indexOf('end_header\n') + 'end_header\n'.length;
  const elements = [];
  for (const line of bytes.toString('latin1', 0, end).split('\n')) {
    const words = line.trim().split(/\s+/);
    if (words[0] === 'element') elements.push({ name: words[1], count: Number(words[2]), properties: [] });
    if (words[0] === 'property') elements.at(-1).properties.push(words.slice(1));
  }
  const [vertex, face] = elements;
  const stride = vertex.properties.reduce((sum, [type]) => sum + BYTES[type], 0);
  const vertices = new Float32Array(3 * vertex.count);
  for (let i = 0; i < vertex.count; i++) {
    for (let axis = 0; axis < 3; axis++) vertices[3 * i + axis] = bytes.readFloatLE(end + i * stride + 4 * axis);
  }
  const countBytes = BYTES[face.properties[0][1]];
  const first = end + vertex.count * stride;
  const triangles = new Uint32Array(3 * face.count);
  for (let i = 0; i < face.count; i++) {
    const at = first + i * (countBytes + 12) + countBytes;
    for (let corner = 0; corner < 3; corner++) triangles[3 * i + corner] = bytes.readUInt32LE(at + 4 * corner);
  }
  return { vertices, triangles };
}

/** The true poses of a TUM recording, ct_from_camera: RAS metres in the file, LPS mm here. */
export async function readTruth(recording) {
  const text = await readFile(path.join(recording, 'groundtruth.txt'), 'utf8');
  const rows = text.split('\n').filter((line) => line && !line.startsWith('#'));
  return rows.map((row) => {
    const [, tx, ty, tz, x, y, z, w] = row.trim().split(/\s+/).map(Number);
    const ras = [
      [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 1000 * tx],
      [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), 1000 * ty],
      [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), 1000 * tz],
    ];
    const negated = (r) => r.map((value) => -value);
    return [negated(ras[0]), negated(ras[1]), ras[2]];
  });
}

/** Pixels (1 where covered) that `mesh` covers for a pinhole camera at `ctFromCamera`. */
export function silhouette(mesh, camera, ctFromCamera) {
  const { vertices, triangles } = mesh;
  const projected = new Float32Array(2 * (vertices.length / 3));
  const [r0, r1, r2] = ctFromCamera;
  for (let i = 0; i < vertices.length / 3; i++) {
    const d = [vertices[3 * i] - r0[3], vertices[3 * i + 1] - r1[3], vertices[3 * i + 2] - r2[3]];
    const [x, y, z] = [0, 1, 2].map((axis) => r0[axis] * d[0] + r1[axis] * d[1] + r2[axis] * d[2]);
    projected[2 * i] = (camera.fx * x) / z + camera.cx;
    projected[2 * i + 1] = (camera.fy * y) / z + camera.cy;
  }
  const mask = new Uint8Array(camera.width * camera.height);
  for (let t = 0; t < triangles.length; t += 3) {
    fill(mask, camera, projected, triangles[t], triangles[t + 1], triangles[t + 2]);
  }
  return mask;
}

function fill(mask, { width, height }, p, a, b, c) {
  const [ax, ay, bx, by, cx, cy] = [p[2 * a], p[2 * a + 1], p[2 * b], p[2 * b + 1], p[2 * c], p[2 * c + 1]];
  const area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
  if (area === 0 || !Number.isFinite(area)) return;
  const clamp = (value, most) => Math.max(0, Math.min(most, value));
  const x0 = clamp(Math.ceil(Math.min(ax, bx, cx)), width);
  const x1 = clamp(Math.floor(Math.max(ax, bx, cx)), width - 1);
  const y0 = clamp(Math.ceil(Math.min(ay, by, cy)), height);
  const y1 = clamp(Math.floor(Math.max(ay, by, cy)), height - 1);
  for (let y = y0; y <= y1; y++) {
    for (let x = x0; x <= x1; x++) {
      const u = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area;
      const v = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area;
      if (u >= 0 && v >= 0 && u + v <= 1) mask[y * width + x] = 1;
    }
  }
}

/** Share of the union that `a` and `b`, moved by (dx, dy), have in common. */
export function overlap(a, b, width, height, dx = 0, dy = 0) {
  let both = 0;
  let either = 0;
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      const inA = a[y * width + x];
      const [sx, sy] = [x - dx, y - dy];
      const inB = sx >= 0 && sy >= 0 && sx < width && sy < height ? b[sy * width + sx] : 0;
      both += inA & inB;
      either += inA | inB;
    }
  }
  return either ? both / either : 0;
}
