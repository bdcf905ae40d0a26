// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/structure_mesh.h"

#include <chrono>
#include <string>
#include <system_error>
#include <utility>

#include "morgagni/ct/import_protocol.h"
#include "morgagni/ct/internal/import_process.h"
#include "morgagni/ct/internal/surface_finish.h"

namespace mor {
namespace {

constexpr std::chrono::seconds kTimeLimit{120};
const Eigen::Vector3f kColor(0.55F, 0.78F, 0.62F);

/// Half a turn about the body's long axis: no mirror, so triangles keep their sense.
void bring_from_ras(TriangleMesh& mesh) {
  for (auto& vertex : mesh.vertices) vertex = {-vertex.x(), -vertex.y(), vertex.z()};
}

}  // namespace

Result<void> StructureMeshOptions::check() const {
  if (num_triangles >= 100 && num_triangles <= 1000000) return {};
  return make_error(
      ErrorCode::kInvalidArgument,
      "num_triangles must be in [100, 1000000], got " + std::to_string(num_triangles));
}

Result<StructureSurface> import_structure_mesh(const std::filesystem::path& path,
                                               const StructureMeshOptions& options,
                                               const Progress& progress) {
  MOR_CHECK(options.check());
  std::error_code failure;
  if (!std::filesystem::exists(path, failure))
    return make_error(ErrorCode::kNotFound, "there is no file " + path.string());
  MOR_TRY(const auto program, internal::find_import_program());
  MOR_TRY(auto read,
          internal::run_mesh_process(program, {kReadMeshTask, path, {}}, kTimeLimit, progress));
  const bool is_ras = read.frame.empty() ? options.frame == MeshFrame::kRas : read.frame == "RAS";
  if (is_ras) bring_from_ras(read.mesh);
  internal::finish_given_surface(read.mesh, options.num_triangles);
  return StructureSurface{path.stem().string(), kColor, std::move(read.mesh)};
}

}  // namespace mor
