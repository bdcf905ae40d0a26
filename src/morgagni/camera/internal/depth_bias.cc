// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/depth_bias.h"

#include <array>
#include <cmath>

#include "morgagni/camera/internal/random.h"

namespace mor::internal {
namespace {

/// Legendre polynomials up to the third degree: of even size over the picture.
std::array<double, 4> legendre(double x) {
  return {1.0, x, 0.5 * (3.0 * x * x - 1.0), 0.5 * x * (5.0 * x * x - 3.0)};
}

double from_side_to_side(int at, int size) {
  return 2.0 * (at + 0.5) / size - 1.0;
}

}  // namespace

DepthBias::DepthBias(int width_px, int height_px, double amplitude_mm, std::uint64_t seed)
    : factor_(width_px, height_px) {
  constexpr std::size_t kDegree = 3;
  std::array<std::array<double, kDegree + 1>, kDegree + 1> coefficients{};
  Draws draw(scramble(seed ^ 0x42494153U));
  for (std::size_t i = 0; i <= kDegree; ++i) {
    for (std::size_t k = 0; i + k <= kDegree; ++k) {
      const double halvings = i + k > 1 ? static_cast<double>(i + k - 1) : 0.0;
      coefficients[i][k] = draw(-1.0, 1.0) * std::exp2(-halvings);
    }
  }
  double squares = 0.0;
  for (int y = 0; y < height_px; ++y) {
    const auto along_v = legendre(from_side_to_side(y, height_px));
    for (int x = 0; x < width_px; ++x) {
      const auto along_u = legendre(from_side_to_side(x, width_px));
      double shape = 0.0;
      for (std::size_t i = 0; i <= kDegree; ++i) {
        for (std::size_t k = 0; i + k <= kDegree; ++k) {
          shape += coefficients[i][k] * along_u[i] * along_v[k];
        }
      }
      factor_(x, y) = static_cast<float>(shape);
      squares += shape * shape;
    }
  }
  const double rms = std::sqrt(squares / static_cast<double>(factor_.size()));
  const auto scale = static_cast<float>(amplitude_mm / (rms * kReferenceMm));
  for (std::size_t i = 0; i < factor_.size(); ++i) {
    factor_.data()[i] = 1.0F + scale * factor_.data()[i];
  }
}

void DepthBias::apply(Image<float>& z_mm) const {
  for (std::size_t i = 0; i < z_mm.size(); ++i) z_mm.data()[i] *= factor_.data()[i];
}

}  // namespace mor::internal
