// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "morgagni/core/result.h"
#include "morgagni/documentation/export_model.h"
#include "morgagni/documentation/printable.h"

// The writers are our own: each is a page of code over nlohmann-json or libzip, while the libraries
// for the same (tinygltf, assimp's exporter, lib3mf 1.8) copy every mesh into theirs, pick names
// and numbers of their own, or know no textured 3MF. Independent libraries read the files in the
// tests.

namespace mor {

/// What a file says of itself, where its format has a place for it.
struct ExportTitle {
  std::string title;       ///< The case.
  std::string created_at;  ///< UTC, ISO 8601.
};

/// Binary glTF 2.0 in metres, y up (to the head), z to the front, x to the body's left; skin and
/// structures are nodes of their own, the picture a PNG inside. The texture is shown unlit: the
/// light of the room is in it.
[[nodiscard]] std::string encode_glb(const ExportModel& model, const ExportTitle& title);

/// A glTF place in metres of a CT place in mm.
[[nodiscard]] inline Eigen::Vector3f gltf_from_ct(const Eigen::Vector3f& ct_mm) {
  return Eigen::Vector3f(ct_mm.x(), ct_mm.z(), -ct_mm.y()) * 0.001F;
}

/// Wavefront OBJ in mm, frame ct (LPS), which names its materials' file.
[[nodiscard]] std::string encode_obj(const ExportModel& model,
                                     const ExportTitle& title,
                                     const std::string& material_file);
[[nodiscard]] std::string encode_mtl(const ExportModel& model, const std::string& picture_file);

/// Binary PLY in mm, frame ct, with normals and a colour a vertex: the picture's where the surface
/// has one, and then so finely divided that about each millimetre has its own.
[[nodiscard]] std::string encode_colored_ply(const ExportSurface& surface,
                                             const Image<Rgb8>& picture,
                                             const ExportTitle& title);

/// Binary STL in mm, frame ct. It has no colours.
[[nodiscard]] std::string encode_stl(const TriangleMesh& mesh, const ExportTitle& title);

/// 3MF in mm, z to the head: the printable skin with the model's picture; what closes it has a
/// colour of its own. @errors kInternal: libzip failed.
[[nodiscard]] Result<std::string> encode_skin_3mf(const ExportModel& model,
                                                  const PrintableSolid& solid,
                                                  const ExportTitle& title);

/// The structures of the model, each an object with its colour: of type "model" where it is a
/// closed solid, else "surface", which printers do not print. @errors As encode_skin_3mf.
[[nodiscard]] Result<std::string> encode_structures_3mf(const ExportModel& model,
                                                        const ExportTitle& title);

}  // namespace mor
