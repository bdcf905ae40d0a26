// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/board.h"

#include <charconv>
#include <cmath>

#include <spdlog/fmt/fmt.h>

namespace mor {
namespace {

constexpr int kMinSquares = 4;
constexpr int kMaxSquares = 40;
constexpr double kMinSquareMm = 2.0;
constexpr double kMaxSquareMm = 500.0;
/// A marker needs white around it.
constexpr double kMaxMarkerShare = 0.9;
constexpr double kMinMarkerShare = 0.3;
constexpr std::string_view kCharucoName = "charuco";
constexpr std::string_view kChessboardName = "chessboard";

tl::unexpected<Error> bad(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, "board: " + std::move(message));
}

/// The whole of `text` as a number.
template <class T>
Result<T> number(std::string_view text) {
  T value{};
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status == std::errc() && end == text.data() + text.size()) return value;
  return bad(fmt::format("'{}' is no number", text));
}

std::vector<std::string_view> parts(std::string_view text, char separator) {
  std::vector<std::string_view> result;
  for (;;) {
    const auto end = text.find(separator);
    result.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return result;
    text.remove_prefix(end + 1);
  }
}

}  // namespace

Result<void> CalibrationBoard::check() const {
  for (const int count : {columns, rows}) {
    if (count < kMinSquares || count > kMaxSquares) {
      return bad(fmt::format("it must have {}..{} squares along each side, got {} x {}",
                             kMinSquares,
                             kMaxSquares,
                             columns,
                             rows));
    }
  }
  if ((columns + rows) % 2 == 0) {
    return bad(
        fmt::format("of {} x {} squares one number must be odd and the other even, else it "
                    "looks the same upside down",
                    columns,
                    rows));
  }
  if (!(square_mm >= kMinSquareMm && square_mm <= kMaxSquareMm)) {
    return bad(fmt::format(
        "a square must be {}..{} mm wide, got {}", kMinSquareMm, kMaxSquareMm, square_mm));
  }
  if (kind == BoardKind::kCharuco &&
      !(marker_mm >= kMinMarkerShare * square_mm && marker_mm <= kMaxMarkerShare * square_mm)) {
    return bad(fmt::format("a marker must be {}..{} of a square's {} mm wide, got {}",
                           kMinMarkerShare,
                           kMaxMarkerShare,
                           square_mm,
                           marker_mm));
  }
  return {};
}

Eigen::Vector3d CalibrationBoard::corner_mm(int i) const {
  return {square_mm * (i % corner_columns()), square_mm * (i / corner_columns()), 0.0};
}

Result<CalibrationBoard> parse_board(std::string_view text) {
  const auto fields = parts(text, ':');
  CalibrationBoard board;
  if (fields[0] == kCharucoName && fields.size() == 4) {
    board.kind = BoardKind::kCharuco;
    MOR_TRY(board.marker_mm, number<double>(fields[3]));
  } else if (fields[0] == kChessboardName && fields.size() == 3) {
    board.kind = BoardKind::kChessboard;
  } else {
    return bad(
        fmt::format("'{}' must be charuco:COLUMNSxROWS:SQUARE_MM:MARKER_MM or "
                    "chessboard:COLUMNSxROWS:SQUARE_MM",
                    text));
  }
  const auto sides = parts(fields[1], 'x');
  if (sides.size() != 2) {
    return bad(fmt::format("'{}' must be COLUMNSxROWS, counted in squares", fields[1]));
  }
  MOR_TRY(board.columns, number<int>(sides[0]));
  MOR_TRY(board.rows, number<int>(sides[1]));
  MOR_TRY(board.square_mm, number<double>(fields[2]));
  MOR_CHECK(board.check());
  return board;
}

std::string to_string(const CalibrationBoard& board) {
  if (board.kind == BoardKind::kChessboard) {
    return fmt::format("{}:{}x{}:{}", kChessboardName, board.columns, board.rows, board.square_mm);
  }
  return fmt::format(
      "{}:{}x{}:{}:{}", kCharucoName, board.columns, board.rows, board.square_mm, board.marker_mm);
}

}  // namespace mor
