// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/ct/automatic_structures.h"
#include "morgagni/ct/label_map.h"
#include "morgagni/ct/structure_mesh.h"
#include "morgagni/ct/surfaces.h"
#include "morgagni/ct/volume_import.h"

namespace mor {

struct PrepareOptions {
  ImportOptions ct;
  std::vector<std::filesystem::path> label_maps;  ///< Structures that were segmented elsewhere.
  std::vector<std::filesystem::path> meshes;      ///< The same, as surfaces.
  bool total_segmentator = false;  ///< Labels without names are TotalSegmentator's "total".
  LabelSurfaceOptions labels;
  StructureMeshOptions mesh;
  AutomaticStructureOptions automatic;
  SkinOptions skin;
  BoneOptions bone;

  [[nodiscard]] Result<void> check() const;
};

/// What a preparation made, in numbers for people.
struct PrepareSummary {
  std::size_t num_skin_vertices = 0;
  std::size_t num_full_skin_vertices = 0;
  std::size_t num_bone_triangles = 0;
  std::vector<std::string> structure_names;  ///< Beside the bone.
  std::vector<CutPart> cut;                  ///< What lay beside the body.
  std::vector<SkinDoubt> doubts;             ///< Where the skin is not certain.
  double seconds = 0.0;                      ///< After reading.
  double reading_seconds = 0.0;
};

/// Whether a case may be made at this place: there is none, or a case that nobody uses.
/// @errors As prepare_case().
[[nodiscard]] Result<void> check_case_folder(const std::filesystem::path& folder);

/// From a CT to a case: imports it, takes skin, bone and distance field, and writes the case
/// folder.
///
/// The folder is written aside and put in its place at the end, so that at any moment there is the
/// old case, or the new one, or none: never half of one. A run that is killed leaves nothing beside
/// it. What people made in the case (kKeptFolders) stays in it.
///
/// @param ct      As import_volume() reads it.
/// @param folder  The case. Made, or replaced when it is a case already.
/// @errors As import_volume and extract_skin; kInvalidArgument: `folder` exists and is no case,
/// is in use, or holds what people made on another CT; kIo.
[[nodiscard]] Result<PrepareSummary> prepare_case(const std::filesystem::path& ct,
                                                  const std::filesystem::path& folder,
                                                  const PrepareOptions& options,
                                                  const Progress& progress);

/// The same of a CT that was imported before.
/// @param source  Where it came from, for the case's record.
[[nodiscard]] Result<PrepareSummary> prepare_case(const Volume& volume,
                                                  const std::filesystem::path& source,
                                                  const std::filesystem::path& folder,
                                                  const PrepareOptions& options,
                                                  const Progress& progress);

}  // namespace mor
