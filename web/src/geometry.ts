// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

export interface Size {
  width: number;
  height: number;
}
export interface Point {
  x: number;
  y: number;
}
export interface Box extends Point, Size {}

/** Where a picture of this size lies in a box that shows all of it (CSS object-fit: contain). */
export function containedBox(box: Size, picture: Size): Box {
  const scale = Math.min(box.width / picture.width, box.height / picture.height);
  const width = picture.width * scale;
  const height = picture.height * scale;
  return { x: (box.width - width) / 2, y: (box.height - height) / 2, width, height };
}

/** A point of the box in the picture's own pixels; undefined beside the picture. */
export function toPicture(point: Point, box: Size, picture: Size): Point | undefined {
  const shown = containedBox(box, picture);
  if (!(shown.width > 0 && shown.height > 0)) return undefined;
  const x = ((point.x - shown.x) / shown.width) * picture.width;
  const y = ((point.y - shown.y) / shown.height) * picture.height;
  if (x < 0 || y < 0 || x > picture.width || y > picture.height) return undefined;
  return { x, y };
}

/** The way back. */
export function fromPicture(point: Point, box: Size, picture: Size): Point {
  const shown = containedBox(box, picture);
  return {
    x: shown.x + (point.x / picture.width) * shown.width,
    y: shown.y + (point.y / picture.height) * shown.height,
  };
}

/** The server counts pixels from the middle of the first one, the page from the picture's corner. */
export function toServer({ x, y }: Point): Point {
  return { x: x - 0.5, y: y - 0.5 };
}

export function clamp(value: number, low: number, high: number): number {
  return Math.min(Math.max(value, low), high);
}
