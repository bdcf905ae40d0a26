// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { h } from './dom';
import type { LiveVideo, ShownPicture } from './live_video';
import type { Stage } from './stage';

/** x and y in the picture's pixels; 1: hidden by the body. */
type Place = [number, number, number];

export interface Mark {
  id: string;
  kind: string;
  label: string;
  points: Place[];
  line: Place[];
}

/** The marks that the server sent with a picture; whatever else is there is left out. */
export function marksOf(info: Record<string, unknown> | undefined): Mark[] {
  const marks = info?.['marks'];
  return Array.isArray(marks) ? (marks as Mark[]) : [];
}

const LABEL_WIDTH = 150;
const LABEL_HEIGHT = 19;

/** The first line at or below `y` that no other words cover. */
export function freeLine(labels: [number, number][], x: number, y: number, px: number): number {
  let line = y;
  const covers = ([other_x, other_y]: [number, number]): boolean =>
    Math.abs(other_x - x) < LABEL_WIDTH * px && Math.abs(other_y - line) < 0.9 * LABEL_HEIGHT * px;
  for (let i = 0; i < 8 && labels.some(covers); ++i) line += LABEL_HEIGHT * px;
  labels.push([x, line]);
  return line;
}

const SVG = 'http://www.w3.org/2000/svg';

function svg(tag: string, attributes: Record<string, string | number>, text?: string): SVGElement {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  if (text !== undefined) element.textContent = text;
  return element;
}

/**
 * The findings on the live picture. They come with each picture, and are drawn when that picture is
 * shown: they stay on the body, whatever the delay.
 */
export class FindingMarks {
  private readonly drawing = document.createElementNS(SVG, 'svg');
  private last = '[]';
  private chosen: string | undefined;

  constructor(private readonly stage: Stage, live: LiveVideo) {
    this.drawing.setAttribute('class', 'finding-marks');
    this.drawing.setAttribute('aria-hidden', 'true');
    stage.video.after(this.drawing);
    live.onPicture((picture) => this.show(picture));
  }

  /** One is drawn larger: the one that is looked at in the list. */
  choose(id: string | undefined): void {
    this.chosen = id;
    this.last = '';
  }

  private show(picture: ShownPicture): void {
    const marks = marksOf(picture.info);
    const text = JSON.stringify(marks);
    const box = this.stage.element.getBoundingClientRect();
    const view = `0 0 ${picture.width} ${picture.height}`;
    const scale = Math.min(box.width / picture.width, box.height / picture.height);
    const key = `${text} ${view} ${scale}`;
    if (key === this.last || !(scale > 0)) return;
    this.last = key;
    this.drawing.setAttribute('viewBox', view);
    // Sizes are those of the page, whatever the picture's.
    this.drawing.style.setProperty('--px', String(1 / scale));
    const labels: [number, number][] = [];
    this.drawing.replaceChildren(...marks.map((mark) => this.draw(mark, 1 / scale, labels)));
  }

  /** @param labels  Where words stand already; none are put on others. */
  private draw(mark: Mark, px: number, labels: [number, number][]): SVGElement {
    const group = svg('g', { 'class': `finding ${mark.kind}`, 'data-id': mark.id });
    group.classList.toggle('chosen', mark.id !== '' && mark.id === this.chosen);
    // A pixel's centre lies half a pixel from its corner.
    const at = ([x, y]: Place): [number, number] => [x + 0.5, y + 0.5];
    // All rims lie below all lines: a bent line is one line.
    for (const layer of ['under', 'over']) {
      for (let i = 1; i < mark.line.length; ++i) {
        const [a, b] = [mark.line[i - 1]!, mark.line[i]!];
        const [x1, y1] = at(a);
        const [x2, y2] = at(b);
        group.append(svg('line', { 'class': `${layer}${a[2] && b[2] ? ' dim' : ''}`, x1, y1, x2, y2 }));
      }
    }
    for (const place of mark.points) {
      const [cx, cy] = at(place);
      const dim = place[2] ? ' dim' : '';
      group.append(svg('circle', { 'class': `under${dim}`, cx, cy, r: 7 * px }),
        svg('circle', { 'class': `over${dim}`, cx, cy, r: 7 * px }));
    }
    const last = mark.points.at(-1);
    if (last && mark.id !== '') {
      const [x, before] = at(last);
      const y = freeLine(labels, x, before, px);
      const words = mark.label === '' ? mark.id : `${mark.id}  ${mark.label}`;
      group.append(svg('text', { 'class': last[2] ? 'dim' : '', x: x + 12 * px, y: y + 5 * px }, words));
    }
    return group;
  }
}

/** The same sign in the list. */
export function badge(id: string): HTMLElement {
  return h('span', { class: 'finding-badge' }, id);
}
