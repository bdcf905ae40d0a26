// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/fine_registration.h"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/core/statistics.h"
#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/testing/test_body.h"

namespace mor {
namespace {

using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180.0;

/// One surface for all tests: its field takes a moment.
std::shared_ptr<const FixedSurface> body() {
  static const auto surface = internal::bumpy_surface();
  return surface;
}

std::unique_ptr<FineRegistration> make(RegistrationMethod method) {
  auto made = make_fine_registration(body(), {.method = method});
  EXPECT_TRUE(made) << made.error().message;
  return *std::move(made);
}

const Eigen::Vector3d& body_center() {
  static const Eigen::Vector3d center = body()->mesh.bounds().center().cast<double>();
  return center;
}

/// How far two poses put the body apart, mm.
double error_mm(const Eigen::Isometry3d& ct_from_depth, const Eigen::Isometry3d& truth) {
  double worst = 0.0;
  for (const double x : {-100.0, 100.0}) {
    for (const double z : {-100.0, 100.0}) {
      const Eigen::Vector3d in_depth =
          truth.inverse() * (body_center() + Eigen::Vector3d(x, -60.0, z));
      worst = std::max(worst, displacement_mm(ct_from_depth, truth, in_depth));
    }
  }
  return worst;
}

PointCloud with_noise(PointCloud cloud, float sigma_mm, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0.0F, sigma_mm);
  for (auto& point : cloud.points) point += noise(random) * point.normalized();
  return cloud;
}

class EveryMethod : public testing::TestWithParam<RegistrationMethod> {};

TEST_P(EveryMethod, RecoversAKnownPoseFromATrackedStart) {
  const auto registration = make(GetParam());
  const Eigen::Isometry3d truth = internal::camera_before_body();
  const PointCloud moving = internal::seen_by_camera(body()->mesh, truth);
  const Eigen::Isometry3d start =
      internal::motion_about(body_center(), {1.0, -0.5, 0.7}, 2.0 * kDegree, {3.0, 2.0, -3.0}) *
      truth;
  const auto result = registration->align(moving, start, StartQuality::kTracked);
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_EQ(result->status, RegistrationStatus::kConverged);
  // Point-to-point ICP ends where the fixed vertices, 3 to 7 mm apart, let it slide no further.
  EXPECT_GT(error_mm(start, truth), 6.0);
  EXPECT_LT(error_mm(result->fixed_from_moving, truth),
            GetParam() == RegistrationMethod::kField ? 0.15 : 3.0);
  EXPECT_GT(result->explained_fraction, 0.95);
  EXPECT_GT(result->num_iterations, 0);
  EXPECT_GT(result->num_pairs, static_cast<int>(moving.size()) / 2);
}

TEST_P(EveryMethod, GivesTheSameBitsTwice) {
  const Eigen::Isometry3d truth = internal::camera_before_body();
  const PointCloud moving = with_noise(internal::seen_by_camera(body()->mesh, truth), 1.5F, 7);
  const Eigen::Isometry3d start =
      internal::motion_about(body_center(), {0.0, 1.0, 0.2}, 0.1, {5.0, -5.0, 8.0}) * truth;
  const auto first = *make(GetParam())->align(moving, start, StartQuality::kRough);
  const auto second = *make(GetParam())->align(moving, start, StartQuality::kRough);
  EXPECT_TRUE(first.fixed_from_moving.matrix() == second.fixed_from_moving.matrix());
  EXPECT_EQ(first.rms_distance_mm, second.rms_distance_mm);
  EXPECT_EQ(first.num_pairs, second.num_pairs);
}

TEST_P(EveryMethod, ReportsTooFewPairsForAnEmptyCloudAndKeepsTheStart) {
  const Eigen::Isometry3d start = internal::camera_before_body();
  for (const std::size_t count : {std::size_t{0}, std::size_t{2}}) {
    PointCloud moving = internal::seen_by_camera(body()->mesh, start);
    moving.points.resize(count);
    moving.normals.resize(count);
    const auto result = make(GetParam())->align(moving, start, StartQuality::kRough);
    ASSERT_TRUE(result);
    EXPECT_EQ(result->status, RegistrationStatus::kTooFewPairs);
    EXPECT_TRUE(result->fixed_from_moving.isApprox(start, 1e-12));
  }
}

TEST_P(EveryMethod, RefusesNanInPointsAndStart) {
  const auto registration = make(GetParam());
  const Eigen::Isometry3d truth = internal::camera_before_body();
  PointCloud moving = internal::seen_by_camera(body()->mesh, truth);
  Eigen::Isometry3d start = truth;
  start.translation().x() = std::nan("");
  auto refused = registration->align(moving, start, StartQuality::kTracked);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("start pose"));
  moving.points[5].y() = std::nanf("");
  refused = registration->align(moving, truth, StartQuality::kTracked);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("not finite"));
}

