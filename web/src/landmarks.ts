// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { LandmarkPair, Point3, SkinViewpoint } from './api';
import type { Point } from './geometry';

export interface CtPick {
  mm: Point3;
  /** Where it was tapped, to draw it while the view stays. */
  viewpoint: SkinViewpoint;
  pixel: Point;
}
export interface LivePick {
  mm: Point3;
  pixel: Point;
}
interface Landmark {
  ct?: CtPick;
  live?: LivePick;
}

/**
 * The landmarks while they are tapped: a point on the CT and the same point on the body, in either
 * order. At most one of them is half done.
 */
export class Landmarks {
  private list: Landmark[] = [];

  get all(): readonly Landmark[] {
    return this.list;
  }

  /** A new tap on the same side moves the point of the pair that is not finished. */
  addCt(ct: CtPick): void {
    this.unfinished().ct = ct;
  }

  addLive(live: LivePick): void {
    this.unfinished().live = live;
  }

  /** Takes back the last tapped pair, or the half of one. */
  undo(): void {
    this.list.pop();
  }

  clear(): void {
    this.list = [];
  }

  pairs(): LandmarkPair[] {
    return this.list.flatMap(({ ct, live }) =>
      ct && live ? [{ ct_mm: ct.mm, depth_mm: live.mm }] : [],
    );
  }

  /** What to do next, for the user. */
  advice(): string {
    const last = this.list[this.list.length - 1];
    const number = this.pairs().length + 1;
    if (last?.ct && !last.live) return `Tap point ${number} on the live picture too.`;
    if (last?.live && !last.ct) return `Tap point ${number} on the CT skin too.`;
    if (this.pairs().length < 3) {
      return `Tap point ${number} on the CT and on the live picture.`;
    }
    return 'Accept, or add points to be more exact.';
  }

  private unfinished(): Landmark {
    const last = this.list[this.list.length - 1];
    if (last && !(last.ct && last.live)) return last;
    const next: Landmark = {};
    this.list.push(next);
    return next;
  }
}

/** Eight colours that differ in brightness too; the number tells them apart without colour. */
const COLORS = ['#ffd23f', '#4cc9f0', '#ff7f6b', '#8ce99a', '#d9a6ff', '#ffa94d', '#a5d8ff', '#f8f9fa'];

export function landmarkColor(idx: number): string {
  return COLORS[idx % COLORS.length] as string;
}

/** Rotates the view of the CT by a drag: a drag over the full width turns it by half a turn. */
export function dragged(from: SkinViewpoint, dx_px: number, dy_px: number): SkinViewpoint {
  const limit = Math.PI / 2;
  return {
    ...from,
    yaw: wrapAngle(from.yaw - (dx_px / from.width) * Math.PI),
    pitch: Math.min(Math.max(from.pitch + (dy_px / from.height) * Math.PI, -limit), limit),
  };
}

export function wrapAngle(angle: number): number {
  const turn = 2 * Math.PI;
  return angle - turn * Math.round(angle / turn);
}
