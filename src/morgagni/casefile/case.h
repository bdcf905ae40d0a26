// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "morgagni/core/result.h"
#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/geometry/volume.h"
#include "morgagni/registration/fixed_surface.h"

namespace mor {

/// Something segmented in the CT, as the case keeps it. Frame ct, LPS mm.
struct Structure {
  std::string name;  ///< "bone".
  Eigen::Vector3f color = Eigen::Vector3f::Ones();
  TriangleMesh mesh;  ///< With normals.
};

/// A prepared case: what the live part needs of one body.
struct Case {
  std::string name;                                        ///< Of the folder: case_title().
  std::filesystem::path folder;                            ///< Where it was loaded from.
  std::string ct_description;                              ///< What the CT said of itself.
  std::string ct_voxels_sha256;                            ///< Which CT it is.
  Eigen::Vector3d ct_center_mm = Eigen::Vector3d::Zero();  ///< Centre of the voxel grid, LPS.
  Eigen::Vector3d ct_half_voxel_mm =
      Eigen::Vector3d::Zero();  ///< From a voxel's centre to its far corner, LPS.
  std::shared_ptr<const FixedSurface> skin;
  std::vector<Structure> structures;
  std::shared_ptr<const Volume> volume;  ///< The CT of the body alone (SkinSurfaces::body). None in
                                         ///< a case made before Morgagni kept it.
};

/// The file that makes a folder a case. Written last.
inline constexpr const char* kCaseFile = "case.json";

/// Reads a case and checks each file against its hash.
/// @errors kNotFound (no folder, no case.json: says how to make one), kIo, kInvalidArgument
/// (damaged, or of a
///         newer format).
[[nodiscard]] Result<Case> load_case(const std::filesystem::path& folder);

}  // namespace mor
