// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <Eigen/Geometry>

#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// Camera places that have nothing to do with each other, for studies of accuracy and of automatic
/// starts: each looks at a place on the skin near the body's middle from anywhere above the table.
///
/// The direction is even over the part of the upper half space that lies at least 15 degrees above
/// the table's plane, the distance even over 500..1200 mm, the roll even over a whole turn; the
/// place looked at lies up to 4 degrees beside the picture's centre each way.
///
/// A hand holds the camera at such a place and drifts: within 1.5 s by 50 to 100 mm in any
/// direction while it keeps what it looks at in view, but for up to 5 degrees of pan, tilt and roll
/// each: mostly 4 to 14 degrees in all. After 3 s it is where it was. Or it walks: to one side and
/// back, level, about the place looked at.
class ViewPlaces {
 public:
  static constexpr double kLeastElevationRad = 0.2618;
  static constexpr double kNearestMm = 500.0;
  static constexpr double kFarthestMm = 1200.0;
  static constexpr double kWalkMmPerS = 100.0;

  /// @param skin  Frame ct, LPS, supine: up is -y.
  /// @param distance_mm  From camera to skin in place of a random one.
  /// @param walk_mm  How far the hand goes, at kWalkMmPerS on average, in place of the drift.
  ViewPlaces(std::shared_ptr<const TriangleMesh> skin,
             std::optional<double> distance_mm,
             std::uint64_t seed,
             std::optional<double> walk_mm = std::nullopt);

  /// The camera at place number `view`, `held_s` seconds after the hand came there. The same for
  /// the same seed. @threads Safe to call from many at once.
  /// @cost A look at every triangle, about 0.3 ms, once or a few times.
  [[nodiscard]] Eigen::Isometry3d ct_from_camera(std::uint64_t view, double held_s = 0.0) const;

 private:
  /// Where a ray from far away, towards `through`, first meets the skin's outside.
  [[nodiscard]] std::optional<Eigen::Vector3d> first_hit(const Eigen::Vector3d& through,
                                                         const Eigen::Vector3d& to_camera) const;

  std::shared_ptr<const TriangleMesh> skin_;
  std::optional<double> distance_mm_;
  std::uint64_t seed_;
  std::optional<double> walk_mm_;
  Eigen::AlignedBox3d bounds_;
};

}  // namespace mor::internal
