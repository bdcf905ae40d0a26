// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/depth_correction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/range_camera.h"
#include "morgagni/geometry/depth_levels.h"

namespace mor {
namespace {

using Coefficients = DepthCorrection::Coefficients;

constexpr int kMaxGridSide = 64;
constexpr std::size_t kMaxKnots = 1024;
constexpr double kMaxDepthMm = std::numeric_limits<std::uint16_t>::max();
/// Corrections are millimetres to a few per cent; anything like this is no correction.
constexpr double kMaxShareOfDistance = 0.5;

/// Fractions that the rounding pattern advances by from pixel to pixel and from row to row, of
/// 2^32. Near 1/3 and 1/9, so that the nine steps of any 3x3 pixels are spread evenly; not quite,
/// so that pictures of every third pixel meet all steps too.
constexpr auto kPatternStepX = static_cast<std::uint32_t>((1.0 / 3.0 + 0.0145) * 4294967296.0);
constexpr auto kPatternStepY = static_cast<std::uint32_t>((1.0 / 9.0 + 0.0105) * 4294967296.0);

tl::unexpected<Error> bad(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, "depth correction: " + std::move(message));
}

/// Between which two control points a pixel lies, and how far from the first.
struct Place {
  std::size_t first = 0;
  std::size_t second = 0;
  double share = 0.0;
};

Place place_of(double pixel, int size_px, int num_points) {
  if (num_points < 2 || size_px < 2) return {};
  const double position = std::clamp(pixel, 0.0, size_px - 1.0) * (num_points - 1) / (size_px - 1);
  const auto first =
      std::min(static_cast<std::size_t>(position), static_cast<std::size_t>(num_points - 2));
  return {first, first + 1, position - static_cast<double>(first)};
}

Coefficients between(const Coefficients& a, const Coefficients& b, double share) {
  return {a.c0_mm + share * (b.c0_mm - a.c0_mm),
          a.c1 + share * (b.c1 - a.c1),
          a.c2_per_mm + share * (b.c2_per_mm - a.c2_per_mm)};
}

double polynomial_mm(const Coefficients& c, double z_mm) {
  return c.c0_mm + z_mm * (c.c1 + z_mm * c.c2_per_mm);
}

double curve_mm(const std::vector<DepthCorrection::Knot>& curve, double z_mm) {
  if (curve.empty()) return 0.0;
  if (z_mm <= curve.front().z_mm) return curve.front().add_mm;
  if (z_mm >= curve.back().z_mm) return curve.back().add_mm;
  const auto after = std::upper_bound(
      curve.begin(), curve.end(), z_mm, [](double z, const auto& knot) { return z < knot.z_mm; });
  const auto before = std::prev(after);
  return before->add_mm +
         (z_mm - before->z_mm) / (after->z_mm - before->z_mm) * (after->add_mm - before->add_mm);
}

Result<void> check_curve(const std::vector<DepthCorrection::Knot>& curve) {
  if (curve.size() > kMaxKnots) {
    return bad(
        fmt::format("its curve has {} knots, at most {} are allowed", curve.size(), kMaxKnots));
  }
  for (std::size_t i = 0; i < curve.size(); ++i) {
    if (!std::isfinite(curve[i].z_mm) || !std::isfinite(curve[i].add_mm)) {
      return bad(fmt::format("knot {} of its curve is not finite", i));
    }
    if (i > 0 && !(curve[i].z_mm > curve[i - 1].z_mm)) {
      return bad(fmt::format("knot {} of its curve, at {} mm, does not come after {} mm",
                             i,
                             curve[i].z_mm,
                             curve[i - 1].z_mm));
    }
  }
  return {};
}

/// The control points of one row of pixels.
std::vector<Coefficients> row_points(const DepthCorrection& correction, int y, int height_px) {
  const auto columns = static_cast<std::size_t>(correction.columns);
  const Place place = place_of(y, height_px, correction.rows);
  std::vector<Coefficients> points(columns);
  for (std::size_t i = 0; i < columns; ++i) {
    points[i] = between(correction.control[place.first * columns + i],
                        correction.control[place.second * columns + i],
                        place.share);
  }
  return points;
}

}  // namespace

