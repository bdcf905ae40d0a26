// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/distance_field.h"

#include <fstream>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "morgagni/core/files.h"
#include "morgagni/registration/internal/closest_point.h"
#include "morgagni/registration/testing/test_body.h"

namespace mor {
namespace {

using testing::HasSubstr;

const TriangleMesh& body() {
  static const TriangleMesh mesh = internal::bumpy_body(60, {10.0F, 20.0F, -30.0F});
  return mesh;
}

const DistanceField& field() {
  static const DistanceField built = *DistanceField::build(body());
  return built;
}

float brute_force_distance_mm(const TriangleMesh& mesh, const Eigen::Vector3f& p) {
  float best = std::numeric_limits<float>::infinity();
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto closest = internal::closest_point_on_triangle(
        p, mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
    best = std::min(best, (closest.point - p).norm());
  }
  return best;
}

std::filesystem::path scratch(const std::string& name) {
  return std::filesystem::path(testing::TempDir()) /
         fmt::format("mor_field_{}_{}", ::getpid(), name);
}

TEST(ClosestPointOnTriangle, IsTheNearestOfManySampledPoints) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> anywhere(-10.0F, 10.0F);
  const auto point = [&] {
    return Eigen::Vector3f(anywhere(random), anywhere(random), anywhere(random));
  };
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3f a = point();
    const Eigen::Vector3f b = point();
    const Eigen::Vector3f c = point();
    const Eigen::Vector3f p = point();
    const auto closest = internal::closest_point_on_triangle(p, a, b, c);
    EXPECT_NEAR(closest.weights.sum(), 1.0F, 1e-5F);
    EXPECT_GE(closest.weights.minCoeff(), -1e-6F);
    const Eigen::Vector3f same =
        closest.weights[0] * a + closest.weights[1] * b + closest.weights[2] * c;
    EXPECT_LT((same - closest.point).norm(), 1e-4F);
    for (int u = 0; u <= 20; ++u) {
      for (int v = 0; u + v <= 20; ++v) {
        const Eigen::Vector3f sample =
            a + static_cast<float>(u) / 20.0F * (b - a) + static_cast<float>(v) / 20.0F * (c - a);
        EXPECT_GE((sample - p).norm(), (closest.point - p).norm() - 1e-4F);
      }
    }
  }
}

TEST(DistanceField, AgreesWithBruteForceInBothBands) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> anywhere(-180.0F, 180.0F);
  int num_fine = 0;
  for (int i = 0; i < 1500; ++i) {
    const Eigen::Vector3f p = Eigen::Vector3f(10.0F, 20.0F, -30.0F) +
                              Eigen::Vector3f(anywhere(random), anywhere(random), anywhere(random));
    const float truth_mm = brute_force_distance_mm(body(), p);
    FieldSample sample;
    if (DistanceField::look_up(field().fine(), p, sample)) {
      ++num_fine;
      // One step of extrapolation over a curved, faceted surface.
      EXPECT_NEAR(std::abs(sample.distance_mm), truth_mm, 0.5F);
    } else {
      EXPECT_GT(truth_mm, field().fine().band_mm - 2.0F * field().fine().spacing_mm);
    }
    if (truth_mm < 20.0F && DistanceField::look_up(field().coarse(), p, sample)) {
      EXPECT_NEAR(std::abs(sample.distance_mm), truth_mm, 3.0F);
    }
  }
  EXPECT_GT(num_fine, 100);
}

TEST(DistanceField, IsExactToItsRoundingAtTheNodes) {
  const FieldLevel& level = field().fine();
  int num_known = 0;
  double sum_mm = 0.0;
  for (int z = 3; z < level.bricks[2] * FieldLevel::kBrickSide; z += 23) {
    for (int y = 2; y < level.bricks[1] * FieldLevel::kBrickSide; y += 17) {
      for (int x = 1; x < level.bricks[0] * FieldLevel::kBrickSide; x += 13) {
        const Eigen::Vector3f p =
            level.origin_mm + level.spacing_mm * Eigen::Vector3f(static_cast<float>(x),
                                                                 static_cast<float>(y),
                                                                 static_cast<float>(z));
        FieldSample sample;
        if (!DistanceField::look_up(level, p, sample)) continue;
        ++num_known;
        const float off_mm =
            std::abs(std::abs(sample.distance_mm) - brute_force_distance_mm(body(), p));
        sum_mm += static_cast<double>(off_mm);
        EXPECT_LT(off_mm, 0.2F);
      }
    }
  }
  ASSERT_GT(num_known, 50);
  EXPECT_LT(sum_mm / num_known, 0.01);
}

