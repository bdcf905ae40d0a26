// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// Things laid against the body of a real CT: how far the skin is from where it is without them.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iostream>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include "morgagni/ct/internal/body_mask.h"
#include "morgagni/ct/internal/components.h"
#include "morgagni/ct/internal/marching_cubes.h"
#include "morgagni/ct/internal/triangle_grid.h"
#include "morgagni/ct/volume_import.h"

namespace mor {
namespace {

using internal::BitMask;

constexpr double kThresholdHu = -300.0;

/// What is laid against a body.
struct Thing {
  std::string name;
  double hu = 0.0;
  double noise_hu = 0.0;
  std::function<bool(const Eigen::Vector3d& place)> is_at;  ///< LPS, mm; beside the body.
};

BitMask grown(BitMask mask, double distance_mm, const Eigen::Vector3d& spacing_mm) {
  constexpr double kStepMm = 6.0;
  for (; distance_mm > 0.0; distance_mm -= kStepMm)
    mask = dilated(mask, std::min(distance_mm, kStepMm), spacing_mm);
  return mask;
}

class RealCovers : public testing::Test {
 protected:
  void SetUp() override {
    auto head = import_volume(
        std::filesystem::path(MORGAGNI_DATA_DIR) / "ct_head_invesalius/promed_ct_0051.nii.gz",
        {},
        {});
    if (!head) GTEST_SKIP() << head.error().message;
    const auto found = internal::body_mask(*head, {}, {}).value();
    // The head alone: its own headrest is not part of the test.
    alone_ = *head;
    const BitMask near = dilated(found.body, 2.5, head->spacing_mm);
    for_each([&](int x, int y, int z) {
      if (!near.test(x, y, z)) alone_.hu[alone_.index(x, y, z)] = -1000;
    });
    body_ = internal::body_mask(alone_, {}, {}).value().body;
    const internal::Components parts(body_);
    const auto& box = parts.parts()[parts.largest()];
    bounds_ = Eigen::AlignedBox3d();
    for (const double x : {box.low_x, box.high_x})
      for (const double y : {box.low_y, box.high_y})
        for (const double z : {box.low_z, box.high_z}) bounds_.extend(place_of({x, y, z}));
  }

  template <class Visit>
  void for_each(const Visit& visit) const {
    for (int z = 0; z < alone_.size[2]; ++z)
      for (int y = 0; y < alone_.size[1]; ++y)
        for (int x = 0; x < alone_.size[0]; ++x) visit(x, y, z);
  }
  [[nodiscard]] bool is_in(const BitMask& mask, const Eigen::Vector3d& place) const {
    const Eigen::Vector3d voxel =
        (alone_.ct_from_grid.inverse() * place).cwiseQuotient(alone_.spacing_mm);
    const Eigen::Vector3i at = voxel.array().round().cast<int>();
    return at.minCoeff() >= 0 && at.x() < alone_.size[0] && at.y() < alone_.size[1] &&
           at.z() < alone_.size[2] && mask.test(at.x(), at.y(), at.z());
  }
  [[nodiscard]] Eigen::Vector3d place_of(const Eigen::Vector3d& voxel) const {
    return alone_.ct_from_grid * voxel.cwiseProduct(alone_.spacing_mm);
  }

  /// Air beside the body becomes the thing; voxels that are partly air partly.
  [[nodiscard]] Volume with(const Thing& thing) const {
    const BitMask deep = eroded(body_, 2.5, alone_.spacing_mm);
    std::mt19937 random(1);
    std::normal_distribution<double> noise(0.0, thing.noise_hu);
    Volume covered = alone_;
    for_each([&](int x, int y, int z) {
      if (deep.test(x, y, z) || !thing.is_at(place_of(Eigen::Vector3d(x, y, z)))) return;
      auto& hu = covered.hu[covered.index(x, y, z)];
      const double air = std::clamp((40.0 - hu) / 1040.0, 0.0, 1.0);
      hu = static_cast<std::int16_t>(std::lround(hu + air * (1000.0 + thing.hu + noise(random))));
    });
    return covered;
  }

  struct Off {
    double p95_mm = 0.0;
    double p99_mm = 0.0;
    double worst_mm = 0.0;
  };
  /// From the skin of one to that of the other, near the thing.
  static Off distances(const TriangleMesh& from, const TriangleMesh& to, const Thing& thing) {
    const internal::TriangleGrid grid(to);
    std::vector<double> all;
    std::vector<Eigen::Vector3f> near;
    for (const auto& vertex : from.vertices) {
      bool is_near = false;
      for (const double dx : {-6.0, 0.0, 6.0})
        for (const double dy : {-6.0, 0.0, 6.0})
          is_near = is_near || thing.is_at(vertex.cast<double>() + Eigen::Vector3d(dx, dy, 0.0));
      if (is_near) near.push_back(vertex);
    }
    const std::size_t step = std::max<std::size_t>(1, near.size() / 4000);
    for (std::size_t i = 0; i < near.size(); i += step) all.push_back(grid.distance_mm(near[i]));
    std::sort(all.begin(), all.end());
    if (all.size() < 100) return {1e9, 1e9, 1e9};
    return {all[all.size() * 95 / 100], all[all.size() * 99 / 100], all.back()};
  }

