// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/geometry/volume.h"

namespace mor {

struct LabelName {
  int value = 0;
  std::string name;
  Eigen::Vector3f color = Eigen::Vector3f::Ones();  ///< 0 to 1.
};

/// A volume of labels: 0 is nothing, every other number one structure.
struct LabelMap {
  Volume voxels;                 ///< Its `hu` are the labels, 0 to 32767.
  std::vector<LabelName> names;  ///< As far as the file says them.
  int num_in_file = 1;  ///< Maps that the file holds: of an RT Structure Set one each structure.
};

/// Reads a label map (NIfTI, NRRD, MetaImage, DICOM Segmentation) as import_volume() reads a CT.
/// Names and colours come from 3D Slicer's NRRD keys, the label table that TotalSegmentator writes
/// into its NIfTI, or the DICOM segments.
/// @errors As import_volume(); kInvalidArgument: voxels that are no whole numbers from 0 to 32767.
[[nodiscard]] Result<LabelMap> import_label_map(const std::filesystem::path& path,
                                                const Progress& progress);

/// The same of a file that may hold several, whose structures may overlap: a DICOM RT Structure
/// Set, each structure's closed contours filled. @errors As import_label_map().
[[nodiscard]] Result<std::vector<LabelMap>> import_label_maps(const std::filesystem::path& path,
                                                              const Progress& progress);

/// The classes of TotalSegmentator's task "total" (version 2), by their numbers 1 to 117.
[[nodiscard]] std::vector<LabelName> total_segmentator_names();

struct LabelSurfaceOptions {
  int num_triangles = 20000;     ///< Of each structure, at most about. 100..1,000,000.
  double min_volume_mm3 = 50.0;  ///< Smaller structures are left out. >= 0.

  [[nodiscard]] Result<void> check() const;
};

struct StructureSurface {
  std::string name;  ///< "label 7" where nobody names it.
  Eigen::Vector3f color = Eigen::Vector3f::Ones();
  TriangleMesh mesh;  ///< Closed, smooth, with normals; frame ct.
};

/// A surface for each label, in the order of the labels.
/// @errors kInvalidArgument: bad options, no label at all, more than 200 labels.
/// @cost Goes with the labels' boxes; 512x512x300 with 24 large labels: see label_map_test.
[[nodiscard]] Result<std::vector<StructureSurface>> extract_labels(
    const LabelMap& labels, const LabelSurfaceOptions& options, const Progress& progress);

}  // namespace mor
