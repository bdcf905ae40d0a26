// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "morgagni/core/image.h"

namespace mor::internal {

/// What automatic exposure and white balance make of red, green and blue in a frame, in (0, 1]: a
/// slow swing, a jump every few seconds, and the lamps' flicker. `swing` 0: ones.
[[nodiscard]] Eigen::Vector3f exposure_gains(double swing,
                                             std::uint64_t seed,
                                             std::uint64_t frame_id,
                                             double time_s);

/// Multiplies the picture.
void expose(Image<Rgb8>& color, const Eigen::Vector3f& gains);

}  // namespace mor::internal