TEST_P(EveryMethod, RefusesAStartThatIsNoRigidMotion) {
  Eigen::Isometry3d start = internal::camera_before_body();
  start.linear() *= 1.01;
  EXPECT_FALSE(make(GetParam())->align({}, start, StartQuality::kRough));
  start = internal::camera_before_body();
  start.linear().col(0) *= -1.0;
  EXPECT_FALSE(make(GetParam())->align({}, start, StartQuality::kRough));
}

TEST_P(EveryMethod, RefusesToPairAStartTwoMetersOffAndKeepsIt) {
  const Eigen::Isometry3d truth = internal::camera_before_body();
  const PointCloud moving = internal::seen_by_camera(body()->mesh, truth);
  for (const auto quality : {StartQuality::kRough, StartQuality::kTracked}) {
    Eigen::Isometry3d start = truth;
    start.translation() += Eigen::Vector3d(2000.0, 0.0, 0.0);
    const auto result = make(GetParam())->align(moving, start, quality);
    ASSERT_TRUE(result);
    EXPECT_EQ(result->status, RegistrationStatus::kTooFewPairs);
    EXPECT_TRUE(result->fixed_from_moving.isApprox(start, 1e-12));
    EXPECT_EQ(result->explained_fraction, 0.0);
  }
}

std::string method_name(const testing::TestParamInfo<RegistrationMethod>& method) {
  switch (method.param) {
    case RegistrationMethod::kIcp:
      return "Icp";
    case RegistrationMethod::kTrimmedIcp:
      return "TrimmedIcp";
    case RegistrationMethod::kAnisotropicIcp:
      return "AnisotropicIcp";
    case RegistrationMethod::kTrimmedAnisotropicIcp:
      return "TrimmedAnisotropicIcp";
    case RegistrationMethod::kField:
      return "Field";
  }
  return "Unknown";
}

INSTANTIATE_TEST_SUITE_P(FineRegistration,
                         EveryMethod,
                         testing::Values(RegistrationMethod::kIcp,
                                         RegistrationMethod::kTrimmedIcp,
                                         RegistrationMethod::kAnisotropicIcp,
                                         RegistrationMethod::kTrimmedAnisotropicIcp,
                                         RegistrationMethod::kField),
                         method_name);

TEST(FieldRegistration, RecoversThePoseFromRoughStartsUnderNoise) {
  const auto registration = make(RegistrationMethod::kField);
  const Eigen::Isometry3d truth = internal::camera_before_body();
  const PointCloud moving = with_noise(internal::seen_by_camera(body()->mesh, truth), 1.5F, 3);
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  const auto direction = [&] {
    return Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
  };
  for (int i = 0; i < 30; ++i) {
    const Eigen::Isometry3d start =
        internal::motion_about(body_center(), direction(), 20.0 * kDegree, 30.0 * direction()) *
        truth;
    const auto result = *registration->align(moving, start, StartQuality::kRough);
    EXPECT_EQ(result.status, RegistrationStatus::kConverged) << i;
    EXPECT_LT(error_mm(result.fixed_from_moving, truth), 0.6) << i;
  }
}

