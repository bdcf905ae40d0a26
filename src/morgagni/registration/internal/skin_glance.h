// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/registration/internal/lanes.h"
#include "morgagni/registration/internal/skin_agreement.h"
#include "morgagni/registration/internal/start_picture.h"

namespace mor::internal {

/// Some hundreds of points spread over the skin, eight of them looked up at once: the automatic
/// start glances at thousands of poses a picture.
class SkinGlance {
 public:
  /// @param spacing_mm  One vertex is taken of each cube of this side.
  SkinGlance(const TriangleMesh& skin, float spacing_mm);

  /// What those that face the camera say of the pose.
  [[nodiscard]] SkinAgreement at(const StartPicture& picture,
                                 const Eigen::Isometry3d& ct_from_depth,
                                 float tolerance_mm) const;

 private:
  struct SkinLanes {
    Lanes x{}, y{}, z{};
    Lanes normal_x{}, normal_y{}, normal_z{};  ///< Zero where the last eight are not full.
  };

  std::vector<SkinLanes> groups_;
};

}  // namespace mor::internal
