// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/geometry/point_cloud.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// The moving surface as its camera sees it: in cells of equal ray slope the nearest and the
/// farthest reading. What was cut off as no part of the body is not in it.
class RangeMap {
 public:
  /// @param moving  Frame depth, mm, the camera at the origin.
  explicit RangeMap(const PointCloud& moving);

  struct Cell {
    float nearest_mm = 0.0F;
    float farthest_mm = 0.0F;  ///< 0: no reading.
  };
  /// Null outside of what the moving surface covers, and behind the camera.
  [[nodiscard]] const Cell* at(const Eigen::Vector3f& point) const;

 private:
  /// Of `cells_`; none outside.
  [[nodiscard]] std::optional<std::size_t> index_of(const Eigen::Array2f& slope) const;

  Eigen::Array2f first_ = Eigen::Array2f::Zero();  ///< Ray slope of the first cell's border.
  int width_ = 0;
  int height_ = 0;
  std::vector<Cell> cells_;
};

/// What the camera should see of the skin at a pose, held against what it sees.
struct SkinView {
  int num_seen = 0;      ///< There is a reading on the skin.
  int num_covered = 0;   ///< Readings lie before it.
  int num_floating = 0;  ///< Readings lie behind it: the camera saw through it.
  int num_missing = 0;   ///< No reading, though there are some around.

  /// Of the skin that nothing covers, how much is not there, 0..1. 1 where none is seen.
  [[nodiscard]] double absent_fraction() const;
  /// Of the skin seen or floating, 0..1. 0 where there is none.
  [[nodiscard]] double floating_fraction() const;
};

/// Points spread over the CT skin, with what a camera should see of them.
class SkinProbe {
 public:
  /// @param skin  With normals.
  explicit SkinProbe(const TriangleMesh& skin);

  /// @param tolerance_mm  A reading this near, in depth, is on the skin.
  /// @cost About 5 us.
  [[nodiscard]] SkinView look(const RangeMap& map,
                              const Eigen::Isometry3d& fixed_from_moving,
                              float tolerance_mm) const;
  /// The middle of the skin that faces the camera there, frame fixed.
  [[nodiscard]] Eigen::Vector3d facing_center(const Eigen::Isometry3d& fixed_from_moving) const;

 private:
  std::vector<Eigen::Vector3f> points_;
  std::vector<Eigen::Vector3f> normals_;
};

}  // namespace mor::internal
