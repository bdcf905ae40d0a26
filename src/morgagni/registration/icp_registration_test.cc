// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/icp_registration.h"

#include <cctype>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <sstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>

#include "morgagni/core/log.h"
#include "morgagni/registration/testing/test_body.h"

namespace mor::internal {
namespace {

using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180.0;

const TriangleMesh& body() {
  static const TriangleMesh mesh = bumpy_body(100, {30.0F, -200.0F, 400.0F});
  return mesh;
}

/// What a camera sees of the body, with a sensor's noise along its rays.
PointCloud seen_body() {
  PointCloud cloud = seen_by_camera(body(), camera_before_body());
  std::mt19937 random(7);
  std::normal_distribution<float> noise(0.0F, 1.4F);
  for (auto& point : cloud.points) point += noise(random) * point.normalized();
  return cloud;
}

Eigen::Isometry3d random_start(unsigned seed, double shift_mm, double angle_deg) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto direction = [&] {
    return Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
  };
  return motion_about(
             {30.0, -200.0, 400.0}, direction(), angle_deg * kDegree, shift_mm * direction()) *
         camera_before_body();
}

const std::vector<RegistrationMethod>& methods() {
  static const std::vector<RegistrationMethod> kMethods = {
      RegistrationMethod::kIcp,
      RegistrationMethod::kTrimmedIcp,
      RegistrationMethod::kAnisotropicIcp,
      RegistrationMethod::kTrimmedAnisotropicIcp};
  return kMethods;
}

double turned_deg(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return rotation_angle_rad(Eigen::Isometry3d(a.inverse() * b)) / kDegree;
}

/// How far two poses put the middle of what the camera sees apart.
double apart_mm(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  const Eigen::Vector3d in_depth =
      camera_before_body().inverse() * Eigen::Vector3d(30.0, -260.0, 400.0);
  return displacement_mm(a, b, in_depth);
}

std::string name_of(const testing::TestParamInfo<RegistrationMethod>& method) {
  std::string name;
  bool upper = true;
  for (const char c : to_string(method.param)) {
    if (c != '-') name += upper ? static_cast<char>(std::toupper(c)) : c;
    upper = c == '-';
  }
  return name;
}

std::unique_ptr<FineRegistration> on_cpu(RegistrationMethod method) {
  return make_icp_registration(body(), {.method = method}).value();
}

/// On the first OpenCL device; a test is skipped where there is none.
class IcpOnOpencl : public testing::TestWithParam<RegistrationMethod> {
 protected:
  void SetUp() override {
    surface_ = std::make_shared<const IcpSurface>(body(), metric_of(GetParam()));
    auto device = make_icp_backend_opencl(surface_, "opencl");
    if (!device) GTEST_SKIP() << device.error().message;
    options_.method = GetParam();
    registration_ = std::make_unique<IcpRegistration>(surface_, options_, *std::move(device));
  }

