// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/gl_structure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <meshoptimizer.h>

namespace mor::internal {
namespace {

/// 16 bytes a vertex: llvmpipe and GPUs fetch it in one piece.
struct PackedVertex {
  std::array<float, 3> position_mm;
  std::array<std::int8_t, 4> normal;  ///< Times 127.
};

std::int8_t packed_unit(float value) {
  return static_cast<std::int8_t>(std::lround(std::clamp(value, -1.0F, 1.0F) * 127.0F));
}

std::vector<PackedVertex> packed(const TriangleMesh& mesh) {
  std::vector<PackedVertex> vertices(mesh.vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Eigen::Vector3f& p = mesh.vertices[i];
    const Eigen::Vector3f& n = mesh.normals[i];
    vertices[i] = {{p.x(), p.y(), p.z()},
                   {packed_unit(n.x()), packed_unit(n.y()), packed_unit(n.z()), 0}};
  }
  return vertices;
}

std::vector<unsigned> corner_indices(const TriangleMesh& mesh) {
  std::vector<unsigned> indices;
  indices.reserve(mesh.triangles.size() * 3);
  for (const Triangle& triangle : mesh.triangles) {
    indices.insert(indices.end(), triangle.begin(), triangle.end());
  }
  return indices;
}

/// The mesh with these corners, its vertices in the order of first use, unused ones dropped.
TriangleMesh with_corners(const TriangleMesh& mesh, const std::vector<unsigned>& indices) {
  std::vector<unsigned> remap(mesh.vertices.size());
  const std::size_t num_vertices = meshopt_optimizeVertexFetchRemap(
      remap.data(), indices.data(), indices.size(), mesh.vertices.size());
  TriangleMesh result;
  result.vertices.resize(num_vertices);
  result.normals.resize(num_vertices);
  for (std::size_t i = 0; i < remap.size(); ++i) {
    if (remap[i] == ~0U) continue;
    result.vertices[remap[i]] = mesh.vertices[i];
    result.normals[remap[i]] = mesh.normals[i];
  }
  result.triangles.reserve(indices.size() / 3);
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    result.triangles.push_back({remap[indices[i]], remap[indices[i + 1]], remap[indices[i + 2]]});
  }
  return result;
}

/// Those of the mesh, and where it has none or one without a direction, from its triangles.
void complete_normals(TriangleMesh& mesh) {
  const bool has_all = mesh.normals.size() == mesh.vertices.size();
  const auto is_bad = [](const Eigen::Vector3f& normal) {
    return !normal.allFinite() || normal.squaredNorm() < 1e-12F;
  };
  if (has_all && std::none_of(mesh.normals.begin(), mesh.normals.end(), is_bad)) return;
  std::vector<Eigen::Vector3f> computed = vertex_normals(mesh);
  if (has_all) {
    for (std::size_t i = 0; i < computed.size(); ++i) {
      if (!is_bad(mesh.normals[i])) computed[i] = mesh.normals[i];
    }
  }
  mesh.normals = std::move(computed);
}

/// Vertices at one place become one: triangles that do not know of each other, as in an STL file,
/// cannot be simplified.
void weld(TriangleMesh& mesh) {
  std::vector<unsigned> remap(mesh.vertices.size());
  const std::vector<unsigned> indices = corner_indices(mesh);
  const std::size_t num_places = meshopt_generateVertexRemap(remap.data(),
                                                             indices.data(),
                                                             indices.size(),
                                                             mesh.vertices.data(),
                                                             mesh.vertices.size(),
                                                             sizeof(Eigen::Vector3f));
  if (num_places == mesh.vertices.size()) return;
  TriangleMesh welded;
  welded.vertices.resize(num_places);
  for (std::size_t i = 0; i < remap.size(); ++i) {
    if (remap[i] != ~0U) welded.vertices[remap[i]] = mesh.vertices[i];
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    welded.triangles.push_back({remap[a], remap[b], remap[c]});
  }
  welded.normals = vertex_normals(welded);
  mesh = std::move(welded);
}

std::vector<unsigned> simplified(const TriangleMesh& mesh, std::size_t max_triangles) {
  constexpr float kAnyError = 1.0F;  // The number of triangles decides.
  constexpr std::size_t kStillTooMany = 5;
  const std::vector<unsigned> indices = corner_indices(mesh);
  const float* const places = mesh.vertices.front().data();
  const std::size_t num_places = mesh.vertices.size();
  constexpr std::size_t kStride = sizeof(Eigen::Vector3f);
  const std::size_t wanted = max_triangles * 3;
  std::vector<unsigned> fewer(indices.size());
  fewer.resize(meshopt_simplify(fewer.data(),
                                indices.data(),
                                indices.size(),
                                places,
                                num_places,
                                kStride,
                                wanted,
                                kAnyError,
                                0,
                                nullptr));
  if (fewer.size() <= wanted + wanted / kStillTooMany) return fewer;
  // Loose pieces and edges with three triangles are not touched; a grid's cells take them all.
  fewer.resize(indices.size());
  fewer.resize(meshopt_simplifySloppy(fewer.data(),
                                      indices.data(),
                                      indices.size(),
                                      places,
                                      num_places,
                                      kStride,
                                      wanted,
                                      kAnyError,
                                      nullptr));
  return fewer;
}

}  // namespace

