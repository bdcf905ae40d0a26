// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace mor::internal {

/// CIE L*a*b* (D65, 2 degrees) of an sRGB colour, 0..255.
[[nodiscard]] Eigen::Vector3d lab_from_srgb(const Eigen::Vector3d& rgb);

/// CIEDE2000 between two L*a*b* colours (Sharma, Wu, Dalal, "The CIEDE2000 color-difference
/// formula", 2005). About 1 is just to be seen side by side.
[[nodiscard]] double ciede2000(const Eigen::Vector3d& lab_a, const Eigen::Vector3d& lab_b);

}  // namespace mor::internal
