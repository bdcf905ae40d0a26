// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "morgagni/core/result.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor::import {

/// The polygons and strips of a VTK XML PolyData file as triangles: ascii, base64 (inline or
/// appended) and raw appended data, plain or compressed with zlib, either byte order.
/// @errors kIo: cut short or damaged. kUnsupported: another kind of VTK file or compressor.
///         kInvalidArgument: more than kMaxMeshTriangles.
[[nodiscard]] Result<TriangleMesh> read_vtp(const std::filesystem::path& path);

}  // namespace mor::import
