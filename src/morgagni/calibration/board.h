// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "morgagni/core/result.h"

namespace mor {

enum class BoardKind : std::uint8_t {
  kChessboard,  ///< Must be seen whole.
  kCharuco,     ///< A chessboard with numbered markers in its white squares: parts of it will do.
};

/// A flat calibration board. Frame board: origin at the upper left inner corner, x along the
/// columns, y along the rows, z into the board, mm.
struct CalibrationBoard {
  BoardKind kind = BoardKind::kCharuco;
  int columns = 10;         ///< Squares, 4..40. As here the board fits on A3.
  int rows = 7;             ///< Squares, 4..40; one of the two odd and the other even.
  double square_mm = 37.0;  ///< 2..500.
  double marker_mm = 24.0;  ///< Side of a ChArUco board's markers; under 0.9 of a square.

  bool operator==(const CalibrationBoard&) const = default;

  /// @errors kInvalidArgument: names the value and its limits.
  [[nodiscard]] Result<void> check() const;

  /// Inner corners, where four squares meet.
  [[nodiscard]] int corner_columns() const { return columns - 1; }
  [[nodiscard]] int corner_rows() const { return rows - 1; }
  [[nodiscard]] int num_corners() const { return corner_columns() * corner_rows(); }
  /// Of a square, counted from the upper left.
  [[nodiscard]] bool is_black(int column, int row) const {
    return (rows - 1 - row + column) % 2 == 0;
  }
  /// Where corner i lies, counted row by row.
  [[nodiscard]] Eigen::Vector3d corner_mm(int i) const;
};

/// Reads "charuco:11x8:24:18" (squares, their side, the markers' side, mm) or "chessboard:11x8:24".
/// @errors kInvalidArgument: says what is wrong with it.
[[nodiscard]] Result<CalibrationBoard> parse_board(std::string_view text);

/// As parse_board() reads it.
[[nodiscard]] std::string to_string(const CalibrationBoard& board);

}  // namespace mor
