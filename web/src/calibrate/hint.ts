// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

/** What a sentence of the server asks for, as far as there is a picture for it. */
export type Hint = 'left' | 'right' | 'upper' | 'lower' | 'distance' | 'place' | 'wall' | 'more';

const EDGES: [RegExp, Hint][] = [
  [/left edge is nearer/, 'left'],
  [/right edge is nearer/, 'right'],
  [/upper edge is nearer/, 'upper'],
  [/lower edge is nearer/, 'lower'],
  [/\bwall\b/, 'wall'],
  [/distance/, 'distance'],
  [/hold the board at/, 'place'],
];

export function hintOf(sentence: string): Hint {
  return EDGES.find(([words]) => words.test(sentence))?.[1] ?? 'more';
}

const OUTLINES: Record<Hint, string> = {
  left: 'M14 10 L50 18 L50 46 L14 54 Z',
  right: 'M50 10 L14 18 L14 46 L50 54 Z',
  upper: 'M8 16 L56 16 L48 48 L16 48 Z',
  lower: 'M16 16 L48 16 L56 48 L8 48 Z',
  distance: 'M8 14 L38 14 L38 36 L8 36 Z M40 40 L56 40 L56 52 L40 52 Z',
  place: 'M6 10 L58 10 L58 54 L6 54 Z',
  wall: 'M4 8 L60 8 L60 56 L4 56 Z M20 20 L44 20 L44 38 L20 38 Z',
  more: 'M14 18 L50 18 L50 46 L14 46 Z M32 24 L32 40 M24 32 L40 32',
};

/** Column and row, 0..2, of the part of the picture that a sentence names. */
export function partOf(sentence: string): [number, number] {
  const column = /left/.test(sentence) ? 0 : /right/.test(sentence) ? 2 : 1;
  const row = /upper/.test(sentence) ? 0 : /lower/.test(sentence) ? 2 : 1;
  return [column, row];
}

/** The board as it is to be held, or where in the picture. */
export function hintPicture(hint: Hint, [column, row]: [number, number]): SVGSVGElement {
  const space = 'http://www.w3.org/2000/svg';
  const svg = document.createElementNS(space, 'svg');
  svg.setAttribute('viewBox', '0 0 64 64');
  svg.setAttribute('class', 'hint-picture');
  svg.setAttribute('aria-hidden', 'true');
  const path = document.createElementNS(space, 'path');
  path.setAttribute('d', OUTLINES[hint]);
  svg.append(path);
  if (hint === 'place') {
    const part = document.createElementNS(space, 'rect');
    part.setAttribute('x', String(9 + column * 16));
    part.setAttribute('y', String(13 + row * 13));
    part.setAttribute('width', '14');
    part.setAttribute('height', '12');
    part.setAttribute('class', 'part');
    svg.append(part);
  }
  return svg;
}
