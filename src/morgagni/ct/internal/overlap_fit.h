// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/ct/volume_alignment.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// Two blocks of one body (body_block) fitted by their HU where both show it.
class OverlapFit {
 public:
  OverlapFit(const Volume& first, const Volume& second) : first_(first), second_(second) {}

  /// Gauss-Newton on the differences of HU, robust against what differs (Huber).
  [[nodiscard]] Eigen::Isometry3d refined(const Eigen::Isometry3d& first_from_second) const;

  [[nodiscard]] OverlapQuality quality(const Eigen::Isometry3d& first_from_second) const;

 private:
  struct Cube {
    Eigen::Vector3d place_mm;  ///< Frame ct of the first.
    double hu = 0.0;
  };
  /// HU and its change per mm at a place of the second.
  struct Slope {
    double hu = 0.0;
    Eigen::Vector3d per_mm = Eigen::Vector3d::Zero();
  };
  struct Cell {
    int x = 0, y = 0, z = 0;
  };

  [[nodiscard]] std::optional<Slope> slope_at(const Eigen::Vector3d& place_mm) const;
  [[nodiscard]] std::vector<Cube> cubes_in(const Cell& first, const Cell& end, int stride) const;
  /// By how much a piece lies off; none where it has too little to be held by.
  [[nodiscard]] std::optional<double> offset_of(const std::vector<Cube>& piece,
                                                const Eigen::Isometry3d& second_from_first) const;

  const Volume& first_;
  const Volume& second_;
};

}  // namespace mor::internal
