// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include <Eigen/Core>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"

namespace mor::internal {

/// Lengths on paper are points: 1/72 inch, from the upper left corner.
struct PdfBox {
  double x = 0.0;
  double y = 0.0;
  double width = 0.0;
  double height = 0.0;
};

enum class PdfStyle { kTitle, kSubtitle, kHeading, kStrong, kBody, kSmall, kMono, kTiny };

struct PdfHead {
  std::string title;       ///< Of the document.
  std::string author;      ///< May be empty.
  std::string created_at;  ///< ISO 8601.
  std::string running;     ///< Line at the head of each page but the first.
  std::string foot;        ///< Line at the foot of each page, beside its number.
};

/// Writes text, pictures and lines down A4 pages; a new page begins when one is full.
class PdfWriter {
 public:
  static constexpr double kLeft = 62.0;
  static constexpr double kWidth = 595.28 - 2.0 * kLeft;
  static constexpr double kTop = 74.0;
  static constexpr double kBottom = 841.89 - 70.0;

  /// @param num_pages  As counted in a run before; 0: unknown, the count is left out.
  PdfWriter(PdfHead head, int num_pages);
  ~PdfWriter();
  PdfWriter(const PdfWriter&) = delete;
  PdfWriter& operator=(const PdfWriter&) = delete;

  [[nodiscard]] int num_pages() const;
  [[nodiscard]] double y() const;
  void set_y(double y);
  void skip(double height);
  void new_page();
  void keep_together(double height);  ///< A new page if less than that is left on this one.

  void heading(const std::string& text);  ///< Also in the outline.
  void text(const std::string& text, PdfStyle style, double left = kLeft, double width = kWidth);
  /// A name and its value in two columns.
  void fact(const std::string& name, const std::string& value, PdfStyle style = PdfStyle::kBody);
  void rule();

  /// Text at a place of its own, which does not move y(). @return Its size.
  Eigen::Vector2d label(const std::string& text,
                        PdfStyle style,
                        double x,
                        double y,
                        double align = 0.0,
                        const Eigen::Vector3d& color = {0.1, 0.12, 0.14});
  void image(const Image<Rgb8>& picture, const PdfBox& box);
  void line(double x0, double y0, double x1, double y1, double width, double gray = 0.1);
  void dashed_line(double x0, double y0, double x1, double y1);
  void frame(const PdfBox& box);
  void disc(double x, double y, double radius, const Eigen::Vector3d& color);

  /// @errors kInternal: cairo's words.
  [[nodiscard]] Result<std::string> finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mor::internal