  std::shared_ptr<const IcpSurface> surface_;
  RegistrationOptions options_;
  std::unique_ptr<IcpRegistration> registration_;
};

TEST_P(IcpOnOpencl, FindsThePoseOfTheCpu) {
  const auto cpu = on_cpu(GetParam());
  const auto moving = seen_body();
  EXPECT_NE(registration_->device_name(), "cpu");
  for (const auto& [seed, shift_mm, angle_deg] :
       {std::tuple{1U, 5.0, 2.0}, std::tuple{2U, 5.0, 2.0}, std::tuple{7U, 25.0, 15.0}}) {
    const auto start = random_start(seed, shift_mm, angle_deg);
    const auto expected = *cpu->align(moving, start, StartQuality::kRough);
    const auto result = *registration_->align(moving, start, StartQuality::kRough);
    EXPECT_LT(apart_mm(result.fixed_from_moving, expected.fixed_from_moving), 0.01);
    EXPECT_LT(turned_deg(result.fixed_from_moving, expected.fixed_from_moving), 0.001);
    EXPECT_EQ(result.status, expected.status);
    EXPECT_EQ(result.num_iterations, expected.num_iterations);
    EXPECT_EQ(result.num_pairs, expected.num_pairs);
    EXPECT_NEAR(result.explained_fraction, expected.explained_fraction, 1e-9);
    EXPECT_NEAR(result.rms_distance_mm, expected.rms_distance_mm, 1e-6);
    EXPECT_GT(apart_mm(start, expected.fixed_from_moving), 2.0);
  }
  EXPECT_NE(registration_->device_name(), "cpu");
}

/// In single precision poses differ by micrometres, so that after many steps a pair may be another
/// one; a few steps show that nothing but that is different.
TEST_P(IcpOnOpencl, FindsThePoseOfTheCpuInSinglePrecision) {
  options_.max_iterations = 5;
  auto device = make_icp_backend_opencl(surface_, "opencl", SumPrecision::kSingle);
  const IcpRegistration single(surface_, options_, std::move(device).value());
  const IcpRegistration cpu(surface_, options_, nullptr);
  const auto moving = seen_body();
  for (const unsigned seed : {1U, 2U, 3U}) {
    const auto start = random_start(seed, 20.0, 10.0);
    const auto expected = *cpu.align(moving, start, StartQuality::kRough);
    const auto result = *single.align(moving, start, StartQuality::kRough);
    EXPECT_EQ(result.num_iterations, 5);
    EXPECT_LT(apart_mm(result.fixed_from_moving, expected.fixed_from_moving), 0.01);
    EXPECT_LT(turned_deg(result.fixed_from_moving, expected.fixed_from_moving), 0.001);
  }
}

TEST_P(IcpOnOpencl, GivesTheSameBitsFromSeveralThreadsAndAfterOtherClouds) {
  const auto moving = seen_body();
  const auto start = random_start(3, 5.0, 2.0);
  const auto first = *registration_->align(moving, start, StartQuality::kRough);
  PointCloud larger = moving;
  larger.points.insert(larger.points.end(), moving.points.begin(), moving.points.end());
  RegistrationResult other;
  std::thread beside([&] { other = *registration_->align(moving, start, StartQuality::kRough); });
  ASSERT_TRUE(registration_->align(larger, random_start(4, 5.0, 2.0), StartQuality::kRough));
  const auto again = *registration_->align(moving, start, StartQuality::kRough);
  beside.join();
  EXPECT_TRUE(first.fixed_from_moving.matrix() == again.fixed_from_moving.matrix());
  EXPECT_TRUE(first.fixed_from_moving.matrix() == other.fixed_from_moving.matrix());
  EXPECT_EQ(first.rms_distance_mm, again.rms_distance_mm);
}

/// Two metres off to every side, with one point in twenty that happens to lie near the body.
void expect_refused_two_metres_off(const FineRegistration& registration) {
  const PointCloud seen = seen_body();
  for (const double off_mm : {-2000.0, 2000.0}) {
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::Isometry3d start = camera_before_body();
      start.translation() += off_mm * Eigen::Vector3d::Unit(axis);
      PointCloud moving = seen;
      const Eigen::Isometry3f stray = (start.inverse() * camera_before_body()).cast<float>();
      for (std::size_t i = 0; i < moving.size(); i += 20) {
        moving.points[i] = stray * moving.points[i];
      }
      for (const auto& cloud : {seen, moving}) {
        const auto result = *registration.align(cloud, start, StartQuality::kRough);
        EXPECT_EQ(result.status, RegistrationStatus::kTooFewPairs) << off_mm << " along " << axis;
        EXPECT_TRUE(result.fixed_from_moving.isApprox(start, 1e-12));
      }
    }
  }
}

TEST_P(IcpOnOpencl, RefusesAStartTwoMetresOff) {
  expect_refused_two_metres_off(*registration_);
}