  void measure(const Thing& thing) {
    const Volume covered = with(thing);
    const auto found = internal::body_mask(covered, {}, {});
    ASSERT_TRUE(found) << found.error().message;
    const auto truth = internal::marching_cubes(alone_, body_, kThresholdHu);
    const auto skin = internal::marching_cubes(covered, found->body, kThresholdHu);
    lost_ = distances(truth, skin, thing);
    gained_ = distances(skin, truth, thing);
    std::cout << thing.name << ": skin lost p95 " << lost_.p95_mm << " p99 " << lost_.p99_mm
              << " max " << lost_.worst_mm << " mm; gained p95 " << gained_.p95_mm << " p99 "
              << gained_.p99_mm << " max " << gained_.worst_mm << " mm\n";
  }

  Volume alone_;
  BitMask body_;
  Eigen::AlignedBox3d bounds_;
  Off lost_;
  Off gained_;
};

/// Silicone under the back of the head, as thick as a neck.
TEST_F(RealCovers, ACushionGoes) {
  const Eigen::Vector3d middle = bounds_.center();
  const double back_mm = bounds_.max().y();
  measure({"silicone under the head", 180.0, 15.0, [&](const Eigen::Vector3d& place) {
             const Eigen::Vector3d from = place - middle;
             return std::abs(from.x()) < 80.0 && std::abs(place.y() - back_mm) < 25.0 &&
                    std::abs(from.z()) < 60.0;
           }});
  EXPECT_LT(lost_.p99_mm, 1.0);
  EXPECT_LT(gained_.p99_mm, 1.0);
  EXPECT_LT(lost_.worst_mm, 2.0);
  EXPECT_LT(gained_.worst_mm, 3.0);
}

/// Folded cloth as thick as an arm over half of the face.
TEST_F(RealCovers, AFoldedBlanketGoes) {
  const BitMask near = grown(body_, 25.0, alone_.spacing_mm);
  const Eigen::Vector3d middle = bounds_.center();
  for (const double hu : {-400.0, -250.0}) {
    measure({fmt::format("blanket of {} HU", hu), hu, 40.0, [&](const Eigen::Vector3d& place) {
               return place.z() < middle.z() && place.x() > middle.x() && is_in(near, place);
             }});
    EXPECT_LT(lost_.p95_mm, 1.5);
    EXPECT_LT(gained_.p95_mm, 1.5);
    EXPECT_LT(gained_.worst_mm, 4.0);
  }
}

TEST_F(RealCovers, APlasterCastGoes) {
  const BitMask near = grown(body_, 6.0, alone_.spacing_mm);
  const Eigen::Vector3d middle = bounds_.center();
  measure({"plaster around the head", 500.0, 80.0, [&](const Eigen::Vector3d& place) {
             return std::abs(place.z() - middle.z() - 20.0) < 30.0 && is_in(near, place);
           }});
  EXPECT_LT(lost_.p95_mm, 1.0);
  EXPECT_LT(gained_.p95_mm, 1.0);
}

/// A headrest's shell of 3 mm, at a slant, that presses the ear flat where it lies against it.
TEST_F(RealCovers, AnEarPressedFlatStays) {
  constexpr double kPressedMm = 2.0;
  const Eigen::Vector3d outwards = Eigen::Vector3d(1.0, 0.15, 0.075).normalized();
  const double ear_mm = bounds_.max().x();
  double farthest_mm = -1e9;
  for_each([&](int x, int y, int z) {
    const Eigen::Vector3d place = place_of(Eigen::Vector3d(x, y, z));
    if (body_.test(x, y, z) && place.x() > ear_mm - 25.0)
      farthest_mm = std::max(farthest_mm, outwards.dot(place));
  });
  const auto beyond_mm = [&](const Eigen::Vector3d& place) {
    return outwards.dot(place) - (farthest_mm - kPressedMm);
  };
  for_each([&](int x, int y, int z) {
    auto& hu = alone_.hu[alone_.index(x, y, z)];
    const double share = std::clamp(
        beyond_mm(place_of(Eigen::Vector3d(x, y, z))) / alone_.spacing_mm.x() + 0.5, 0.0, 1.0);
    hu = static_cast<std::int16_t>(std::lround((1.0 - share) * hu - 1000.0 * share));
  });
  body_ = internal::body_mask(alone_, {}, {}).value().body;
  measure({"shell against an ear", 100.0, 10.0, [&](const Eigen::Vector3d& place) {
             return beyond_mm(place) > 0.0 && beyond_mm(place) < 3.0 &&
                    place.y() > bounds_.min().y() + 40.0;
           }});
  EXPECT_LT(lost_.p99_mm, 1.0);
  EXPECT_LT(gained_.p99_mm, 1.0);
  EXPECT_LT(lost_.worst_mm, 2.0);
  EXPECT_LT(gained_.worst_mm, 2.0);
}

}  // namespace
}  // namespace mor
