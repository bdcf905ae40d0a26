// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// 24x24 line drawings, so that a button is understood before its word is read.
const DRAWINGS = {
  placement:
    'M4 8V5a1 1 0 0 1 1-1h3M16 4h3a1 1 0 0 1 1 1v3M20 16v3a1 1 0 0 1-1 1h-3M8 20H5a1 1 0 0 1-1-1v-3M12 7.5a2 2 0 1 0 0 4 2 2 0 0 0 0-4M8 17c0-2.5 1.8-4 4-4s4 1.5 4 4',
  landmarks:
    'M6 4.5a1.8 1.8 0 1 0 0 3.6 1.8 1.8 0 0 0 0-3.6M18 9a1.8 1.8 0 1 0 0 3.6A1.8 1.8 0 0 0 18 9M9 16a1.8 1.8 0 1 0 0 3.6A1.8 1.8 0 0 0 9 16M7.7 7l8.6 3M16.7 12l-6.2 4.6M8.6 16 6.4 8',
  freeze: 'M9 6v12M15 6v12',
  resume: 'M8 5.5v13l10.5-6.5z',
  snapshot:
    'M4 8h3l1.5-2.5h7L17 8h3v11H4zM12 10.2a3.1 3.1 0 1 0 0 6.2 3.1 3.1 0 0 0 0-6.2',
  record: 'M12 5a7 7 0 1 0 0 14 7 7 0 0 0 0-14M12 9.5a2.5 2.5 0 1 0 0 5 2.5 2.5 0 0 0 0-5',
  undo: 'M9 6 4.5 10.5 9 15M5 10.5h9a5 5 0 0 1 0 10h-3',
  turnLeft: 'M5 4.5v5h5M5.6 9.3A7.5 7.5 0 1 1 4.6 14',
  turnRight: 'M19 4.5v5h-5M18.4 9.3A7.5 7.5 0 1 0 19.4 14',
  accept: 'M5 12.5 10 17.5 19.5 7',
  cancel: 'M6 6l12 12M18 6 6 18',
  plus: 'M12 5v14M5 12h14',
  minus: 'M5 12h14',
  tracking: 'M5 12.5 10 17.5 19.5 7',
  waiting: 'M12 4.5a7.5 7.5 0 1 0 0 15 7.5 7.5 0 0 0 0-15M12 8v4.5l3 2',
  uncertain: 'M12 4.5 21 19.5H3zM12 10v4M12 16.6v.2',
  automatic:
    'M4 8V5a1 1 0 0 1 1-1h3M16 4h3a1 1 0 0 1 1 1v3M20 16v3a1 1 0 0 1-1 1h-3M8 20H5a1 1 0 0 1-1-1v-3M11 8a3.5 3.5 0 1 0 0 7 3.5 3.5 0 0 0 0-7M13.6 14.1 17 17.5',
  unknown: 'M7 8.5A7 7 0 0 1 17 8.5M9.5 12a3.5 3.5 0 0 1 5 0M12 16v.2M4.5 19.5 19.5 4.5',
  lost: 'M6 6l12 12M18 6 6 18',
  look: 'M2.5 12S6 5.5 12 5.5 21.5 12 21.5 12 18 18.5 12 18.5 2.5 12 2.5 12M12 9a3 3 0 1 0 0 6 3 3 0 0 0 0-6',
  surface: 'M12 3.5 20 8v8l-8 4.5L4 16V8zM4 8l8 4.5L20 8M12 12.5v8',
  findings: 'M12 21s6.5-6 6.5-11a6.5 6.5 0 0 0-13 0c0 5 6.5 11 6.5 11M12 7.5a2.5 2.5 0 1 0 0 5 2.5 2.5 0 0 0 0-5',
  point: 'M12 3.5v5M12 15.5v5M3.5 12h5M15.5 12h5M12 11.5v1',
  distance: 'M4 17 17 4l3 3L7 20zM8 13l2 2M11 10l2 2M14 7l2 2',
  geodesic: 'M4.5 18a1.5 1.5 0 1 0 0 .1M6 17.5C9 8 15 6 18 9.5M19.5 11a1.5 1.5 0 1 0 0 .1',
  edit: 'M5 19l1-4L16 5l3 3L9 18zM14 7l3 3',
  remove: 'M5 7h14M10 7V4.5h4V7M7 7l1 12.5h8L17 7M10.5 10.5v6M13.5 10.5v6',
  stop: 'M7 7h10v10H7z',
  sensor: 'M3.5 8.5h17v7h-17zM8 12a1.7 1.7 0 1 0 0 .1M15 12a1.7 1.7 0 1 0 0 .1M9 19h6M12 15.5V19',
  takeAway: 'M12 4v11M7 10.5l5 5 5-5M4.5 19.5h15',
} as const;

export type IconName = keyof typeof DRAWINGS;

export function icon(name: IconName): SVGSVGElement {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  svg.setAttribute('viewBox', '0 0 24 24');
  svg.setAttribute('class', 'icon');
  svg.setAttribute('aria-hidden', 'true');
  const path = document.createElementNS('http://www.w3.org/2000/svg', 'path');
  path.setAttribute('d', DRAWINGS[name]);
  svg.append(path);
  return svg;
}
