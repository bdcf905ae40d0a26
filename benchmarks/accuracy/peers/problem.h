// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/result.h"
#include "morgagni/geometry/point_cloud.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor::peers {

/// One registration to do: a cloud of the frame and where to start from.
struct ProblemRun {
  std::size_t cloud_idx = 0;  ///< Into `ProblemFrame::clouds`.
  Eigen::Isometry3d fixed_from_moving_init = Eigen::Isometry3d::Identity();
};

/// What the camera saw at one moment. Depth growth may depend on the start: several clouds.
struct ProblemFrame {
  std::size_t recording_frame = 0;   ///< Its place in the recording.
  std::vector<TriangleMesh> clouds;  ///< Frame depth, mm, with normals towards the camera.
  std::vector<ProblemRun> runs;
};

/// A set of registrations that every method gets alike. The truth stands in the file as well, for
/// whoever judges the poses; those who register do not read it.
struct ProblemSet {
  std::filesystem::path recording;  ///< Empty for problems that no camera saw.
  bool is_tracked = false;          ///< Starts are off by a frame's motion, not by a rough start.
  TriangleMesh fixed;               ///< The CT skin, frame ct, LPS mm, with normals.
  std::vector<ProblemFrame> frames;
};

/// Reads `problems.json` and the PLY files that it names.
/// @errors kNotFound, kIo; kInvalidArgument: no such JSON.
[[nodiscard]] Result<ProblemSet> read_problems(const std::filesystem::path& folder);

/// A cloud's vertices and normals.
[[nodiscard]] PointCloud to_point_cloud(const TriangleMesh& mesh);

/// Row by row, as the files and the answers have it.
[[nodiscard]] std::vector<double> to_numbers(const Eigen::Isometry3d& a_from_b);

}  // namespace mor::peers
