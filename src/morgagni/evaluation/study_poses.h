// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/camera/simulated_camera.h"
#include "morgagni/core/result.h"
#include "morgagni/evaluation/ground_truth.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

/// How well a simulated person tags. Normal errors; 0: exact.
struct TaggingOptions {
  double marker_px = 1.0;     ///< SD each way in the colour picture. >= 0.
  double marker_ct_mm = 0.7;  ///< SD each way in the CT, about a voxel. >= 0.
  double landmark_mm = 8.0;   ///< SD each way of the four landmarks of a start. >= 0.
};

/// A marker as somebody tagged it in both pictures.
struct TaggedMarker {
  Eigen::Vector3d ct;         ///< Where it truly is, LPS mm.
  Eigen::Vector3d tagged_ct;  ///< Tagged in the CT.
  Eigen::Vector3d
      tagged_depth;  ///< Tagged in the colour picture, its depth read there; frame depth.
};

/// One camera pose of a study.
struct StudyPose {
  std::shared_ptr<const RgbdFrame> frame;
  Eigen::Isometry3d ct_from_depth = Eigen::Isometry3d::Identity();  ///< The truth.
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity();          ///< From four landmarks.
  std::vector<TaggedMarker> markers;  ///< The five visible ones nearest to the picture's centre.
  double fre_mm = 0.0;                ///< Horn's fit of the tagged markers, root mean square.
};

inline constexpr std::size_t kMarkersUsed = 5;  ///< Of the visible ones, as the paper.

/// The first views of a camera with path=views that a study can use: from above (40 degrees or
/// more), 500..850 mm from what is in the picture's centre, five markers or more in plain sight.
///
/// Each pose gets what a person would do: five markers tagged in both pictures (paper, section 3),
/// and a start from four places on the skin (Horn's fit), far from each other.
/// @param camera  @param camera_options  What it was made from.
/// @param markers  On the skin.
/// @errors kInvalidArgument: too few of 400 views a pose can be used.
[[nodiscard]] Result<std::vector<StudyPose>> draw_study_poses(
    const TriangleMesh& skin,
    const SimulatedCamera& camera,
    const SimulatedCameraOptions& camera_options,
    const std::vector<Target>& markers,
    const TaggingOptions& tagging,
    int num_poses);

}  // namespace mor