TriangleMesh level_of_detail(const TriangleMesh& mesh, std::size_t max_triangles) {
  TriangleMesh source = mesh;
  const bool is_too_large = source.triangles.size() > max_triangles;
  if (is_too_large) weld(source);
  complete_normals(source);
  const std::vector<unsigned> indices =
      is_too_large ? simplified(source, max_triangles) : corner_indices(source);
  if (indices.empty()) return source;
  std::vector<unsigned> ordered(indices.size());
  meshopt_optimizeVertexCache(
      ordered.data(), indices.data(), indices.size(), source.vertices.size());
  return with_corners(source, ordered);
}

bool is_closed(const TriangleMesh& mesh) {
  std::vector<std::uint64_t> edges;  // From the smaller vertex to the larger: direction left out.
  edges.reserve(mesh.triangles.size() * 3);
  for (const Triangle& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(triangle[i], triangle[(i + 1) % 3]);
      edges.push_back((std::uint64_t{a} << 32U) | b);
    }
  }
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size();) {
    const auto end =
        std::upper_bound(edges.begin() + static_cast<std::ptrdiff_t>(i), edges.end(), edges[i]);
    const auto count = static_cast<std::size_t>(end - edges.begin()) - i;
    if (count % 2 != 0) return false;
    i += count;
  }
  return true;
}

GlStructure::GlStructure(std::string name, const TriangleMesh& mesh, const Eigen::Vector3f& color)
    : vertex_array_(make_vertex_array()),
      vertices_(make_buffer()),
      indices_(make_buffer()),
      num_indices_(static_cast<GLsizei>(mesh.triangles.size() * 3)),
      is_closed_(internal::is_closed(mesh)),
      name_(std::move(name)),
      color_(color),
      bounds_(mesh.bounds()) {
  const std::vector<PackedVertex> vertices = packed(mesh);
  glBindVertexArray(vertex_array_.get());
  glBindBuffer(GL_ARRAY_BUFFER, vertices_.get());
  glBufferData(GL_ARRAY_BUFFER,
               static_cast<GLsizeiptr>(vertices.size() * sizeof(PackedVertex)),
               vertices.data(),
               GL_STATIC_DRAW);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.get());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER,
               static_cast<GLsizeiptr>(mesh.triangles.size() * sizeof(Triangle)),
               mesh.triangles.data(),
               GL_STATIC_DRAW);
  glEnableVertexAttribArray(0);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(PackedVertex), nullptr);
  glEnableVertexAttribArray(1);
  const auto* normal_offset = static_cast<const char*>(nullptr) + offsetof(PackedVertex, normal);
  glVertexAttribPointer(1, 3, GL_BYTE, GL_TRUE, sizeof(PackedVertex), normal_offset);
}

void GlStructure::set_places(std::span<const Eigen::Vector2f> places) {
  places_ = make_buffer();
  glBindVertexArray(vertex_array_.get());
  glBindBuffer(GL_ARRAY_BUFFER, places_.get());
  glBufferData(
      GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(places.size_bytes()), places.data(), GL_STATIC_DRAW);
  glEnableVertexAttribArray(2);
  glVertexAttribPointer(2, 2, GL_FLOAT, GL_FALSE, sizeof(Eigen::Vector2f), nullptr);
}

void GlStructure::draw(bool is_cut) const {
  if (is_closed_ && !is_cut) {
    glEnable(GL_CULL_FACE);
  } else {
    glDisable(GL_CULL_FACE);
  }
  draw_triangles();
}

void GlStructure::draw_side(Side side) const {
  glEnable(GL_CULL_FACE);
  glCullFace(side == Side::kOuter ? GL_BACK : GL_FRONT);
  draw_triangles();
  glCullFace(GL_BACK);
}

void GlStructure::draw_triangles() const {
  glBindVertexArray(vertex_array_.get());
  glDrawElements(GL_TRIANGLES, num_indices_, GL_UNSIGNED_INT, nullptr);
}

}  // namespace mor::internal
