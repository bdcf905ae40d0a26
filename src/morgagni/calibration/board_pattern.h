// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "morgagni/calibration/board.h"
#include "morgagni/camera/simulated_board_camera.h"
#include "morgagni/core/result.h"

namespace mor {

/// A black rectangle of a board, frame board, mm.
struct BlackRectangle {
  double left_mm = 0.0;
  double top_mm = 0.0;
  double right_mm = 0.0;
  double bottom_mm = 0.0;
};

/// All that is black on a board: squares, and the markers' cells in the white ones. None overlaps
/// another. @pre board.check().
[[nodiscard]] std::vector<BlackRectangle> black_rectangles(const CalibrationBoard& board);

/// White around the outer squares that a finder needs, at least: half a square.
[[nodiscard]] double margin_mm(const CalibrationBoard& board);

/// The board as it lies printed, for the simulation.
[[nodiscard]] BoardPicture board_picture(const CalibrationBoard& board, double mm_per_px = 0.25);

/// Writes the board as a PDF at its true size: vector graphics on the smallest of A4, A3, A2, A1 it
/// fits on, or a sheet of its own, with two rulers of 100 mm to check the print with.
/// @errors kInvalidArgument: a bad board; kIo.
[[nodiscard]] Result<void> write_board_pdf(const CalibrationBoard& board,
                                           const std::filesystem::path& path);

}  // namespace mor
