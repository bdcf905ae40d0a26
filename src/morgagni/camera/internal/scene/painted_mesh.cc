// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/scene/painted_mesh.h"

#include <algorithm>

#include "morgagni/camera/internal/scene/table.h"

namespace mor::internal {
namespace {

using Eigen::Vector3f;

constexpr float kSkinGloss = 26.0F;

}  // namespace

void PaintedMesh::append(const PaintedMesh& other, const Eigen::Isometry3f& this_from_other) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const auto& vertex : other.mesh.vertices) {
    mesh.vertices.push_back(this_from_other * vertex);
  }
  for (const auto& normal : other.mesh.normals) {
    mesh.normals.push_back(this_from_other.linear() * normal);
  }
  for (const auto& [a, b, c] : other.mesh.triangles) {
    mesh.triangles.push_back({first + a, first + b, first + c});
  }
  albedo.insert(albedo.end(), other.albedo.begin(), other.albedo.end());
  gloss.insert(gloss.end(), other.gloss.begin(), other.gloss.end());
}

PaintedMesh painted(TriangleMesh mesh, const Vector3f& albedo, float gloss) {
  PaintedMesh result{std::move(mesh), {}, {}};
  const std::size_t num_vertices = result.mesh.vertices.size();
  if (result.mesh.normals.size() != num_vertices) {
    result.mesh.normals = vertex_normals(result.mesh);
  }
  result.albedo.assign(num_vertices, albedo);
  result.gloss.assign(num_vertices, gloss);
  return result;
}

PaintedMesh painted_as_skin(TriangleMesh mesh, std::uint64_t seed) {
  PaintedMesh result = painted(std::move(mesh), Vector3f::Zero(), kSkinGloss);
  for (std::size_t i = 0; i < result.albedo.size(); ++i) {
    const Vector3f& p = result.mesh.vertices[i];
    const float wide = smooth_noise(p.x() / 46.0F, p.y() / 46.0F, p.z() / 46.0F, seed + 11) - 0.5F;
    const float fine = smooth_noise(p.x() / 11.0F, p.y() / 11.0F, p.z() / 11.0F, seed + 12) - 0.5F;
    const float spot = smooth_noise(p.x() / 7.0F, p.y() / 7.0F, p.z() / 7.0F, seed + 13);
    const float mole = 1.0F - 0.10F * std::clamp((spot - 0.84F) / 0.08F, 0.0F, 1.0F);
    result.albedo[i] = {mole * (226.0F + 16.0F * wide + 12.0F * fine),
                        mole * (176.0F - 22.0F * wide + 8.0F * fine),
                        mole * (150.0F - 26.0F * wide + 6.0F * fine)};
  }
  return result;
}

}  // namespace mor::internal
