// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "morgagni/core/image.h"
#include "morgagni/ct/body_check.h"
#include "morgagni/ct/internal/bit_mask.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// Which of the CT's axes a picture has across, down and through, and which way they run.
class SliceFrame {
 public:
  SliceFrame(const Volume& volume, BodyPlane plane);

  /// Across, down and through.
  [[nodiscard]] Eigen::Vector3d size_mm() const { return size_mm_; }
  /// @param shares  0..1 across, down and through.
  /// @return mm of the grid, as in `ct_from_grid * mm`: the first voxel's centre is the origin.
  [[nodiscard]] Eigen::Vector3d grid_mm(const Eigen::Vector3d& shares) const;
  /// How far through the CT a place lies, 0..1. @param grid_mm  As above.
  [[nodiscard]] double share_through(const Eigen::Vector3d& grid_mm) const;

 private:
  std::array<int, 3> axis_{};
  std::array<bool, 3> flipped_{};
  Eigen::Vector3d size_mm_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d spacing_mm_;
};

/// What was found of the body, on a grid that may be coarser than the CT's.
struct CheckedBody {
  const Volume& grid;
  const BitMask& body;
  const BitMask& doubtful;                  ///< Where the outline is no certain skin.
  const std::vector<std::uint8_t>& labels;  ///< A voxel each: 0, or the number of a part from 1.
  const std::vector<BodyPart>& parts;
  double threshold_hu = 0.0;
  double upper_hu = 0.0;
};

/// One slice: grey values, parts in their colours, the body's outline.
/// @param body  None: only the grey values.
[[nodiscard]] Image<Rgb8> draw_check_slice(
    const Volume& volume, BodyPlane plane, double position, int height_px, const CheckedBody* body);

}  // namespace mor::internal
