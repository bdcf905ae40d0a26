// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace mor::internal {

struct SvgPoint {
  double x;
  double y;
};

/// A picture of lines, dots and words. Units: px, y down.
class Svg {
 public:
  Svg(double width, double height);

  void line(SvgPoint from, SvgPoint to, std::string_view color, double width = 1.0);
  /// @param dash  As `stroke-dasharray`; empty: whole.
  void polyline(const std::vector<SvgPoint>& points,
                std::string_view color,
                double width,
                std::string_view dash = "");
  /// @param filled  Else a ring.
  void dot(SvgPoint at, double radius, std::string_view color, bool filled);
  void rectangle(SvgPoint corner, double width, double height, std::string_view color);
  /// @param anchor  start | middle | end. Escapes what XML reserves.
  void text(SvgPoint at,
            std::string_view words,
            std::string_view anchor = "start",
            double size = 12.0,
            bool bold = false);
  /// Read from the bottom up, its middle at `at`.
  void upright_text(SvgPoint at, std::string_view words, double size = 12.0);

  [[nodiscard]] std::string finish() const;

 private:
  double width_;
  double height_;
  std::string body_;
};

/// Numbers along one side of a panel, even or logarithmic, to pixels.
class SvgAxis {
 public:
  /// @param least, most  With a logarithmic axis > 0.
  SvgAxis(double least, double most, double from_px, double to_px, bool is_logarithmic);

  /// Clamped to the axis.
  [[nodiscard]] double px(double value) const;
  /// Values worth a line: whole steps of 1, 2 or 5, or powers of ten with 2 and 5 between.
  [[nodiscard]] std::vector<double> ticks() const;

 private:
  double least_;
  double most_;
  double from_px_;
  double to_px_;
  bool is_logarithmic_;
};

}  // namespace mor::internal
