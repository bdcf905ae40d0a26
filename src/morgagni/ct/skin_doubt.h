// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Core>

namespace mor {

/// A stretch of the skin that the CT does not show for certain.
struct SkinDoubt {
  enum class Why : std::uint8_t {
    kCoverTaken,  ///< A blanket, a cushion, a cast lay on it and was counted out.
    kLayerTaken,  ///< A thin layer lay on it and was taken off.
    kLayerLeft,   ///< A thin layer comes near: it may go on here, where nothing tells it from skin.
  };

  Why why = Why::kLayerLeft;
  std::string place;  ///< "behind", "in front of", ... the body's middle, as CutPart has it.
  double area_cm2 = 0.0;
  double up_to_mm = 0.0;                                ///< How far off the skin may be.
  Eigen::Vector3d middle_mm = Eigen::Vector3d::Zero();  ///< A place of it, frame ct.
};

}  // namespace mor