TEST_P(IcpOnOpencl, IsChosenByAPartOfItsNameAndNoOther) {
  options_.device = registration_->device_name().substr(1);
  EXPECT_EQ(make_icp_registration(body(), options_).value()->device_name(),
            registration_->device_name());
  options_.device = "Voodoo 2";
  const auto refused = make_icp_registration(body(), options_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(refused.error().message, HasSubstr(registration_->device_name()));
}

INSTANTIATE_TEST_SUITE_P(Icp, IcpOnOpencl, testing::ValuesIn(methods()), name_of);

/// A device and its failures: everything works so many times, then nothing does.
class FailingBackend : public IcpBackend {
 public:
  FailingBackend(std::shared_ptr<const IcpSurface> surface, int num_calls)
      : inner_(make_icp_backend_cpu(std::move(surface))), num_calls_(num_calls) {}

  std::string name() const override { return "Flaky 3000"; }
  Result<void> load(std::span<const Eigen::Vector3f> moving) override {
    MOR_CHECK(count_down());
    return inner_->load(moving);
  }
  Result<void> find_pairs(const Eigen::Isometry3d& pose) override {
    MOR_CHECK(count_down());
    return inner_->find_pairs(pose);
  }
  Result<void> keep_closest(std::size_t num_kept) override {
    MOR_CHECK(count_down());
    return inner_->keep_closest(num_kept);
  }
  Result<PairSums> sum_pairs() override {
    MOR_CHECK(count_down());
    return inner_->sum_pairs();
  }
  Result<WeightedEquations> linearize(const Eigen::Isometry3d& pose,
                                      const Eigen::Vector3d& pivot) override {
    MOR_CHECK(count_down());
    return inner_->linearize(pose, pivot);
  }
  Result<std::vector<std::uint32_t>> partners() override {
    MOR_CHECK(count_down());
    return inner_->partners();
  }
  Result<std::vector<std::uint32_t>> kept() override {
    MOR_CHECK(count_down());
    return inner_->kept();
  }

 private:
  Result<void> count_down() {
    if (num_calls_-- > 0) return {};
    return make_error(ErrorCode::kDevice, "the OpenCL device failed to run find_nearest");
  }

  std::unique_ptr<IcpBackend> inner_;
  int num_calls_;
};

/// A CPU on which the third pairing, so the second step, makes the residual worse.
class WorseningBackend final : public FailingBackend {
 public:
  explicit WorseningBackend(std::shared_ptr<const IcpSurface> surface)
      : FailingBackend(std::move(surface), std::numeric_limits<int>::max()) {}

  Result<PairSums> sum_pairs() override {
    MOR_TRY(auto sums, FailingBackend::sum_pairs());
    if (++num_pairings_ == 3) sums.sum_weighted_sq *= 4.0;
    return sums;
  }

 private:
  int num_pairings_ = 0;
};

/// What is logged while it lives.
class CapturedLog {
 public:
  CapturedLog() : before_(spdlog::default_logger()) {
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "captured", std::make_shared<spdlog::sinks::ostream_sink_mt>(text_)));
  }
  ~CapturedLog() { spdlog::set_default_logger(before_); }
  CapturedLog(const CapturedLog&) = delete;
  CapturedLog& operator=(const CapturedLog&) = delete;

  [[nodiscard]] std::size_t count(const std::string& words) const {
    const std::string text = text_.str();
    std::size_t found = 0;
    for (auto at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) {
      ++found;
    }
    return found;
  }

 private:
  std::ostringstream text_;
  std::shared_ptr<spdlog::logger> before_;
};

class AnyIcp : public testing::TestWithParam<RegistrationMethod> {};

TEST_P(AnyIcp, GoesOnOnTheCpuWhenItsDeviceFailsAndSaysSoOnce) {
  const auto moving = seen_body();
  const auto start = random_start(1, 5.0, 2.0);
  const auto expected = *on_cpu(GetParam())->align(moving, start, StartQuality::kRough);
  const auto surface = std::make_shared<const IcpSurface>(body(), metric_of(GetParam()));
  for (const int num_calls : {0, 1, 2, 3, 4, 17}) {
    CapturedLog log;
    const IcpRegistration registration(
        surface, {.method = GetParam()}, std::make_unique<FailingBackend>(surface, num_calls));
    EXPECT_EQ(registration.device_name(), "Flaky 3000");
    for (int i = 0; i < 2; ++i) {
      const auto result = registration.align(moving, start, StartQuality::kRough);
      ASSERT_TRUE(result) << result.error().message;
      EXPECT_TRUE(result->fixed_from_moving.matrix() == expected.fixed_from_moving.matrix());
      EXPECT_EQ(result->status, expected.status);
    }
    EXPECT_EQ(registration.device_name(), "cpu");
    EXPECT_EQ(log.count("registration goes on on the CPU"), 1U) << num_calls;
    EXPECT_EQ(log.count("Flaky 3000"), 1U);
  }
}

TEST_P(AnyIcp, UndoesAStepThatMakesTheResidualWorse) {
  const auto moving = seen_body();
  const auto start = random_start(2, 20.0, 10.0);
  const auto surface = std::make_shared<const IcpSurface>(body(), metric_of(GetParam()));
  const auto after_one = *IcpRegistration(surface, {.method = GetParam(), .max_iterations = 1}, {})
                              .align(moving, start, StartQuality::kRough);
  const IcpRegistration registration(
      surface, {.method = GetParam()}, std::make_unique<WorseningBackend>(surface));
  const auto result = *registration.align(moving, start, StartQuality::kRough);
  EXPECT_EQ(result.status, RegistrationStatus::kConverged);
  EXPECT_EQ(result.num_iterations, 2);
  EXPECT_TRUE(result.fixed_from_moving.matrix() == after_one.fixed_from_moving.matrix());
  EXPECT_EQ(after_one.status, RegistrationStatus::kMaxIterations);
  EXPECT_EQ(result.rms_distance_mm, after_one.rms_distance_mm) << "both of the pose given";
}

