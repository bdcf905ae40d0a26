// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include <Eigen/Geometry>

#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/render/internal/gl_objects.h"

namespace mor::internal {

/// A surface with fewer triangles and their corners in the order that a device draws fastest.
/// `normals` are those of the vertices kept; where a vertex has none, they come from its triangles.
/// Whatever the mesh is like (holes, loose or flat triangles, edges with three), no more than about
/// a fifth above `max_triangles` is left.
[[nodiscard]] TriangleMesh level_of_detail(const TriangleMesh& mesh, std::size_t max_triangles);

/// Every edge has a triangle on both sides, so that no inside can be seen.
[[nodiscard]] bool is_closed(const TriangleMesh& mesh);

/// A surface on the device. The context must be current where one is made, drawn or destroyed.
class GlStructure {
 public:
  GlStructure(std::string name, const TriangleMesh& mesh, const Eigen::Vector3f& color);

  /// Where each vertex lies in a picture, 0..1: what shaders get as its place in the atlas.
  void set_places(std::span<const Eigen::Vector2f> places);

  /// One draw call with the program that is in use. @param is_cut  Its inside can be seen.
  void draw(bool is_cut) const;

  enum class Side : std::uint8_t { kOuter, kInner };

  /// The same, only the triangles that turn this side to the viewer.
  void draw_side(Side side) const;

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const Eigen::Vector3f& color() const { return color_; }
  [[nodiscard]] const Eigen::AlignedBox3f& bounds() const { return bounds_; }

 private:
  void draw_triangles() const;

  GlVertexArray vertex_array_;
  GlBuffer vertices_;
  GlBuffer indices_;
  GlBuffer places_;
  GLsizei num_indices_ = 0;
  bool is_closed_ = false;
  std::string name_;
  Eigen::Vector3f color_;
  Eigen::AlignedBox3f bounds_;
};

}  // namespace mor::internal