TEST(FieldRegistration, IsNotPulledAwayByClutterAboveTheSkin) {
  const auto registration = make(RegistrationMethod::kField);
  const Eigen::Isometry3d truth = internal::camera_before_body();
  PointCloud moving = with_noise(internal::seen_by_camera(body()->mesh, truth), 1.0F, 5);
  // A board 40 mm above the skin over a third of what the camera sees.
  for (std::size_t i = 0; i < moving.size(); ++i) {
    if (moving.points[i].x() > 30.0F) moving.points[i] -= 40.0F * moving.points[i].normalized();
  }
  const Eigen::Isometry3d start =
      internal::motion_about(body_center(), {0.3, 1.0, 0.2}, 8.0 * kDegree, {8.0, -8.0, 8.0}) *
      truth;
  const auto result = *registration->align(moving, start, StartQuality::kRough);
  EXPECT_LT(error_mm(result.fixed_from_moving, truth), 1.0);
  EXPECT_LT(result.explained_fraction, 0.85);
}

TEST(FieldRegistration, TellsASurfaceThatCrossesTheSkinInWaves) {
  const auto registration = make(RegistrationMethod::kField);
  const Eigen::Isometry3d truth = internal::camera_before_body();
  const PointCloud noisy = with_noise(internal::seen_by_camera(body()->mesh, truth), 0.5F, 5);
  const auto unevenness = [&](auto wave_mm) {
    PointCloud moving = noisy;
    for (auto& point : moving.points) point += wave_mm(point) * point.normalized();
    return registration->align(moving, truth, StartQuality::kTracked)->information->unevenness;
  };
  EXPECT_NEAR(unevenness([](const Eigen::Vector3f&) { return 0.0F; }), 1.0, 0.5);
  // A sensor's error, slow over the picture.
  EXPECT_LT(unevenness([](const Eigen::Vector3f& p) { return 2.0F * std::sin(p.x() / 150.0F); }),
            2.5);
  EXPECT_GT(unevenness([](const Eigen::Vector3f& p) { return 1.5F * std::sin(p.x() / 12.0F); }),
            3.0);
}

TEST(FieldRegistration, ReportsASphereAsDegenerateAndHoldsTheOpenDirections) {
  auto surface = std::make_shared<FixedSurface>();
  surface->mesh = internal::bumpy_body(100, Eigen::Vector3f::Zero());
  for (auto& vertex : surface->mesh.vertices) vertex = 100.0F * vertex.normalized();
  surface->mesh.normals = vertex_normals(surface->mesh);
  surface->field = *DistanceField::build(surface->mesh);
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  truth.translation() = Eigen::Vector3d(0.0, 0.0, -600.0);
  const PointCloud moving = internal::seen_by_camera(surface->mesh, truth);
  const auto registration = make_fine_registration(surface, {}).value();
  Eigen::Isometry3d start = truth;
  start.translation() += Eigen::Vector3d(4.0, -3.0, 5.0);
  const auto result = *registration->align(moving, start, StartQuality::kTracked);
  EXPECT_EQ(result.status, RegistrationStatus::kDegenerate);
  EXPECT_EQ(result.open_directions.size(), 3U);
  const Eigen::Vector3d center_in_depth = truth.inverse() * Eigen::Vector3d::Zero();
  EXPECT_LT((result.fixed_from_moving * center_in_depth).norm(), 0.2);
  EXPECT_LT(rotation_angle_rad(result.fixed_from_moving * truth.inverse()), 3.0 * kDegree);
}