/// Points of a patch of 200 x 160 mm that `height` gives its z, seen with noise.
PointCloud patch(const std::function<float(float, float)>& height, float noise_mm) {
  std::mt19937 random(5);
  std::normal_distribution<float> noise(0.0F, 1.0F);
  PointCloud cloud;
  for (float x = -100.0F; x <= 100.0F; x += 4.0F) {
    for (float y = -80.0F; y <= 80.0F; y += 4.0F) {
      cloud.points.emplace_back(x, y, height(x, y) + noise_mm * noise(random));
    }
  }
  return cloud;
}

float sphere_height(float x, float y) {
  return 750.0F - std::sqrt(150.0F * 150.0F - x * x - y * y);
}

TEST_P(AnyIcp, ReportsPointsOnALinePlaneOrSphereAndKeepsTheStart) {
  PointCloud line;
  for (int i = 0; i < 50; ++i) line.points.emplace_back(2.0F * i, 3.0F * i, 600.0F + i);
  PointCloud three;
  three.points = {{0.0F, 0.0F, 600.0F}, {80.0F, 0.0F, 610.0F}, {0.0F, 90.0F, 640.0F}};
  PointCloud same;
  same.points.assign(10, Eigen::Vector3f(0.0F, 0.0F, 600.0F));
  const auto plane = [](float x, float y) { return 600.0F + 0.3F * x - 0.1F * y; };
  const auto start = random_start(2, 5.0, 2.0);
  for (const auto& moving : {line,
                             three,
                             same,
                             patch(plane, 0.0F),
                             patch(plane, 1.4F),
                             patch(sphere_height, 0.0F),
                             patch(sphere_height, 1.4F)}) {
    const auto result = on_cpu(GetParam())->align(moving, start, StartQuality::kRough);
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_EQ(result->status, RegistrationStatus::kDegenerate) << moving.size();
    EXPECT_TRUE(result->fixed_from_moving.isApprox(start, 1e-12));
    EXPECT_GT(result->rms_distance_mm, 0.0);
  }
}

TEST_P(AnyIcp, RefusesAStartTwoMetresOffWhateverStrayPointsThereAre) {
  expect_refused_two_metres_off(*on_cpu(GetParam()));
}

TEST_P(AnyIcp, ReportsAFixedSurfaceThatLeavesThePoseOpen) {
  TriangleMesh sphere = bumpy_body(60, Eigen::Vector3f::Zero());
  for (auto& vertex : sphere.vertices) vertex = 120.0F * vertex.normalized();
  sphere.normals = vertex_normals(sphere);
  TriangleMesh plane = sphere;
  for (auto& vertex : plane.vertices) vertex.y() = -80.0F;
  plane.normals.assign(plane.vertices.size(), -Eigen::Vector3f::UnitY());
  for (auto* fixed : {&sphere, &plane}) {
    for (auto& vertex : fixed->vertices) vertex += Eigen::Vector3f(30.0F, -200.0F, 400.0F);
    const auto registration = make_icp_registration(*fixed, {.method = GetParam()}).value();
    const auto result =
        registration->align(seen_body(), camera_before_body(), StartQuality::kRough);
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_EQ(result->status, RegistrationStatus::kDegenerate);
    EXPECT_TRUE(result->fixed_from_moving.isApprox(camera_before_body(), 1e-12));
  }
}

TEST_P(AnyIcp, RefusesAFixedSurfaceWithoutNormalsOrWithNan) {
  const auto message = [](const TriangleMesh& fixed) {
    const auto made = make_icp_registration(fixed, {.method = GetParam()});
    return made ? std::string() : made.error().message;
  };
  TriangleMesh fixed = body();
  fixed.vertices[7].x() = std::nanf("");
  EXPECT_THAT(message(fixed), HasSubstr("not finite"));
  fixed = body();
  fixed.normals.pop_back();
  EXPECT_THAT(message(fixed), HasSubstr("needs a normal for each"));
}

INSTANTIATE_TEST_SUITE_P(Icp, AnyIcp, testing::ValuesIn(methods()), name_of);

TEST(AnisotropicIcp, IsMoreAccurateThanIcpUnderNoise) {
  const auto moving = seen_body();
  double icp_mm = 0.0;
  double anisotropic_mm = 0.0;
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    const auto start = random_start(seed, 10.0, 5.0);
    const auto error_mm = [&](RegistrationMethod method) {
      const auto result = *on_cpu(method)->align(moving, start, StartQuality::kRough);
      return apart_mm(result.fixed_from_moving, camera_before_body());
    };
    icp_mm += error_mm(RegistrationMethod::kIcp);
    anisotropic_mm += error_mm(RegistrationMethod::kAnisotropicIcp);
  }
  EXPECT_LT(anisotropic_mm, 0.5 * icp_mm);
}

}  // namespace
}  // namespace mor::internal
