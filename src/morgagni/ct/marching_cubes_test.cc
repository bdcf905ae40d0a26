// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/marching_cubes.h"

#include <algorithm>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "morgagni/ct/internal/components.h"
#include "morgagni/ct/internal/cube_cases.h"
#include "morgagni/ct/mesh_quality.h"
#include "morgagni/ct/test_volumes.h"

namespace mor {
namespace {

using internal::BitMask;

constexpr double kHalfHu = -480.0;  // Half way between air and tissue: the true surface.

TEST(MarchingCubes, PutsASphereWhereItIs) {
  const double radius_mm = 20.0;
  const auto volume =
      make_volume(60, 1.0, [&](const auto& place) { return radius_mm - place.norm(); });
  const auto mesh =
      internal::marching_cubes(volume, internal::threshold(volume, kHalfHu, 3071.0), kHalfHu);
  for (const auto& vertex : mesh.vertices) EXPECT_NEAR(vertex.norm(), radius_mm, 0.1);
  const double sphere_mm3 = 4.0 / 3.0 * std::numbers::pi * std::pow(radius_mm, 3);
  EXPECT_NEAR(enclosed_volume_mm3(mesh), sphere_mm3, 0.01 * sphere_mm3);
  const auto topology = mesh_topology(mesh);
  EXPECT_EQ(topology.num_open_edges, 0);
  EXPECT_EQ(topology.num_components, 1);
}

TEST(MarchingCubes, IsWatertightForAnyMask) {
  // Noise has every ambiguous case; an empty rim keeps the surface off the volume's faces.
  std::mt19937 random(3);
  for (int round = 0; round < 20; ++round) {
    auto volume = make_volume(20, 1.0, [](const auto&) { return -10.0; });
    BitMask mask(volume.size);
    for (int z = 1; z < 19; ++z)
      for (int y = 1; y < 19; ++y)
        for (int x = 1; x < 19; ++x)
          if (random() % 2 == 0) mask.set_run(y, z, x, x + 1);
    const auto topology = mesh_topology(internal::marching_cubes(volume, mask, kHalfHu));
    EXPECT_EQ(topology.num_open_edges, 0);
    EXPECT_EQ(topology.num_non_manifold_edges, 0);
    EXPECT_EQ(topology.num_degenerate, 0);
  }
}

TEST(MarchingCubes, StaysOpenWhereTheVolumeEnds) {
  const auto volume = make_volume(
      30, 1.0, [](const auto& place) { return 8.0 - std::hypot(place.x(), place.y()); });
  const auto mesh =
      internal::marching_cubes(volume, internal::threshold(volume, kHalfHu, 3071.0), kHalfHu);
  const auto topology = mesh_topology(mesh);
  EXPECT_GT(topology.num_open_edges, 0);
  for (const auto& vertex : mesh.vertices)
    EXPECT_NEAR(std::hypot(vertex.x(), vertex.y()), 8.0, 0.15) << "no cap across the end";
}

TEST(BitMask, DilatesByABallInMillimetres) {
  BitMask point({70, 31, 31});
  point.set_run(15, 15, 63, 64);
  const Eigen::Vector3d spacing_mm(0.5, 1.0, 2.0);
  const auto ball = internal::dilated(point, 4.0, spacing_mm);
  std::size_t num_expected = 0;
  for (int z = 0; z < 31; ++z) {
    for (int y = 0; y < 31; ++y) {
      for (int x = 0; x < 70; ++x) {
        const Eigen::Vector3d offset =
            Eigen::Vector3d(x - 63, y - 15, z - 15).cwiseProduct(spacing_mm);
        const bool expected = offset.norm() <= 4.0;
        num_expected += expected ? 1 : 0;
        EXPECT_EQ(ball.test(x, y, z), expected) << x << " " << y << " " << z;
      }
    }
  }
  EXPECT_EQ(ball.count(), num_expected);
}

TEST(BitMask, ClosingFillsGapsAndKeepsTheRest) {
  BitMask mask({100, 40, 40});
  for (int z = 10; z < 30; ++z)
    for (int y = 10; y < 30; ++y) {
      mask.set_run(y, z, 20, 49);
      mask.set_run(y, z, 51, 80);
    }
  const auto closed = internal::closed(mask, 3.0, Eigen::Vector3d::Ones());
  EXPECT_TRUE(closed.test(49, 20, 20));
  EXPECT_TRUE(closed.test(50, 20, 20));
  EXPECT_FALSE(closed.test(19, 20, 20));
  EXPECT_FALSE(closed.test(80, 20, 20));
  EXPECT_EQ(internal::closed(mask, 0.0, Eigen::Vector3d::Ones()), mask);
}

TEST(BitMask, ErosionDoesNotEatFromTheVolumesFaces) {
  BitMask full({65, 8, 8});
  full.invert();
  EXPECT_EQ(full.count(), 65U * 64U);
  EXPECT_EQ(internal::eroded(full, 3.0, Eigen::Vector3d::Ones()), full);
}

TEST(Components, AgreeWithAFloodFill) {
  std::mt19937 random(5);
  BitMask mask({130, 12, 9});
  for (int z = 0; z < 9; ++z)
    for (int y = 0; y < 12; ++y)
      for (int x = 0; x < 130; ++x)
        if (random() % 10 < 3) mask.set_run(y, z, x, x + 1);
  const internal::Components parts(mask);

  std::vector<std::size_t> sizes;
  BitMask seen(mask.size());
  for (int start = 0; start < 130 * 12 * 9; ++start) {
    std::vector<std::array<int, 3>> stack = {{start % 130, start / 130 % 12, start / 1560}};
    std::size_t size = 0;
    while (!stack.empty()) {
      const auto [x, y, z] = stack.back();
      stack.pop_back();
      if (x < 0 || y < 0 || z < 0 || x >= 130 || y >= 12 || z >= 9) continue;
      if (!mask.test(x, y, z) || seen.test(x, y, z)) continue;
      seen.set_run(y, z, x, x + 1);
      ++size;
      for (const int step : {-1, 1}) {
        stack.push_back({x + step, y, z});
        stack.push_back({x, y + step, z});
        stack.push_back({x, y, z + step});
      }
    }
    if (size > 0) sizes.push_back(size);
  }
  std::vector<std::size_t> found;
  for (const auto& part : parts.parts()) found.push_back(part.num_voxels);
  std::sort(found.begin(), found.end());
  std::sort(sizes.begin(), sizes.end());
  EXPECT_EQ(found, sizes);
  EXPECT_EQ(parts.select([](std::size_t) { return true; }), mask);
  EXPECT_EQ(parts.overlap(mask)[parts.largest()], found.back());
}

}  // namespace
}  // namespace mor
