// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "morgagni/core/result.h"

namespace mor::import {

/// Hands a surface (STL, OBJ, PLY, VTP) to the parent: all triangles of the file as one mesh, corners at
/// the same place joined. A frame that the file names ("SPACE=RAS", as 3D Slicer writes it) is
/// told.
/// @errors kUnsupported: another format. kIo: cut short or damaged. kInvalidArgument: no triangle,
/// or more than kMaxMeshTriangles.
[[nodiscard]] Result<void> import_mesh_file(const std::filesystem::path& path);

}  // namespace mor::import
