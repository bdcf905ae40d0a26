// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>

#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/ct/label_map.h"

namespace mor {

/// In which frame a mesh file is, where it does not say so itself.
enum class MeshFrame : std::uint8_t { kLps, kRas };

struct StructureMeshOptions {
  MeshFrame frame = MeshFrame::kLps;
  int num_triangles = 50000;  ///< At most about. 100..1,000,000.

  [[nodiscard]] Result<void> check() const;
};

/// Reads a structure that was segmented elsewhere as a surface: STL, OBJ, PLY or VTP, mm, in the
/// import process like import_volume(). A file that says "SPACE=RAS" or "SPACE=LPS" (3D Slicer) is
/// believed.
/// @return Named after the file, with normals, frame ct.
/// @errors As import_volume(); kInvalidArgument: no triangles, too many.
[[nodiscard]] Result<StructureSurface> import_structure_mesh(const std::filesystem::path& path,
                                                             const StructureMeshOptions& options,
                                                             const Progress& progress);

}  // namespace mor
