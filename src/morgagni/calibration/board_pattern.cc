// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/board_pattern.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>

#include <cairo-pdf.h>
#include <cairo.h>
#include <opencv2/core.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/calibration/internal/charuco.h"
#include "morgagni/core/files.h"

namespace mor {
namespace {

constexpr double kPointsPerMm = 72.0 / 25.4;
constexpr double kRulerMm = 100.0;
/// Below the board: the ruler and two lines of text.
constexpr double kFootMm = 22.0;
/// Left of it: the upright ruler.
constexpr double kSideMm = 14.0;
/// What printers leave white.
constexpr double kEdgeMm = 5.0;

/// The black cells of one marker, as runs along its rows.
void add_marker(const cv::Mat& cells,
                const Eigen::Vector2d& corner_mm,
                double cell_mm,
                std::vector<BlackRectangle>& black) {
  for (int y = 0; y < cells.rows; ++y) {
    for (int x = 0; x < cells.cols;) {
      const int begin = x;
      while (x < cells.cols && cells.at<std::uint8_t>(y, x) == 0) ++x;
      if (x > begin) {
        black.push_back({corner_mm.x() + begin * cell_mm,
                         corner_mm.y() + y * cell_mm,
                         corner_mm.x() + x * cell_mm,
                         corner_mm.y() + (y + 1) * cell_mm});
      }
      ++x;
    }
  }
}

struct Sheet {
  std::string name;
  double width_mm = 0.0;
  double height_mm = 0.0;
};

Sheet sheet_for(double width_mm, double height_mm) {
  for (const Sheet& sheet : {Sheet{"A4", 297.0, 210.0},
                             Sheet{"A3", 420.0, 297.0},
                             Sheet{"A2", 594.0, 420.0},
                             Sheet{"A1", 841.0, 594.0}}) {
    if (width_mm <= sheet.width_mm && height_mm <= sheet.height_mm) {
      return {sheet.name + " landscape", sheet.width_mm, sheet.height_mm};
    }
    if (width_mm <= sheet.height_mm && height_mm <= sheet.width_mm) {
      return {sheet.name + " portrait", sheet.height_mm, sheet.width_mm};
    }
  }
  return {"its own size", width_mm, height_mm};
}

/// Along x from the current origin, ticks every 10 mm.
void draw_ruler(cairo_t* cairo) {
  cairo_set_line_width(cairo, 0.25);
  for (int mm = 0; mm <= static_cast<int>(kRulerMm); mm += 5) {
    cairo_move_to(cairo, mm, 0.0);
    cairo_line_to(cairo, mm, mm % 50 == 0 ? 5.0 : mm % 10 == 0 ? 3.5 : 2.0);
  }
  cairo_move_to(cairo, 0.0, 0.0);
  cairo_line_to(cairo, kRulerMm, 0.0);
  cairo_stroke(cairo);
  cairo_move_to(cairo, 36.0, 6.5);
  cairo_show_text(cairo, "100 mm when printed right");
}

void draw_words(cairo_t* cairo, const CalibrationBoard& board, const Sheet& sheet, double x_mm) {
  cairo_move_to(cairo, x_mm, 2.5);
  cairo_show_text(cairo, fmt::format("Morgagni calibration board {}", to_string(board)).c_str());
  cairo_move_to(cairo, x_mm, 6.5);
  cairo_show_text(
      cairo,
      fmt::format("Print on {} at 100 % (no \"fit to page\"), measure both rulers,", sheet.name)
          .c_str());
  cairo_move_to(cairo, x_mm, 10.5);
  cairo_show_text(cairo, "and glue it flat onto a stiff plate: glass, aluminium, not cardboard.");
}

cairo_status_t append(void* text, const unsigned char* data, unsigned int size) {
  static_cast<std::string*>(text)->append(reinterpret_cast<const char*>(data), size);
  return CAIRO_STATUS_SUCCESS;
}

void draw_board(cairo_t* cairo, const CalibrationBoard& board) {
  // One path: where two rectangles touch, no hair of white shows between them.
  for (const auto& r : black_rectangles(board)) {
    cairo_rectangle(cairo, r.left_mm, r.top_mm, r.right_mm - r.left_mm, r.bottom_mm - r.top_mm);
  }
  cairo_fill(cairo);
}

void draw_sheet(cairo_t* cairo, const CalibrationBoard& board, const Sheet& sheet) {
  const double width_mm = board.columns * board.square_mm;
  const double height_mm = board.rows * board.square_mm;
  cairo_scale(cairo, kPointsPerMm, kPointsPerMm);
  cairo_select_font_face(cairo, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo, 2.8);
  const double left_mm = 0.5 * (sheet.width_mm - width_mm - kSideMm) + kSideMm;
  const double top_mm = 0.5 * (sheet.height_mm - height_mm - kFootMm);
  cairo_save(cairo);
  cairo_translate(cairo, left_mm + board.square_mm, top_mm + board.square_mm);
  draw_board(cairo, board);
  cairo_restore(cairo);
  cairo_save(cairo);
  cairo_translate(cairo, left_mm, top_mm + height_mm + margin_mm(board));
  draw_ruler(cairo);
  draw_words(cairo, board, sheet, kRulerMm + 8.0);
  cairo_restore(cairo);
  cairo_save(cairo);
  cairo_translate(cairo, left_mm - margin_mm(board), top_mm);
  cairo_rotate(cairo, std::acos(0.0));
  draw_ruler(cairo);
  cairo_restore(cairo);
}

}  // namespace

double margin_mm(const CalibrationBoard& board) {
  return std::clamp(0.5 * board.square_mm, 3.0, 9.0);
}

std::vector<BlackRectangle> black_rectangles(const CalibrationBoard& board) {
  std::vector<BlackRectangle> black;
  const double side_mm = board.square_mm;
  int next_marker = 0;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      const Eigen::Vector2d corner_mm((column - 1) * side_mm, (row - 1) * side_mm);
      if (board.is_black(column, row)) {
        black.push_back(
            {corner_mm.x(), corner_mm.y(), corner_mm.x() + side_mm, corner_mm.y() + side_mm});
      } else if (board.kind == BoardKind::kCharuco) {
        const cv::Mat cells = internal::marker_cells(next_marker++);
        const double inset_mm = 0.5 * (side_mm - board.marker_mm);
        add_marker(cells,
                   corner_mm + Eigen::Vector2d::Constant(inset_mm),
                   board.marker_mm / cells.cols,
                   black);
      }
    }
  }
  return black;
}

