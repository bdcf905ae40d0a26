// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

export interface Counts {
  views: number;
  /** In the hand. */
  wanted_views: number;
  views_on_wall: number;
  wanted_on_wall: number;
}

/** "20 of 24 views in the hand, 3 of 10 on the wall" */
export function countOf({ views, wanted_views, views_on_wall, wanted_on_wall }: Counts): string {
  const inHand = `${views - views_on_wall} of ${wanted_views} views in the hand`;
  return wanted_on_wall > 0 ? `${inHand}, ${views_on_wall} of ${wanted_on_wall} on the wall` : inHand;
}

/** How much of what is wanted has been taken, 0 to 1: more in the hand is not less on the wall. */
export function shareOf({ views, wanted_views, views_on_wall, wanted_on_wall }: Counts): number {
  const taken = Math.min(views - views_on_wall, wanted_views) + Math.min(views_on_wall, wanted_on_wall);
  return taken / (wanted_views + wanted_on_wall);
}