TEST(FieldRegistration, ReportsThatAPlaneMaySlideAndTurnInItself) {
  auto surface = std::make_shared<FixedSurface>();
  PointCloud moving;
  constexpr std::uint32_t kSide = 61;
  for (std::uint32_t y = 0; y < kSide; ++y) {
    for (std::uint32_t x = 0; x < kSide; ++x) {
      const Eigen::Vector3f p(5.0F * static_cast<float>(x), 5.0F * static_cast<float>(y), 0.0F);
      surface->mesh.vertices.push_back(p);
      if (x + 1 == kSide || y + 1 == kSide) continue;
      const std::uint32_t a = kSide * y + x;
      surface->mesh.triangles.push_back({a, a + kSide, a + 1});
      surface->mesh.triangles.push_back({a + 1, a + kSide, a + kSide + 1});
      if (std::min(x, y) < 10 || std::max(x, y) > 50) continue;
      moving.points.push_back(p + Eigen::Vector3f(-150.0F, -150.0F, 600.0F));
      moving.normals.push_back(-Eigen::Vector3f::UnitZ());
    }
  }
  surface->mesh.normals = vertex_normals(surface->mesh);
  surface->field = *DistanceField::build(surface->mesh);
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity();
  start.translation() = Eigen::Vector3d(150.0 + 3.0, 150.0 - 2.0, -600.0 - 4.0);
  const auto result =
      *(*make_fine_registration(surface, {}))->align(moving, start, StartQuality::kTracked);
  EXPECT_EQ(result.status, RegistrationStatus::kDegenerate);
  ASSERT_EQ(result.open_directions.size(), 3U);
  for (const auto& open : result.open_directions) {
    EXPECT_GT(open.sigma_mm, 3.0);
    EXPECT_NEAR(open.shift_mm.z(), 0.0, 1e-3);
    EXPECT_NEAR(open.rotation_rad.head<2>().norm(), 0.0, 1e-5);
  }
  // The closed direction is found, the open ones are left where they were.
  EXPECT_NEAR(result.fixed_from_moving.translation().z(), -600.0, 0.05);
  EXPECT_NEAR(result.fixed_from_moving.translation().x(), 153.0, 0.05);
  EXPECT_NEAR(result.fixed_from_moving.translation().y(), 148.0, 0.05);
}

/// Points of a plane or sphere, as seen with noise, where the body's front is.
PointCloud shapeless_before_body(double radius_mm) {
  const Eigen::Isometry3d depth_from_ct = internal::camera_before_body().inverse();
  const Eigen::Vector3d front = depth_from_ct * (body_center() + Eigen::Vector3d(0.0, -80.0, 0.0));
  PointCloud cloud;
  for (int x = -60; x <= 60; x += 2) {
    for (int y = -60; y <= 60; y += 2) {
      const double down = radius_mm - std::sqrt(radius_mm * radius_mm - x * x - y * y);
      const Eigen::Vector3d off(x, y, down);
      cloud.points.push_back((front + off).cast<float>());
      cloud.normals.push_back(
          (off - Eigen::Vector3d(0.0, 0.0, radius_mm)).normalized().cast<float>());
    }
  }
  return with_noise(std::move(cloud), 0.6F, 4);
}

TEST(FieldRegistration, ReportsPointsOfAPlaneOrSphereOnAShapedBody) {
  const auto registration = make(RegistrationMethod::kField);
  for (const double radius_mm : {110.0, 140.0, 1e6}) {
    for (const auto quality : {StartQuality::kRough, StartQuality::kTracked}) {
      const auto result = *registration->align(
          shapeless_before_body(radius_mm), internal::camera_before_body(), quality);
      ASSERT_GT(result.num_pairs, 100) << radius_mm;
      EXPECT_EQ(result.status, RegistrationStatus::kDegenerate) << radius_mm;
    }
  }
  const PointCloud shaped =
      with_noise(internal::seen_by_camera(body()->mesh, internal::camera_before_body()), 0.6F, 4);
  EXPECT_EQ(
      registration->align(shaped, internal::camera_before_body(), StartQuality::kTracked)->status,
      RegistrationStatus::kConverged);
}