TEST(DistanceField, IsNegativeInsideAndFacesOutwards) {
  for (std::size_t i = 0; i < body().vertices.size(); i += 7) {
    const Eigen::Vector3f& normal = body().normals[i];
    FieldSample sample;
    ASSERT_TRUE(DistanceField::look_up(field().fine(), body().vertices[i] + 5.0F * normal, sample));
    EXPECT_NEAR(sample.distance_mm, 5.0F, 0.7F);
    EXPECT_GT(sample.normal.dot(normal), 0.9F);
    ASSERT_TRUE(DistanceField::look_up(field().fine(), body().vertices[i] - 5.0F * normal, sample));
    // Under a bump or dent the nearest surface need not be the vertex above.
    EXPECT_LT(sample.distance_mm, -3.0F);
    EXPECT_LT(sample.normal.norm(), 1.001F);
  }
}

TEST(DistanceField, DoesNotKnowWhatLiesBeyondAnOpenBorder) {
  TriangleMesh plate;
  for (int y = 0; y <= 20; ++y) {
    for (int x = 0; x <= 20; ++x) {
      plate.vertices.emplace_back(5.0F * static_cast<float>(x), 5.0F * static_cast<float>(y), 0.0F);
    }
  }
  for (std::uint32_t y = 0; y < 20; ++y) {
    for (std::uint32_t x = 0; x < 20; ++x) {
      const std::uint32_t a = 21 * y + x;
      plate.triangles.push_back({a, a + 1, a + 21});
      plate.triangles.push_back({a + 1, a + 22, a + 21});
    }
  }
  plate.normals = vertex_normals(plate);
  const DistanceField built = *DistanceField::build(plate);
  FieldSample sample;
  for (const auto* level : {&built.fine(), &built.coarse()}) {
    EXPECT_TRUE(DistanceField::look_up(*level, {50.0F, 50.0F, 8.0F}, sample));
    EXPECT_NEAR(sample.distance_mm, 8.0F, 0.1F);
    EXPECT_TRUE(DistanceField::look_up(*level, {50.0F, 50.0F, -8.0F}, sample));
    EXPECT_NEAR(sample.distance_mm, -8.0F, 0.1F);
    EXPECT_FALSE(DistanceField::look_up(*level, {112.0F, 50.0F, 0.0F}, sample));
    EXPECT_FALSE(DistanceField::look_up(*level, {112.0F, 112.0F, 4.0F}, sample));
  }
}

TEST(DistanceField, IsTheSameWhenBuiltTwice) {
  const DistanceField again = *DistanceField::build(body());
  EXPECT_TRUE(again.fine().nodes == field().fine().nodes);
  EXPECT_EQ(again.fine().index, field().fine().index);
  EXPECT_TRUE(again.coarse().nodes == field().coarse().nodes);
}

TEST(DistanceField, KnowsNothingFarAwayOrOfNan) {
  FieldSample sample;
  for (const auto* level : {&field().fine(), &field().coarse()}) {
    EXPECT_FALSE(DistanceField::look_up(*level, {1e9F, 0.0F, 0.0F}, sample));
    EXPECT_FALSE(DistanceField::look_up(*level, {0.0F, -1e30F, 0.0F}, sample));
    EXPECT_FALSE(DistanceField::look_up(*level, {0.0F, std::nanf(""), 0.0F}, sample));
  }
}

