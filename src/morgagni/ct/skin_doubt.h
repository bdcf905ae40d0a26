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
    kTakenOff,    ///< The same, because somebody asked for it (SkinOptions::take_off_mm).
    kLayerLeft,   ///< A thin layer comes near: it may go on here, where nothing tells it from skin.
  };

  Why why = Why::kLayerLeft;
  std::string place;  ///< "back", "front", "left", "right", "lower end" or "upper end" of the body.
  double area_cm2 = 0.0;
  double up_to_mm = 0.0;  ///< How far off 19 of 20 places of it are at most (docs/prepare.md).
  Eigen::Vector3d middle_mm = Eigen::Vector3d::Zero();  ///< A place of it, frame ct.
};

}  // namespace mor