BoardPicture board_picture(const CalibrationBoard& board, double mm_per_px) {
  const double rim_mm = board.square_mm + margin_mm(board);
  BoardPicture picture;
  picture.mm_per_px = mm_per_px;
  picture.first_px_mm = Eigen::Vector2d::Constant(0.5 * mm_per_px - rim_mm);
  const auto pixels = [&](int squares) {
    return static_cast<int>(
        std::lround((squares * board.square_mm + 2.0 * margin_mm(board)) / mm_per_px));
  };
  picture.brightness = Image<std::uint8_t>(pixels(board.columns), pixels(board.rows), 240);
  const auto first_inside = [&](double mm) {
    return std::max(0, static_cast<int>(std::ceil((mm + rim_mm) / mm_per_px - 0.5)));
  };
  for (const auto& r : black_rectangles(board)) {
    const int right = std::min(first_inside(r.right_mm), picture.brightness.width());
    const int bottom = std::min(first_inside(r.bottom_mm), picture.brightness.height());
    for (int y = first_inside(r.top_mm); y < bottom; ++y) {
      for (int x = first_inside(r.left_mm); x < right; ++x) picture.brightness(x, y) = 12;
    }
  }
  return picture;
}

Result<void> write_board_pdf(const CalibrationBoard& board, const std::filesystem::path& path) {
  MOR_CHECK(board.check());
  const double around_mm = margin_mm(board) + kEdgeMm;
  const Sheet sheet = sheet_for(board.columns * board.square_mm + kSideMm + 2.0 * kEdgeMm,
                                board.rows * board.square_mm + kFootMm + around_mm);
  std::string pdf;
  const std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface(
      cairo_pdf_surface_create_for_stream(
          append, &pdf, sheet.width_mm * kPointsPerMm, sheet.height_mm * kPointsPerMm),
      cairo_surface_destroy);
  {
    const std::unique_ptr<cairo_t, decltype(&cairo_destroy)> cairo(cairo_create(surface.get()),
                                                                   cairo_destroy);
    draw_sheet(cairo.get(), board, sheet);
    cairo_show_page(cairo.get());
  }
  cairo_surface_finish(surface.get());
  if (const auto status = cairo_surface_status(surface.get()); status != CAIRO_STATUS_SUCCESS) {
    return make_error(ErrorCode::kInternal,
                      fmt::format("the board cannot be drawn: {}", cairo_status_to_string(status)));
  }
  return write_file(path, pdf);
}

}  // namespace mor
