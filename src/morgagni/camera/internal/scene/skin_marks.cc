// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/scene/skin_marks.h"

#include <algorithm>
#include <cmath>

#include "morgagni/camera/internal/scene/table.h"

namespace mor::internal {

Eigen::Vector3f skin_mark_at(const Eigen::Vector3f& at_ct, std::uint64_t seed) {
  const auto noise = [&](float scale_mm, std::uint64_t which) {
    const Eigen::Vector3f p = at_ct / scale_mm;
    return smooth_noise(p.x(), p.y(), p.z(), seed + which);
  };
  const auto ramp = [](float value, float from, float to) {
    return std::clamp((value - from) / (to - from), 0.0F, 1.0F);
  };
  const float freckle = ramp(noise(6.0F, 31), 0.70F, 0.80F);
  // A line lies where the noise crosses its middle; the slower one leaves gaps between lines.
  const float line = (1.0F - ramp(std::abs(noise(23.0F, 32) - 0.5F), 0.012F, 0.045F)) *
                     ramp(noise(31.0F, 33), 0.45F, 0.55F);
  const float bruise = ramp(noise(38.0F, 34), 0.70F, 0.85F);
  const Eigen::Vector3f brown(0.26F, 0.36F, 0.40F);
  const Eigen::Vector3f red(0.30F, 0.52F, 0.50F);
  const Eigen::Vector3f blue(0.24F, 0.26F, 0.10F);
  return (Eigen::Vector3f::Ones() - freckle * brown)
      .cwiseProduct(Eigen::Vector3f::Ones() - line * red)
      .cwiseProduct(Eigen::Vector3f::Ones() - bruise * blue);
}

}  // namespace mor::internal
