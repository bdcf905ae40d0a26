// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "morgagni/core/image.h"

/// How different two pictures look, for tests.
namespace mor::testing {

/// CIE L*a*b* (D65) of an sRGB colour.
inline std::array<float, 3> lab_of(const std::array<float, 3>& srgb_255) {
  std::array<float, 3> linear{};
  for (std::size_t i = 0; i < 3; ++i) {
    const float v = srgb_255[i] / 255.0F;
    linear[i] = v <= 0.04045F ? v / 12.92F : std::pow((v + 0.055F) / 1.055F, 2.4F);
  }
  const auto [r, g, b] = linear;
  const auto f = [](float t) { return t > 0.008856F ? std::cbrt(t) : 7.787F * t + 16.0F / 116.0F; };
  const float x = f((0.4124F * r + 0.3576F * g + 0.1805F * b) / 0.9505F);
  const float y = f(0.2126F * r + 0.7152F * g + 0.0722F * b);
  const float z = f((0.0193F * r + 0.1192F * g + 0.9505F * b) / 1.089F);
  return {116.0F * y - 16.0F, 500.0F * (x - y), 200.0F * (y - z)};
}

struct PictureDifference {
  double mean = 0.0;        ///< Of the colour difference (CIE 1976), and
  double seen_share = 0.0;  ///< the share of pixels at which it is more than kSeen.
  Image<float> delta;       ///< At each pixel.

  static constexpr float kSeen = 4.0F;  ///< 2.3 are just noticeable, side by side.

  /// Another driver's rounding or a differently broken tie at an edge passes; a structure two
  /// pixels elsewhere or a tenth darker does not.
  [[nodiscard]] bool is_same() const { return mean < 0.35 && seen_share < 0.008; }
};

/// Compares means of three by three pixels, as an eye does that does not see single ones.
inline PictureDifference difference(const Image<Rgb8>& a, const Image<Rgb8>& b) {
  PictureDifference result;
  result.delta = Image<float>(a.width(), a.height());
  const auto around = [](const Image<Rgb8>& picture, int x, int y) {
    std::array<float, 3> sum{};
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Rgb8& pixel = picture(std::clamp(x + dx, 0, picture.width() - 1),
                                    std::clamp(y + dy, 0, picture.height() - 1));
        sum[0] += pixel.r / 9.0F;
        sum[1] += pixel.g / 9.0F;
        sum[2] += pixel.b / 9.0F;
      }
    }
    return lab_of(sum);
  };
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      const auto p = around(a, x, y);
      const auto q = around(b, x, y);
      const float delta = std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
      result.delta(x, y) = delta;
      result.mean += delta / static_cast<double>(a.size());
      result.seen_share += delta > PictureDifference::kSeen ? 1.0 / a.size() : 0.0;
    }
  }
  return result;
}

}  // namespace mor::testing
