// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/tubes.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/ct/surfaces.h"
#include "morgagni/ct/test_volumes.h"

namespace mor {
namespace {

constexpr double kTrunkMm = 30.0;

double trunk_mm(const Eigen::Vector3d& place) {
  return kTrunkMm - std::hypot(place.x(), place.y());
}

/// Along z, where it lies against the trunk.
double tube_mm(const Eigen::Vector3d& place, double radius_mm, double wall_mm) {
  const double from_mm = std::hypot(place.x() - (kTrunkMm + radius_mm), place.y());
  return std::min(radius_mm - from_mm, from_mm - (radius_mm - wall_mm));
}

double from_mm(const Eigen::Vector3d& place, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double share = std::clamp((place - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (place - a - share * (b - a)).norm();
}

/// About its middle, along an arc: an ear's rim, a finger.
double bow_mm(const Eigen::Vector3d& place, double bend_mm, double half_turn_rad, double thick_mm) {
  const Eigen::Vector3d from = place - Eigen::Vector3d(-kTrunkMm - bend_mm, 0, 0);
  const double turn = std::clamp(std::atan2(from.z(), -from.x()), -half_turn_rad, half_turn_rad);
  const Eigen::Vector3d nearest(-bend_mm * std::cos(turn), 0.0, bend_mm * std::sin(turn));
  return thick_mm - (from - nearest).norm();
}

std::vector<internal::Tube> tubes_of(const Volume& volume) {
  const auto solid = internal::threshold(volume, internal::SkinProfile::kEdgeHu, 32767.0);
  return internal::find_tubes(volume, {volume, solid}, internal::BitMask(volume.size));
}

TEST(Tubes, AreFoundWhereTheyLieAgainstTheSkin) {
  for (const double radius_mm : {2.5, 4.0, 6.5}) {
    const auto tubes = tubes_of(make_volume(120, 1.0, [&](const Eigen::Vector3d& place) {
      return std::max(trunk_mm(place), tube_mm(place, radius_mm, 1.5));
    }));
    ASSERT_EQ(tubes.size(), 1U) << radius_mm;
    EXPECT_NEAR(tubes.front().radius_mm, radius_mm, 0.4);
    EXPECT_GT(tubes.front().axis_mm.size(), 55U) << "2 mm apart, from end to end";
  }
}

/// One leaves it through a side, at a slant: its axis goes on beyond, half of it does not.
TEST(Tubes, EndWhereTheCtDoes) {
  constexpr double kEdgeMm = 59.5;
  const auto tubes = tubes_of(make_volume(120, 1.0, [](const Eigen::Vector3d& place) {
    const double slanted_mm = place.x() - 55.0 - 0.1 * place.z();
    const double from_mm = std::hypot(slanted_mm, place.y());
    return std::max(trunk_mm(place), std::min(5.0 - from_mm, from_mm - 3.0));
  }));
  ASSERT_EQ(tubes.size(), 1U);
  for (const auto& mm : tubes.front().axis_mm) {
    EXPECT_GE(mm.minCoeff(), 0.0);
    EXPECT_LE(mm.maxCoeff(), 2.0 * kEdgeMm);
  }
}

TEST(Tubes, AreNoRimsOfEarsAndNoFingers) {
  const auto tubes = tubes_of(make_volume(120, 1.0, [&](const Eigen::Vector3d& place) {
    const double rim = bow_mm(place, 18.0, 2.8, 2.5);
    const Eigen::Vector3d from = place - Eigen::Vector3d(kTrunkMm, 0, 0);
    const double finger =
        6.0 - (from - std::clamp(from.x(), 0.0, 25.0) * Eigen::Vector3d::UnitX()).norm();
    return std::max({trunk_mm(place), rim, finger});
  }));
  EXPECT_TRUE(tubes.empty());
}

/// It leaves the trunk at a right angle.
TEST(Tubes, GoOnBeyondASharpBend) {
  constexpr double kRadiusMm = 4.0;
  const Eigen::Vector3d bend(kTrunkMm + kRadiusMm, 0, 25);
  const auto tubes = tubes_of(make_volume(120, 1.0, [&](const Eigen::Vector3d& place) {
    const double tube =
        std::min(from_mm(place, {bend.x(), 0, -70}, bend), from_mm(place, bend, {70, 0, 25}));
    return std::max(trunk_mm(place), std::min(kRadiusMm - tube, tube - 2.5));
  }));
  double farthest_mm = 0.0;
  for (const auto& tube : tubes)
    for (const auto& mm : tube.axis_mm) farthest_mm = std::max(farthest_mm, mm.x());
  EXPECT_GT(farthest_mm, 115.0) << "of 119";
}

/// As thick and as dense: an ear's rim that comes down beside a cable.
TEST(Tubes, TakeNoRimAlongThatTheyPass) {
  constexpr double kThickMm = 2.5;
  const double beside_mm = 6.0;
  const double out_mm = std::sqrt(std::pow(kTrunkMm + kThickMm, 2) - beside_mm * beside_mm);
  const auto tubes = tubes_of(make_volume(120, 1.0, [&](const Eigen::Vector3d& place) {
    const double cable = kThickMm - std::hypot(place.x() + out_mm, place.y() - beside_mm);
    return std::max({trunk_mm(place), cable, bow_mm(place, 18.0, 2.8, kThickMm)});
  }));
  ASSERT_FALSE(tubes.empty());
  for (const auto& tube : tubes)
    for (const auto& mm : tube.axis_mm) EXPECT_GT(mm.x(), 26.0) << "the rim goes on to 1";
}

/// With a tube along one side and a cable that touches the other at places.
TEST(Tubes, LeaveTheSkinWhereItIsBare) {
  const auto volume = make_volume(130, 1.0, [](const Eigen::Vector3d& place) {
    const double lifted_mm = 4.0 + 4.0 * std::sin(0.08 * place.z());
    const double cable = 2.5 - std::hypot(place.x() + kTrunkMm + 2.5 + lifted_mm, place.y());
    return std::max({trunk_mm(place), tube_mm(place, 4.5, 2.0), cable});
  });
  constexpr SkinOptions kQuick = {.num_vertices = 1500, .sub_sampling = 1};
  const auto skin = extract_skin(volume, kQuick, {});
  ASSERT_TRUE(skin) << skin.error().message;
  std::vector<double> errors_mm;
  for (const auto& vertex : skin->full.vertices)
    errors_mm.push_back(std::abs(std::hypot(vertex.x(), vertex.y()) - (kTrunkMm - 0.17)));
  std::sort(errors_mm.begin(), errors_mm.end());
  EXPECT_LT(errors_mm[errors_mm.size() / 2], 0.1);
  EXPECT_LT(errors_mm.back(), 1.0);
  EXPECT_TRUE(std::none_of(skin->preview.doubts.begin(),
                           skin->preview.doubts.end(),
                           [](auto& doubt) { return doubt.why == SkinDoubt::Why::kLayerLeft; }))
      << "a tube's wall is no layer that goes on";
}

}  // namespace
}  // namespace mor