TEST(DistanceField, RefusesMeshesItCannotUse) {
  const auto message = [](const TriangleMesh& mesh) {
    const auto built = DistanceField::build(mesh);
    return built ? std::string() : built.error().message;
  };
  EXPECT_THAT(message({}), HasSubstr("no triangles"));
  TriangleMesh mesh = internal::bumpy_body(6, Eigen::Vector3f::Zero());
  mesh.normals.pop_back();
  EXPECT_THAT(message(mesh), HasSubstr("a normal for each"));
  mesh = internal::bumpy_body(6, Eigen::Vector3f::Zero());
  mesh.vertices[3].z() = std::nanf("");
  EXPECT_THAT(message(mesh), HasSubstr("finite"));
  mesh = internal::bumpy_body(6, Eigen::Vector3f::Zero());
  mesh.triangles[0][1] = 1000000;
  EXPECT_THAT(message(mesh), HasSubstr("does not exist"));
  mesh = internal::bumpy_body(6, Eigen::Vector3f::Zero());
  mesh.vertices[0].x() = 1e6F;
  EXPECT_THAT(message(mesh), HasSubstr("4000 mm"));
}

TEST(DistanceFieldFile, GivesBackWhatWasWritten) {
  const auto path = scratch("round_trip");
  ASSERT_TRUE(write_distance_field(path, field()));
  const auto read = read_distance_field(path);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(read->fine().nodes == field().fine().nodes);
  EXPECT_EQ(read->fine().index, field().fine().index);
  EXPECT_EQ(read->fine().bricks, field().fine().bricks);
  EXPECT_EQ(read->fine().origin_mm, field().fine().origin_mm);
  EXPECT_TRUE(read->coarse().nodes == field().coarse().nodes);
  EXPECT_EQ(read->coarse().spacing_mm, field().coarse().spacing_mm);
  std::filesystem::remove(path);
}

TEST(DistanceFieldFile, IsRefusedWhenAbsentTruncatedOrDamaged) {
  const auto path = scratch("damaged");
  EXPECT_FALSE(read_distance_field(path));
  ASSERT_TRUE(write_distance_field(path, field()));
  const auto bytes = *read_file(path, 1U << 30U);
  const auto message = [&path](const std::vector<std::byte>& content) {
    EXPECT_TRUE(write_file(path, content));
    const auto read = read_distance_field(path);
    return read ? std::string() : read.error().message;
  };
  for (const std::size_t size : {std::size_t{0}, std::size_t{7}, std::size_t{80}}) {
    EXPECT_NE(message({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)}), "");
  }
  EXPECT_THAT(message({bytes.begin(), bytes.end() - 1}), HasSubstr("truncated or damaged"));
  auto flipped = bytes;
  flipped[flipped.size() / 2] ^= std::byte{1};
  EXPECT_THAT(message(flipped), HasSubstr("truncated or damaged"));
  auto other_version = bytes;
  other_version[8] = std::byte{99};
  EXPECT_THAT(message(other_version), HasSubstr("version 99"));
  auto other_magic = bytes;
  other_magic[0] = std::byte{'X'};
  EXPECT_THAT(message(other_magic), HasSubstr("no distance field"));
  std::filesystem::remove(path);
}

TEST(DistanceFieldFile, IsRefusedWhenItsSizesLieUnderAGoodChecksum) {
  const auto path = scratch("hostile");
  ASSERT_TRUE(write_distance_field(path, field()));
  const auto bytes = *read_file(path, 1U << 30U);
  constexpr std::size_t kDigits = 64;
  constexpr std::size_t kFirstHeader = 12;
  // spacing; bricks x, y, z; stored bricks; the first brick's index.
  for (const std::size_t offset : {12U, 20U, 24U, 28U, 32U, 36U}) {
    std::vector<std::byte> content(bytes.begin(), bytes.end() - kDigits);
    for (std::size_t i = 0; i < 4; ++i) content[kFirstHeader + offset + i] = std::byte{0xff};
    for (const char digit : sha256_hex(content)) content.push_back(static_cast<std::byte>(digit));
    ASSERT_TRUE(write_file(path, content));
    const auto read = read_distance_field(path);
    ASSERT_FALSE(read) << offset;
    EXPECT_THAT(read.error().message, HasSubstr("do not agree")) << offset;
  }
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace mor