TEST(FieldRegistration, LooksUnderAThinClothThatLiesOnMostOfTheSkin) {
  const auto registration = make(RegistrationMethod::kField);
  const Eigen::Isometry3d truth = internal::camera_before_body();
  PointCloud moving = internal::seen_by_camera(body()->mesh, truth);
  int num_covered = 0;
  for (auto& point : moving.points) {
    if (std::abs(point.y() - 5.0F) > 62.0F) continue;
    point -= 5.0F * point.normalized();
    ++num_covered;
  }
  ASSERT_GT(num_covered, static_cast<int>(0.55 * static_cast<double>(moving.size())));
  moving = with_noise(std::move(moving), 1.0F, 9);
  for (const auto quality : {StartQuality::kRough, StartQuality::kTracked}) {
    const auto result = *registration->align(moving, truth, quality);
    EXPECT_LT(error_mm(result.fixed_from_moving, truth), 2.0);
  }
}

TEST(FieldRegistration, StaysWhereATrackedStartIsRightThoughAClothTouchesMostOfTheSkin) {
  const auto registration = make(RegistrationMethod::kField);
  const Eigen::Isometry3d truth = internal::camera_before_body();
  PointCloud moving = internal::seen_by_camera(body()->mesh, truth);
  std::vector<double> slopes;
  for (const auto& point : moving.points) slopes.push_back(point.x() / point.z());
  const double edge = quantile(slopes, 0.75);
  for (std::size_t i = 0; i < moving.size(); ++i) {
    auto& point = moving.points[i];
    if (slopes[i] >= edge) continue;
    const float folds = std::sin(point.y() / 15.0F) * std::cos(point.x() / 20.0F);
    point -= (10.0F + 5.0F * folds) * point.normalized();
  }
  for (unsigned seed = 0; seed < 5; ++seed) {
    const auto result =
        *registration->align(with_noise(moving, 0.7F, seed), truth, StartQuality::kTracked);
    EXPECT_LT(error_mm(result.fixed_from_moving, truth), 1.5) << seed;
  }
}

/// Half of the body under a cloth that hangs 10 to 25 mm above the skin.
PointCloud with_cloth(PointCloud cloud) {
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();
  for (const auto& point : cloud.points) middle += point / static_cast<float>(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f from_middle = cloud.points[i] - middle;
    if (from_middle.x() + 0.4F * from_middle.y() < 0.0F) continue;
    const float folds = std::sin(0.06F * from_middle.x()) * std::sin(0.05F * from_middle.y());
    cloud.points[i] += (17.5F + 7.5F * folds) * cloud.normals[i];
  }
  return cloud;
}

TEST(FieldRegistration, SinksToTheSkinFromRoughStartsWhereAClothCoversHalfOfIt) {
  const auto registration = make(RegistrationMethod::kField);
  const Eigen::Isometry3d truth = internal::camera_before_body();
  const PointCloud moving =
      with_noise(with_cloth(internal::seen_by_camera(body()->mesh, truth)), 0.6F, 3);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> even(-1.0, 1.0);
  for (int i = 0; i < 12; ++i) {
    const Eigen::Vector3d axis(even(random), even(random), even(random));
    const Eigen::Vector3d shift = 15.0 * Eigen::Vector3d(even(random), even(random), even(random));
    const Eigen::Isometry3d start =
        internal::motion_about(body_center(), axis, 18.0 * even(random) * kDegree, shift) * truth;
    const auto result = registration->align(moving, start, StartQuality::kRough);
    ASSERT_TRUE(result);
    EXPECT_LT(error_mm(result->fixed_from_moving, truth), 2.0) << i;
  }
}

