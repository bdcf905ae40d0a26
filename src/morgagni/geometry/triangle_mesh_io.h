// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "morgagni/core/result.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

/// Reads a PLY mesh, binary little-endian or ASCII, vertices x y z [nx ny nz] and triangle faces;
/// other properties are passed over.
/// @errors kNotFound, kIo; kInvalidArgument (more than 2 GiB, counts that the file cannot hold, an
/// index
///         out of range, a number that is not finite, a face that is no triangle).
[[nodiscard]] Result<TriangleMesh> read_ply(const std::filesystem::path& path);

/// Writes binary little-endian PLY, with normals where the mesh has them. @errors kIo.
[[nodiscard]] Result<void> write_ply(const std::filesystem::path& path, const TriangleMesh& mesh);

}  // namespace mor
