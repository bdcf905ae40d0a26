// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "morgagni/core/image.h"

namespace mor::internal {

/// What is left of a range camera's distortion after its calibration: a smooth error of depth that
/// is the same in every frame (Teichman, Miller, Thrun, "Unsupervised intrinsic calibration of
/// depth sensors via SLAM", RSS 2013, found such fields in every sensor they looked at).
///
///   z_seen = z + amplitude * shape(u, v) * z / 800 mm
///
/// u and v run from -1 to 1 over the picture; `shape` is a polynomial of third degree whose
/// coefficients are drawn (the same spread for each, the constant included, halved by each degree
/// above the first) and scaled to a root mean square of 1 over the picture. So at 800 mm the
/// error's root mean square is the amplitude, and it grows with the distance.
class DepthBias {
 public:
  static constexpr double kReferenceMm = 800.0;

  DepthBias(int width_px, int height_px, double amplitude_mm, std::uint64_t seed);

  /// Readings of 0 stay 0.
  void apply(Image<float>& z_mm) const;

 private:
  Image<float> factor_;  ///< Of z.
};

}  // namespace mor::internal
