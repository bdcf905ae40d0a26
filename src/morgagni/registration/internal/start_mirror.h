// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "morgagni/geometry/point_cloud.h"
#include "morgagni/registration/internal/start_picture.h"
#include "morgagni/registration/internal/start_planes.h"
#include "morgagni/registration/internal/start_views.h"

namespace mor::internal {

/// What a camera would have seen in a mirror: the picture's left is its right. The CT's skin fits
/// there where the skin's mirror image fits the picture.
[[nodiscard]] StartPicture mirrored(const StartPicture& picture);
[[nodiscard]] std::vector<StartPlane> mirrored(std::vector<StartPlane> planes);
[[nodiscard]] PointCloud mirrored(PointCloud cloud);
[[nodiscard]] SeenViews mirrored(const SeenViews& views);

/// The pose in the mirrored picture at which the CT's mirror image would be, if its left and right
/// sides are alike about `middle_ct`.
[[nodiscard]] Eigen::Isometry3d mirrored(const Eigen::Isometry3d& ct_from_depth,
                                         const Eigen::Vector3d& middle_ct);

}  // namespace mor::internal
