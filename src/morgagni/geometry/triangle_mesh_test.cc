// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/geometry/triangle_mesh.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "morgagni/geometry/testing/box_mesh.h"

namespace mor {
namespace {

/// A cube of side 2 mm about the origin.
TriangleMesh cube() {
  return testing_mesh::make_box({-1.0F, -1.0F, -1.0F}, {1.0F, 1.0F, 1.0F});
}

TEST(TriangleMesh, BoundsHoldEveryVertex) {
  const auto box = cube().bounds();
  EXPECT_EQ(box.min(), Eigen::Vector3f(-1, -1, -1));
  EXPECT_EQ(box.max(), Eigen::Vector3f(1, 1, 1));
  EXPECT_TRUE(TriangleMesh().bounds().isEmpty());
}

TEST(TriangleMesh, AreaOfACubeIsSixFaces) {
  EXPECT_NEAR(surface_area_mm2(cube()), 24.0, 1e-6);
}

TEST(VertexNormals, PointAlongTheDiagonalsOfACubeWhateverItsTriangulation) {
  const auto mesh = cube();
  const auto normals = vertex_normals(mesh);
  ASSERT_EQ(normals.size(), 8U);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_LT((normals[i] - mesh.vertices[i].normalized()).norm(), 1e-5F) << i;
  }
}

TEST(VertexNormals, PassOverDegenerateTrianglesAndGiveLonelyVerticesPlusZ) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {9, 9, 9}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 1, 1}};
  const auto normals = vertex_normals(mesh);
  EXPECT_EQ(normals[0], -Eigen::Vector3f::UnitZ());
  EXPECT_EQ(normals[3], Eigen::Vector3f::UnitZ());
  EXPECT_EQ(normals[4], Eigen::Vector3f::UnitZ());
}

}  // namespace
}  // namespace mor