Result<void> DepthCorrection::check() const {
  for (const int side : {columns, rows}) {
    if (side < 1 || side > kMaxGridSide) {
      return bad(fmt::format(
          "its grid must have 1..{} columns and rows, got {} x {}", kMaxGridSide, columns, rows));
    }
  }
  if (control.size() != static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)) {
    return bad(fmt::format(
        "a grid of {} x {} needs as many control points, got {}", columns, rows, control.size()));
  }
  if (!(near_mm >= 1.0 && near_mm < far_mm && far_mm <= kMaxDepthMm)) {
    return bad(
        fmt::format("it must hold from near_mm >= 1 to a greater far_mm <= 65535, got {} and {}",
                    near_mm,
                    far_mm));
  }
  MOR_CHECK(check_curve(curve));
  for (std::size_t i = 0; i < control.size(); ++i) {
    for (const double z_mm : {near_mm, 0.5 * (near_mm + far_mm), far_mm}) {
      const double amount_mm = polynomial_mm(control[i], z_mm) + curve_mm(curve, z_mm);
      if (std::abs(amount_mm) <= kMaxShareOfDistance * z_mm) continue;
      return bad(fmt::format(
          "control point {} adds {} mm to {} mm, at most half is allowed", i, amount_mm, z_mm));
    }
  }
  return {};
}

double DepthCorrection::add_mm(const Eigen::Vector2d& pixel,
                               int width_px,
                               int height_px,
                               double z_mm) const {
  const Place x = place_of(pixel.x(), width_px, columns);
  const Place y = place_of(pixel.y(), height_px, rows);
  const auto at = [this](std::size_t column, std::size_t row) {
    return control[row * static_cast<std::size_t>(columns) + column];
  };
  const Coefficients above = between(at(x.first, y.first), at(x.second, y.first), x.share);
  const Coefficients below = between(at(x.first, y.second), at(x.second, y.second), x.share);
  const double held_mm = std::clamp(z_mm, near_mm, far_mm);
  return polynomial_mm(between(above, below, y.share), held_mm) + curve_mm(curve, held_mm);
}

Image<std::uint16_t> DepthCorrection::apply(ImageView<const std::uint16_t> depth_mm) const {
  return apply(depth_mm, DepthLevels());
}

Image<std::uint16_t> DepthCorrection::apply(ImageView<const std::uint16_t> depth_mm,
                                            const DepthLevels& levels) const {
  const int width = depth_mm.width();
  const int height = depth_mm.height();
  Image<std::uint16_t> corrected(width, height);
  std::vector<Place> places;
  for (int x = 0; x < width; ++x) places.push_back(place_of(x, width, columns));
  std::vector<float> curve_at;  // By reading, so far as the correction reaches.
  if (!curve.empty()) {
    for (int z = 0; z <= static_cast<int>(far_mm) + 1; ++z) {
      curve_at.push_back(
          static_cast<float>(curve_mm(curve, std::clamp<double>(z, near_mm, far_mm))));
    }
  }
  for (int y = 0; y < height; ++y) {
    const auto points = row_points(*this, y, height);
    const std::uint16_t* from = depth_mm.row(y);
    std::uint16_t* to = corrected.view().row(y);
    auto pattern = static_cast<std::uint32_t>(y) * kPatternStepY;
    for (int x = 0; x < width; ++x, pattern += kPatternStepX) {
      if (from[x] == 0) continue;
      const auto z_mm = static_cast<double>(levels.mm(from[x]));
      const Place& place = places[static_cast<std::size_t>(x)];
      double sum_mm =
          z_mm + polynomial_mm(between(points[place.first], points[place.second], place.share),
                               std::clamp(z_mm, near_mm, far_mm));
      if (!curve_at.empty()) {
        sum_mm +=
            static_cast<double>(curve_at[std::min<std::size_t>(from[x], curve_at.size() - 1)]);
      }
      const double step = (static_cast<double>(pattern) + 0.5) / 4294967296.0;
      to[x] = static_cast<std::uint16_t>(std::clamp(std::floor(sum_mm + step), 1.0, kMaxDepthMm));
    }
  }
  return corrected;
}

std::shared_ptr<const RgbdFrame> depth_corrected(std::shared_ptr<const RgbdFrame> frame,
                                                 DepthLevels& levels) {
  if (frame->as_sensed || !frame->calibration || !frame->calibration->depth_correction) {
    return frame;
  }
  levels.learn(frame->depth_mm.view());
  auto corrected = std::make_shared<RgbdFrame>();
  corrected->frame_id = frame->frame_id;
  corrected->captured_at = frame->captured_at;
  corrected->depth_mm = frame->calibration->depth_correction->apply(frame->depth_mm.view(), levels);
  corrected->color = frame->color;
  corrected->calibration = frame->calibration;
  corrected->device_time = frame->device_time;
  corrected->as_sensed = std::move(frame);
  return corrected;
}

std::shared_ptr<const RgbdFrame> with_calibration(
    const RgbdFrame& frame, std::shared_ptr<const RgbdCalibration> calibration) {
  auto same = std::make_shared<RgbdFrame>(as_sensed(frame));
  same->calibration = std::move(calibration);
  return same;
}

const RgbdFrame& as_sensed(const RgbdFrame& frame) {
  return frame.as_sensed ? *frame.as_sensed : frame;
}

}  // namespace mor
