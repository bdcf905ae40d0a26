// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/corrected_calibration.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <numeric>
#include <utility>

#include <spdlog/fmt/fmt.h>

namespace mor {
namespace {

using Coefficients = DepthCorrection::Coefficients;

/// A grid on whose control points those of both lie, as far as a correction may have so many.
int common_side(int a, int b) {
  constexpr int kMostSide = 64;
  if (a == 1 || b == 1) return std::max(a, b);
  const int intervals = std::lcm(a - 1, b - 1);
  return intervals < kMostSide ? intervals + 1 : kMostSide;
}

/// The coefficients at a share of the picture's width and height.
Coefficients at(const DepthCorrection& correction, double share_x, double share_y) {
  const auto place = [](double share, int count) {
    const double position = share * (count - 1);
    const int cell = std::clamp(static_cast<int>(position), 0, std::max(0, count - 2));
    return std::pair{cell, position - cell};
  };
  const auto [x, in_x] = place(share_x, correction.columns);
  const auto [y, in_y] = place(share_y, correction.rows);
  Coefficients sum;
  for (int corner = 0; corner < 4; ++corner) {
    const int dx = corner & 1;
    const int dy = corner >> 1;
    const double weight = (dx == 1 ? in_x : 1.0 - in_x) * (dy == 1 ? in_y : 1.0 - in_y);
    if (weight == 0.0) continue;
    const auto& point =
        correction.control[static_cast<std::size_t>((y + dy) * correction.columns + x + dx)];
    sum.c0_mm += weight * point.c0_mm;
    sum.c1 += weight * point.c1;
    sum.c2_per_mm += weight * point.c2_per_mm;
  }
  return sum;
}

/// b after a: z' = z + a(z), z'' = z' + b(z'), up to the second power of z. What b's square makes
/// of a's millimetres beside their sum is below a hundredth of a millimetre.
Coefficients after(const Coefficients& a, const Coefficients& b) {
  const double slope = 1.0 + a.c1;
  return {a.c0_mm + b.c0_mm + a.c0_mm * (b.c1 + b.c2_per_mm * a.c0_mm),
          a.c1 + b.c1 * slope + 2.0 * b.c2_per_mm * a.c0_mm * slope,
          a.c2_per_mm * (1.0 + b.c1) + b.c2_per_mm * slope * slope};
}

}  // namespace

Result<DepthCorrection> corrected_after(const DepthCorrection& first,
                                        const DepthCorrection& second) {
  MOR_CHECK(first.check());
  MOR_CHECK(second.check());
  if (!second.curve.empty()) {
    return make_error(ErrorCode::kInvalidArgument,
                      "a correction with a curve over the distance cannot come after another");
  }
  DepthCorrection both;
  both.columns = common_side(first.columns, second.columns);
  both.rows = common_side(first.rows, second.rows);
  both.near_mm = std::max(first.near_mm, second.near_mm);
  both.far_mm = std::min(first.far_mm, second.far_mm);
  if (!(both.near_mm < both.far_mm)) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("the correction in use holds from {:.0f} to {:.0f} mm, the new one was found "
                    "from {:.0f} to {:.0f} mm: they share no distances",
                    first.near_mm,
                    first.far_mm,
                    second.near_mm,
                    second.far_mm));
  }
  both.control.clear();
  for (int row = 0; row < both.rows; ++row) {
    for (int column = 0; column < both.columns; ++column) {
      const double x = both.columns > 1 ? static_cast<double>(column) / (both.columns - 1) : 0.5;
      const double y = both.rows > 1 ? static_cast<double>(row) / (both.rows - 1) : 0.5;
      both.control.push_back(after(at(first, x, y), at(second, x, y)));
    }
  }
  both.curve = first.curve;
  MOR_CHECK(both.check());
  return both;
}

Result<RgbdCalibration> without_error(const RgbdCalibration& in_use, const SelfCalibration& found) {
  RgbdCalibration corrected = in_use;
  corrected.depth = found.depth;
  DepthCorrection correction = found.correction;
  if (in_use.depth_correction) {
    MOR_TRY(correction, corrected_after(*in_use.depth_correction, found.correction));
  }
  corrected.depth_correction = std::make_shared<const DepthCorrection>(std::move(correction));
  return corrected;
}

}  // namespace mor
