// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/target_sampling.h"

#include <cmath>
#include <filesystem>
#include <numbers>

#include <gmock/gmock.h>
#include <unistd.h>

#include "morgagni/core/files.h"

namespace mor {
namespace {

/// An ellipsoid of 200 x 140 x 300 mm about (10, 20, 30).
TriangleMesh body() {
  TriangleMesh mesh;
  constexpr unsigned kRings = 60;
  constexpr unsigned kColumns = 120;
  for (unsigned ring = 0; ring <= kRings; ++ring) {
    for (unsigned column = 0; column < kColumns; ++column) {
      const double polar = std::numbers::pi * ring / kRings;
      const double azimuth = 2.0 * std::numbers::pi * column / kColumns;
      const Eigen::Vector3d unit(std::sin(polar) * std::cos(azimuth),
                                 std::sin(polar) * std::sin(azimuth),
                                 std::cos(polar));
      mesh.vertices.push_back(
          (Eigen::Vector3d(10, 20, 30) + unit.cwiseProduct(Eigen::Vector3d(100, 70, 150)))
              .cast<float>());
    }
  }
  for (unsigned ring = 0; ring < kRings; ++ring) {
    for (unsigned column = 0; column < kColumns; ++column) {
      const unsigned next = (column + 1) % kColumns;
      const unsigned a = ring * kColumns + column;
      const unsigned b = ring * kColumns + next;
      mesh.triangles.push_back({a, a + kColumns, b});
      mesh.triangles.push_back({b, a + kColumns, b + kColumns});
    }
  }
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

double outside_by(const Eigen::Vector3d& at) {
  return (at - Eigen::Vector3d(10, 20, 30)).cwiseQuotient(Eigen::Vector3d(100, 70, 150)).norm();
}

TEST(SkinTargets, LieOnTheUpperSkinFarFromEachOther) {
  const auto targets = sample_skin_targets(body(), 10, 3);
  ASSERT_TRUE(targets) << targets.error().message;
  ASSERT_EQ(targets->size(), 10U);
  for (std::size_t i = 0; i < targets->size(); ++i) {
    EXPECT_TRUE((*targets)[i].on_skin);
    EXPECT_NEAR(outside_by((*targets)[i].ct), 1.0, 1e-4);
    EXPECT_LT((*targets)[i].ct.y(), 20.0);
    for (std::size_t k = 0; k < i; ++k) {
      EXPECT_GT(((*targets)[i].ct - (*targets)[k].ct).norm(), 50.0);
    }
  }
  EXPECT_EQ((*targets)[9].name, "F10");
}

TEST(InternalTargets, LieInsideAndDifferBySeed) {
  const auto targets = sample_internal_targets(body(), 16, 3);
  ASSERT_TRUE(targets) << targets.error().message;
  ASSERT_EQ(targets->size(), 16U);
  for (const auto& target : *targets) {
    EXPECT_FALSE(target.on_skin);
    EXPECT_LT(outside_by(target.ct), 0.99);
  }
  EXPECT_EQ(sample_internal_targets(body(), 16, 3).value().front().ct, targets->front().ct);
  EXPECT_NE(sample_internal_targets(body(), 16, 4).value().front().ct, targets->front().ct);
}

TEST(Targets, AreRefusedWhereThereIsNoRoom) {
  TriangleMesh sheet;
  sheet.vertices = {{0, 0, 0}, {0, 0, 50}, {50, 0, 0}};
  sheet.triangles = {{0, 1, 2}};
  sheet.normals = {{0, -1, 0}, {0, -1, 0}, {0, -1, 0}};
  EXPECT_THAT(sample_skin_targets(sheet, 4, 1).error().message,
              testing::HasSubstr("room for 3 skin targets, got 4"));
  EXPECT_THAT(sample_internal_targets(sheet, 4, 1).error().message,
              testing::HasSubstr("internal targets"));
}

TEST(TargetsCsv, IsReadBackAsItWas) {
  auto targets = sample_skin_targets(body(), 3, 1).value();
  const auto inside = sample_internal_targets(body(), 2, 1).value();
  targets.insert(targets.end(), inside.begin(), inside.end());
  const auto path = std::filesystem::temp_directory_path() /
                    ("morgagni-targets-" + std::to_string(::getpid()) + ".csv");
  ASSERT_TRUE(write_file(path, targets_csv(targets)));
  const auto read = read_targets(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ((*read)[i].name, targets[i].name);
    EXPECT_EQ((*read)[i].on_skin, targets[i].on_skin);
    EXPECT_LT(((*read)[i].ct - targets[i].ct).norm(), 0.002);
  }
}

}  // namespace
}  // namespace mor
