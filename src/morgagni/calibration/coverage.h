// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "morgagni/calibration/board.h"
#include "morgagni/calibration/board_finder.h"
#include "morgagni/geometry/pinhole_camera.h"

namespace mor {

/// Where a board is held, as far as a picture and the design's lens tell.
struct BoardPlace {
  double distance_mm = 0.0;
  double right_nearer_deg = 0.0;  ///< Tilt: its right edge is nearer than its left one; negative:
                                  ///< farther.
  double low_nearer_deg = 0.0;    ///< The same of its lower edge.
};

[[nodiscard]] std::optional<BoardPlace> place_of(const CalibrationBoard& board,
                                                 const BoardSighting& sighting,
                                                 const PinholeCamera& camera);

/// What a set of views has, and what it lacks.
struct Coverage {
  static constexpr int kColumns = 3;
  static constexpr int kRows = 3;
  std::array<int, kColumns * kRows> views_in_part{};  ///< Of the picture, row by row.
  int num_views = 0;
  int num_on_wall = 0;               ///< Of the views.
  int num_distances = 0;             ///< More than 8 % apart.
  std::vector<std::string> missing;  ///< What to do next, the most needed first; empty: enough.
};

/// How many views are asked for.
struct WantedViews {
  int in_hand = 24;
  /// Of the board on a wall or a wide table, near and far: the depth's error over the whole picture
  /// is found there. 0: none, the depth is not corrected.
  int on_wall = 0;
};

/// @param on_wall  Whether a view is one, in the order of `views`.
/// @param camera  The design's lens.
/// @pre views.size() == on_wall.size()
[[nodiscard]] Coverage coverage_of(const CalibrationBoard& board,
                                   const std::vector<BoardSighting>& views,
                                   const std::vector<bool>& on_wall,
                                   const PinholeCamera& camera,
                                   const WantedViews& wanted);

}  // namespace mor
