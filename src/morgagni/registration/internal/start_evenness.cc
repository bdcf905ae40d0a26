// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_evenness.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>

namespace mor::internal {
namespace {

constexpr int kSide = 4;          ///< Of a patch, in pixels.
constexpr int kLeastPixels = 10;  ///< Of its 16.
constexpr double kPatchNoiseMm = 0.5;
constexpr double kSensorErrorMm = 3.0;  ///< Each of the slow error's coefficients, before a look.
constexpr double kFreedom = 3.0;        ///< What the slow error takes from the sum of squares.

using Slow = Eigen::Matrix<double, 6, 1>;

struct Patch {
  Slow row;  ///< Polynomials of the second degree at its place in the picture, -1..1.
  double mean_mm;
};

std::optional<double> mean_of(const Image<float>& misfit_mm, int left, int top) {
  float sum = 0.0F;
  int count = 0;
  for (int y = top; y < top + kSide; ++y) {
    for (int x = left; x < left + kSide; ++x) {
      if (std::isnan(misfit_mm(x, y))) continue;
      sum += misfit_mm(x, y);
      ++count;
    }
  }
  if (count < kLeastPixels) return std::nullopt;
  return static_cast<double>(sum) / count;
}

std::vector<Patch> patches_of(const Image<float>& misfit_mm) {
  std::vector<Patch> patches;
  const double half_width = 0.5 * misfit_mm.width();
  const double half_height = 0.5 * misfit_mm.height();
  for (int y = 0; y + kSide <= misfit_mm.height(); y += kSide) {
    for (int x = 0; x + kSide <= misfit_mm.width(); x += kSide) {
      const auto mean_mm = mean_of(misfit_mm, x, y);
      if (!mean_mm) continue;
      const double u = x / half_width - 1.0;
      const double v = y / half_height - 1.0;
      patches.push_back({{1.0, u, v, u * u, u * v, v * v}, *mean_mm});
    }
  }
  return patches;
}

/// By least squares, held to what a sensor's error may be.
Slow slow_error(const std::vector<Patch>& patches) {
  using Matrix6d = Eigen::Matrix<double, 6, 6>;
  Matrix6d information = Matrix6d::Identity() / (kSensorErrorMm * kSensorErrorMm);
  Slow right = Slow::Zero();
  for (const auto& patch : patches) {
    information += patch.row * patch.row.transpose() / (kPatchNoiseMm * kPatchNoiseMm);
    right += patch.mean_mm * patch.row / (kPatchNoiseMm * kPatchNoiseMm);
  }
  return information.ldlt().solve(right);
}

}  // namespace

Evenness judge_evenness(const Image<float>& misfit_mm) {
  const std::vector<Patch> patches = patches_of(misfit_mm);
  if (patches.empty()) return {};
  const Slow error = slow_error(patches);
  double sum_mm2 = 0.0;
  for (const auto& patch : patches) {
    const double rest_mm = patch.mean_mm - patch.row.dot(error);
    sum_mm2 += rest_mm * rest_mm;
  }
  const auto count = static_cast<double>(patches.size());
  return {static_cast<int>(patches.size()), std::sqrt(sum_mm2 / std::max(1.0, count - kFreedom))};
}

}  // namespace mor::internal
