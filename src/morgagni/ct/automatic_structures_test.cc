// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/automatic_structures.h"

#include <cmath>

#include <gmock/gmock.h>

#include "morgagni/ct/mesh_quality.h"
#include "morgagni/ct/test_volumes.h"

namespace mor {
namespace {

using testing::HasSubstr;

/// A ball of tissue of 80 mm with air around, cut by the volume's end; beside it nothing. Inside: a
/// lung that reaches the cut, a bubble of gas, a bullet.
struct Inside {
  double lung_hu = -850.0;
  double bubble_hu = -1000.0;
  double metal_hu = 3071.0;
};

constexpr int kSide = 90;
constexpr double kSpacingMm = 2.0;

Volume body_with(const Inside& inside) {
  auto volume =
      make_volume(kSide, kSpacingMm, [](const Eigen::Vector3d& p) { return 80.0 - p.norm(); });
  const auto put = [&](const Eigen::Vector3d& center, double radius_mm, double hu) {
    for (int z = 0; z < kSide; ++z) {
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          const Eigen::Vector3d place =
              volume.ct_from_grid * (Eigen::Vector3d(x, y, z) * kSpacingMm);
          if ((place - center).norm() < radius_mm)
            volume.hu[volume.index(x, y, z)] = static_cast<std::int16_t>(hu);
          if (place.norm() > 84.0) volume.hu[volume.index(x, y, z)] = kOutsideHu;
        }
      }
    }
  };
  put({-30, 0, 0}, 35.0, inside.lung_hu);
  put({40, 0, 0}, 10.0, inside.bubble_hu);
  put({10, 50, 0}, 4.0, inside.metal_hu);
  return volume;
}

std::vector<StructureSurface> structures_of(const Volume& body) {
  auto found = extract_automatic_structures(body, {}, {});
  EXPECT_TRUE(found) << found.error().message;
  return found ? std::move(*found) : std::vector<StructureSurface>();
}

TEST(AutomaticStructures, FindsLungsGasAndMetalWhereTheyAre) {
  const auto found = structures_of(body_with({}));
  ASSERT_EQ(found.size(), 3U);
  const auto expect_ball = [](const StructureSurface& surface,
                              const std::string& name,
                              const Eigen::Vector3f& center,
                              double radius_mm) {
    EXPECT_EQ(surface.name, name);
    EXPECT_LT((surface.mesh.bounds().center() - center).norm(), 1.0F) << name;
    EXPECT_NEAR(surface.mesh.bounds().sizes().x(), 2.0 * radius_mm, 3.0) << name;
    EXPECT_EQ(mesh_topology(surface.mesh).num_open_edges, 0) << name;
    EXPECT_GT(enclosed_volume_mm3(surface.mesh), 0.0) << name;
    EXPECT_EQ(surface.mesh.normals.size(), surface.mesh.vertices.size()) << name;
  };
  expect_ball(found[0], "lungs", {-30, 0, 0}, 35.0);
  expect_ball(found[1], "gas", {40, 0, 0}, 10.0);
  expect_ball(found[2], "metal", {10, 50, 0}, 4.0);
}

TEST(AutomaticStructures, TakesALargeHollowWithoutTissueForGas) {
  const auto found = structures_of(body_with({.lung_hu = -1000.0}));
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].name, "gas");
  EXPECT_LT(found[0].mesh.bounds().min().x(), -60.0F);
}

TEST(AutomaticStructures, LeavesOutWhatIsNotThere) {
  const auto found =
      structures_of(body_with({.lung_hu = kTissueHu, .bubble_hu = kTissueHu, .metal_hu = 1500.0}));
  EXPECT_TRUE(found.empty()) << "not the air around the body, no bone";
}

TEST(AutomaticStructures, TellsAFoldOfTheSkinFromAnAirway) {
  const auto with_slit = [](double half_width_mm) {
    auto body = body_with({.lung_hu = kTissueHu, .bubble_hu = kTissueHu, .metal_hu = 1500.0});
    for (int z = 0; z < kSide; ++z) {
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          const Eigen::Vector3d place = body.ct_from_grid * (Eigen::Vector3d(x, y, z) * kSpacingMm);
          auto& hu = body.hu[body.index(x, y, z)];
          if (hu != kOutsideHu && std::abs(place.x()) < half_width_mm && place.y() < -40.0)
            hu = kAirHu;
        }
      }
    }
    return body;
  };
  EXPECT_TRUE(structures_of(with_slit(2.5)).empty());
  const auto found = structures_of(with_slit(8.0));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].name, "gas");
  EXPECT_NEAR(found[0].mesh.bounds().max().y(), -40.0F, 3.0F);
}

TEST(AutomaticStructures, ClosesLungsThatTheScanCuts) {
  auto body = body_with({});
  const int first = 38;
  body.hu.erase(body.hu.begin(),
                body.hu.begin() + static_cast<std::ptrdiff_t>(body.index(0, 0, first)));
  body.size[2] -= first;
  body.ct_from_grid.translation().z() += first * kSpacingMm;
  const auto found = structures_of(body);
  ASSERT_EQ(found[0].name, "lungs");
  EXPECT_EQ(mesh_topology(found[0].mesh).num_open_edges, 0);
  EXPECT_NEAR(found[0].mesh.bounds().min().z(), body.ct_from_grid.translation().z(), kSpacingMm);
}

TEST(AutomaticStructures, RefusesBadOptions) {
  const auto found = extract_automatic_structures(body_with({}), {.gas_hu = 10.0}, {});
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message, HasSubstr("gas_hu must be in (-1024, 0), got 10"));
}

}  // namespace
}  // namespace mor
