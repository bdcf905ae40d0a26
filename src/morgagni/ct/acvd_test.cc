// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/acvd.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/ct/internal/dual_mesh.h"
#include "morgagni/ct/internal/marching_cubes.h"
#include "morgagni/ct/mesh_quality.h"
#include "morgagni/ct/test_volumes.h"

namespace mor {
namespace {

constexpr double kHalfHu = -480.0;

TriangleMesh surface_of(const std::function<double(const Eigen::Vector3d&)>& depth_mm,
                        int side = 80) {
  const auto volume = make_volume(side, 1.0, depth_mm);
  return internal::marching_cubes(volume, internal::threshold(volume, kHalfHu, 3071.0), kHalfHu);
}

TriangleMesh sphere() {
  return surface_of([](const auto& place) { return 30.0 - place.norm(); });
}

TriangleMesh torus() {
  return surface_of([](const auto& place) {
    return 8.0 - std::hypot(std::hypot(place.x(), place.y()) - 25.0, place.z());
  });
}

TriangleMesh box() {
  return surface_of([](const auto& place) { return 25.25 - place.cwiseAbs().maxCoeff(); });
}

void expect_sound(const TriangleMesh& mesh) {
  const auto topology = mesh_topology(mesh);
  EXPECT_EQ(topology.num_non_manifold_edges, 0);
  EXPECT_EQ(topology.num_degenerate, 0);
  EXPECT_EQ(topology.num_folded_edges, 0);
  EXPECT_EQ(topology.num_unused_vertices, 0);
  EXPECT_TRUE(internal::non_manifold_vertices(mesh.triangles, mesh.vertices.size()).empty());
  EXPECT_EQ(mesh.normals.size(), mesh.vertices.size());
}

int euler_characteristic(const TriangleMesh& mesh) {
  // Closed: three half-edges a triangle, two an edge.
  return static_cast<int>(mesh.vertices.size()) - static_cast<int>(mesh.triangles.size()) / 2;
}

TEST(Acvd, RemeshesASphereEvenlyAndClosed) {
  const auto full = sphere();
  const auto mesh = remesh_acvd(full, {.num_vertices = 500, .sub_sampling = 30}, {});
  ASSERT_TRUE(mesh);
  expect_sound(*mesh);
  const auto topology = mesh_topology(*mesh);
  EXPECT_EQ(mesh->vertices.size(), 500U);
  EXPECT_EQ(topology.num_open_edges, 0);
  EXPECT_EQ(euler_characteristic(*mesh), 2);
  EXPECT_GE(topology.valence_5_to_7, 0.97);
  EXPECT_NEAR(
      enclosed_volume_mm3(*mesh), enclosed_volume_mm3(full), 0.01 * enclosed_volume_mm3(full));
  for (std::size_t i = 0; i < mesh->vertices.size(); ++i)
    EXPECT_GT(mesh->normals[i].dot(mesh->vertices[i].normalized()), 0.95F) << "points outwards";
}

TEST(Acvd, KeepsTheHoleOfATorus) {
  const auto mesh = remesh_acvd(torus(), {.num_vertices = 600, .sub_sampling = 30}, {});
  ASSERT_TRUE(mesh);
  expect_sound(*mesh);
  EXPECT_EQ(mesh_topology(*mesh).num_open_edges, 0);
  EXPECT_EQ(euler_characteristic(*mesh), 0);
}

TEST(Acvd, KeepsTheEdgesOfABox) {
  const auto full = box();
  const auto mesh = remesh_acvd(full, {.num_vertices = 600, .sub_sampling = 30}, {});
  ASSERT_TRUE(mesh);
  expect_sound(*mesh);
  EXPECT_EQ(euler_characteristic(*mesh), 2);
  // Clusters' middles alone would round the edges off by 0.7 mm and the corners by more.
  float farthest = 0.0F;
  for (const auto& vertex : mesh->vertices) farthest = std::max(farthest, vertex.norm());
  EXPECT_GT(farthest, 25.25F * std::numbers::sqrt3_v<float> - 1.5F);
  const auto distance = surface_distance(full, *mesh, 20000);
  EXPECT_LT(distance.mean_mm, 0.1);
  EXPECT_LT(distance.p99_mm, 0.8);
}

TEST(Acvd, KeepsAnOpenBorderOpenAndInPlace) {
  const auto full =
      surface_of([](const auto& place) { return 12.0 - std::hypot(place.x(), place.y()); }, 40);
  const auto mesh = remesh_acvd(full, {.num_vertices = 300, .sub_sampling = 10}, {});
  ASSERT_TRUE(mesh);
  expect_sound(*mesh);
  EXPECT_GT(mesh_topology(*mesh).num_open_edges, 0);
  EXPECT_EQ(mesh_topology(*mesh).num_components, 1);
  const auto before = full.bounds();
  const auto after = mesh->bounds();
  EXPECT_NEAR(after.min().z(), before.min().z(), 0.1F);
  EXPECT_NEAR(after.max().z(), before.max().z(), 0.1F);
  EXPECT_LT(surface_distance(full, *mesh, 20000).p99_mm, 0.8);
}

TEST(Acvd, SubSamplingEvensTheTrianglesOut) {
  const auto full = surface_of([](const auto& place) { return 15.0 - place.norm(); }, 40);
  const auto coarse = remesh_acvd(full, {.num_vertices = 1500, .sub_sampling = 1}, {});
  const auto fine = remesh_acvd(full, {.num_vertices = 1500, .sub_sampling = 60}, {});
  ASSERT_TRUE(coarse);
  ASSERT_TRUE(fine);
  EXPECT_GT(mesh_topology(*fine).mean_min_angle_rad,
            mesh_topology(*coarse).mean_min_angle_rad + 0.05);
  EXPECT_GT(mesh_topology(*fine).valence_5_to_7, mesh_topology(*coarse).valence_5_to_7);
}

TEST(Acvd, GradationPutsVerticesWhereTheSurfaceBends) {
  // A long capsule: flat along its side, bent at its ends.
  const auto full = surface_of([](const auto& place) {
    const double along = std::clamp(place.z(), -25.0, 25.0);
    return 10.0 - (place - Eigen::Vector3d(0, 0, along)).norm();
  });
  const auto share_at_ends = [&](double gradation) {
    const auto mesh =
        remesh_acvd(full, {.num_vertices = 400, .sub_sampling = 20, .gradation = gradation}, {});
    std::size_t count = 0;
    for (const auto& vertex : mesh->vertices) count += std::abs(vertex.z()) > 25.0F ? 1 : 0;
    return static_cast<double>(count) / static_cast<double>(mesh->vertices.size());
  };
  EXPECT_GT(share_at_ends(2.0), share_at_ends(0.0) + 0.05);
}

TEST(Acvd, GivesTheSameMeshTwice) {
  const auto full = torus();
  const auto one = remesh_acvd(full, {.num_vertices = 300, .sub_sampling = 20}, {});
  const auto two = remesh_acvd(full, {.num_vertices = 300, .sub_sampling = 20}, {});
  ASSERT_TRUE(one);
  ASSERT_TRUE(two);
  EXPECT_EQ(one->triangles, two->triangles);
  EXPECT_EQ(one->vertices, two->vertices);
}

TEST(Acvd, RefusesBadOptionsInOneSentence) {
  const auto full = sphere();
  const auto message = [&](const AcvdOptions& options) {
    const auto mesh = remesh_acvd(full, options, {});
    return mesh ? std::string() : mesh.error().message;
  };
  EXPECT_THAT(message({.num_vertices = 3}), testing::HasSubstr("at least 4, got 3"));
  EXPECT_THAT(message({.num_vertices = 1000000}), testing::HasSubstr("fewer than the 1000000"));
  EXPECT_THAT(message({.num_vertices = 100, .sub_sampling = 0}), testing::HasSubstr("got 0"));
  EXPECT_THAT(message({.num_vertices = 100, .gradation = -1.0}), testing::HasSubstr("gradation"));
}

}  // namespace
}  // namespace mor