TEST(FieldRegistration, TellsASkinThatItSeesThroughFromClutter) {
  const auto registration = make(RegistrationMethod::kField);
  const Eigen::Isometry3d truth = internal::camera_before_body();
  PointCloud moving = internal::seen_by_camera(body()->mesh, truth);
  for (std::size_t i = 0; i < moving.size(); i += 5) {
    moving.points[i] += 9.0F * moving.points[i].normalized();
  }
  const auto through = *registration->align(moving, truth, StartQuality::kTracked);
  EXPECT_GT(through.seen_through_fraction, 0.1);
  for (std::size_t i = 0; i < moving.size(); i += 5) {
    moving.points[i] -= 18.0F * moving.points[i].normalized();
  }
  const auto above = *registration->align(moving, truth, StartQuality::kTracked);
  EXPECT_LT(above.seen_through_fraction, 0.02);
}

TEST(FieldRegistration, RefusesPointsWithoutNormals) {
  PointCloud moving = internal::seen_by_camera(body()->mesh, internal::camera_before_body());
  moving.normals.clear();
  const auto refused = make(RegistrationMethod::kField)
                           ->align(moving, internal::camera_before_body(), StartQuality::kRough);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("normal"));
}

TEST(TrimmedIcp, IgnoresTheShareThatHasNoPartner) {
  const Eigen::Isometry3d truth = internal::camera_before_body();
  PointCloud moving = internal::seen_by_camera(body()->mesh, truth);
  const std::size_t num_lifted = moving.size() / 12;
  for (std::size_t i = 0; i < num_lifted; ++i) {
    moving.points[i] -= 120.0F * moving.points[i].normalized();
  }
  const auto trimmed =
      *make(RegistrationMethod::kTrimmedIcp)->align(moving, truth, StartQuality::kTracked);
  const auto plain = *make(RegistrationMethod::kIcp)->align(moving, truth, StartQuality::kTracked);
  EXPECT_LT(error_mm(trimmed.fixed_from_moving, truth), 2.0);
  EXPECT_GT(error_mm(plain.fixed_from_moving, truth), 4.0);
  EXPECT_EQ(trimmed.num_pairs, static_cast<int>(std::lround(0.9 * moving.size())));
}

TEST(MakeFineRegistration, RefusesBadOptionsAndSurfaces) {
  const auto message = [](std::shared_ptr<const FixedSurface> surface,
                          const RegistrationOptions& options) {
    const auto made = make_fine_registration(std::move(surface), options);
    return made ? std::string() : made.error().message;
  };
  EXPECT_THAT(message(body(), {.max_iterations = 0}), HasSubstr("max_iterations must be >= 1"));
  EXPECT_THAT(message(body(), {.convergence_threshold = -1.0}), HasSubstr("got -1"));
  EXPECT_THAT(message(body(), {.overlap = 1.5}), HasSubstr("overlap must be in (0, 1], got 1.5"));
  EXPECT_THAT(message(body(), {.overlap = std::nan("")}), HasSubstr("overlap"));
  EXPECT_THAT(message(body(), {.device = "opencl"}), HasSubstr("runs on the CPU"));
  EXPECT_THAT(message(nullptr, {}), HasSubstr("CT skin"));
  EXPECT_THAT(message(std::make_shared<FixedSurface>(), {}), HasSubstr("empty"));
  auto without_field = std::make_shared<FixedSurface>();
  without_field->mesh = internal::bumpy_body(10, Eigen::Vector3f::Zero());
  EXPECT_THAT(message(without_field, {}), HasSubstr("distance field"));
  EXPECT_EQ(message(without_field, {.method = RegistrationMethod::kIcp}), "");
}

TEST(RegistrationMethod, IsReadByTheNameItPrints) {
  for (const auto method : {RegistrationMethod::kIcp,
                            RegistrationMethod::kTrimmedIcp,
                            RegistrationMethod::kAnisotropicIcp,
                            RegistrationMethod::kTrimmedAnisotropicIcp,
                            RegistrationMethod::kField}) {
    EXPECT_EQ(parse_registration_method(to_string(method)), method);
  }
  EXPECT_FALSE(parse_registration_method("ICP"));
}

}  // namespace
}  // namespace mor
