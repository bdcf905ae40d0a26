// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

/// What a depth picture says of a pose, whatever registration found it: points of the skin that
/// face the camera there, held against the readings where they must be seen.
struct SkinEvidence {
  int num_samples = 0;   ///< Over all the skin.
  int num_expected = 0;  ///< Face the camera, lie in the picture, and there is a reading.
  int num_seen = 0;      ///< The reading is on the skin.
  int num_patches = 0;   ///< Of those, with enough readings around to be averaged ...
  int num_behind = 0;  ///< ... and these lie behind the skin by more than noise and a good pose do.
  int num_covered = 0;   ///< The reading is before it: something covers the skin there.
  int num_floating = 0;  ///< The reading is behind it: the skin would float before what is there.

  /// Of the skin expected, 0..1. 0 where none is.
  [[nodiscard]] double seen_fraction() const;
  /// Of the patches, 0..1. Clutter lies before the skin; what lies behind it, though only by
  /// millimetres, tells of a pose that clutter has pulled away. 0 where there is none.
  [[nodiscard]] double behind_fraction() const;
  /// Of all the body's skin, 0..1; about a half is the most that a camera can see of anything.
  [[nodiscard]] double seen_share() const;
  /// Of the skin that nothing covers, 0..1. 0 where none is.
  [[nodiscard]] double floating_fraction() const;

  Eigen::Vector3d seen_center_mm = Eigen::Vector3d::Zero();  ///< Of the skin seen, frame ct.
  double seen_radius_mm = 0.0;  ///< Of the skin seen: root mean square distance from its centre.
};

/// Points spread over the CT skin, for comparing it with depth pictures.
class SkinSamples {
 public:
  /// Takes about `count` of the mesh's vertices; ACVD spreads them evenly. The mesh has normals.
  explicit SkinSamples(const TriangleMesh& skin, std::size_t count = 1500);

  /// @param depth_mm  0 = no reading. Of `camera`'s size.
  /// @param tolerance_mm  A reading this near, in depth, is on the skin. > 0.
  /// @cost About 40 us for 1500 samples.
  [[nodiscard]] SkinEvidence compare(ImageView<const std::uint16_t> depth_mm,
                                     const PinholeCamera& camera,
                                     const Eigen::Isometry3d& ct_from_depth,
                                     double tolerance_mm) const;

 private:
  std::vector<Eigen::Vector3f> points_;
  std::vector<Eigen::Vector3f> normals_;
};

}  // namespace mor
