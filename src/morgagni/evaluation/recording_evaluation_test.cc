// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/recording_evaluation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "morgagni/core/files.h"
#include "morgagni/core/image_png.h"
#include "morgagni/geometry/depth_raster.h"
#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/testing/test_body.h"

namespace mor {
namespace {

using testing::HasSubstr;

constexpr int kNumFrames = 4;
constexpr int kIslandPx = 30;

/// A recording of the bumpy body, made once: the camera moves a few millimetres a frame.
class EvaluateRecording : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ =
        std::filesystem::path(testing::TempDir()) / fmt::format("mor_evaluation_{}", ::getpid());
    std::filesystem::create_directories(folder_ / "depth");
    std::filesystem::create_directories(folder_ / "rgb");
    body_ = internal::bumpy_surface();
    const PinholeCamera camera{320, 240, 262.5, 262.5, 159.5, 119.5, {}};
    ASSERT_TRUE(write_file(folder_ / "intrinsics.json",
                           std::string_view(R"({"fx": 262.5, "fy": 262.5, "cx": 159.5, "cy": 119.5,
                            "width": 320, "height": 240, "depth_scale": 1000.0,
                            "distortion": [0, 0, 0, 0, 0]})")));
    std::string depth_list;
    std::string color_list;
    for (int i = 0; i < kNumFrames; ++i) {
      TimedPose pose;
      pose.timestamp_s = 0.1 * i;
      pose.ct_from_depth =
          internal::motion_about(
              {30.0, -200.0, 400.0}, {0.2, 1.0, 0.4}, 0.01 * i, {2.0 * i, -1.0 * i, 1.0 * i}) *
          internal::camera_before_body();
      truth_.push_back(pose);
      const DepthRaster raster = rasterize_depth(body_->mesh, camera, pose.ct_from_depth.inverse());
      Image<std::uint16_t> depth(camera.width_px, camera.height_px);
      for (int y = 0; y < depth.height(); ++y) {
        for (int x = 0; x < depth.width(); ++x) {
          depth(x, y) = static_cast<std::uint16_t>(std::lround(raster.depth_mm(x, y)));
          // Something else in the picture, apart from the body.
          if (x < kIslandPx && y < kIslandPx) depth(x, y) = 400;
        }
      }
      const Image<Rgb8> color(camera.width_px, camera.height_px);
      ASSERT_TRUE(write_file(folder_ / fmt::format("depth/{}.png", i), encode_png(depth.view())));
      ASSERT_TRUE(write_file(folder_ / fmt::format("rgb/{}.png", i), encode_png(color.view())));
      depth_list += fmt::format("{:.6f} depth/{}.png\n", pose.timestamp_s, i);
      color_list += fmt::format("{:.6f} rgb/{}.png\n", pose.timestamp_s, i);
    }
    ASSERT_TRUE(write_file(folder_ / "depth.txt", depth_list));
    ASSERT_TRUE(write_file(folder_ / "rgb.txt", color_list));
    for (std::size_t i = 0; i < body_->mesh.vertices.size(); i += 1500) {
      targets_.push_back({fmt::format("F{}", i), true, body_->mesh.vertices[i].cast<double>()});
    }
  }
  static void TearDownTestSuite() {
    std::filesystem::remove_all(folder_);
    body_.reset();
  }

  [[nodiscard]] static Result<EvaluationReport> evaluate(const EvaluationOptions& options) {
    const auto recording = TumRecording::open(folder_);
    EXPECT_TRUE(recording) << recording.error().message;
    return evaluate_recording(
        *recording, body_, truth_, targets_, options, [](std::string_view, double) {});
  }

  static inline std::filesystem::path folder_;
  static inline std::shared_ptr<const FixedSurface> body_;
  static inline std::vector<TimedPose> truth_;
  static inline std::vector<Target> targets_;
};

TEST_F(EvaluateRecording, FollowsTheBodyFromThePoseBefore) {
  const auto report = evaluate({});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->num_frames, kNumFrames);
  EXPECT_EQ(report->runs.size(), static_cast<std::size_t>(kNumFrames));
  EXPECT_DOUBLE_EQ(report->success_rate, 1.0);
  EXPECT_LT(report->tre_mm.max, 0.6);
  EXPECT_GT(report->tre_mm.max, 0.0);
  EXPECT_GT(report->median_points, 1000.0);
  EXPECT_GT(report->registration_ms.median, 0.0);
}

TEST_F(EvaluateRecording, ComesBackFromPerturbedStartsTheSameTwice) {
  const EvaluationOptions options{.num_starts = 3, .seed = 42};
  const auto first = evaluate(options);
  const auto second = evaluate(options);
  ASSERT_TRUE(first && second);
  ASSERT_EQ(first->runs.size(), static_cast<std::size_t>(3 * kNumFrames));
  for (std::size_t i = 0; i < first->runs.size(); ++i) {
    EXPECT_EQ(first->runs[i].tre_mm, second->runs[i].tre_mm);
  }
  EXPECT_DOUBLE_EQ(first->success_rate, 1.0);
}

TEST_F(EvaluateRecording, SegmentsThePictureWhereTheStartAndNotTheTruthExpectsTheBody) {
  const auto num_small = [](double start_error_mm) {
    const auto report = *evaluate({.num_starts = 40, .start_error_mm = start_error_mm});
    return std::count_if(report.runs.begin(), report.runs.end(), [](const EvaluationRun& run) {
      return run.num_points < 200;
    });
  };
  EXPECT_EQ(num_small(10.0), 0);
  EXPECT_GT(num_small(900.0), 0);
}

TEST_F(EvaluateRecording, MeasuresTheStartWhereTheMethodMayNotMove) {
  // One step of ICP from 200 mm away ends far from the truth: success must not be reported.
  const auto report =
      evaluate({.registration = {.method = RegistrationMethod::kIcp, .max_iterations = 1},
                .num_starts = 2,
                .start_error_mm = 200.0,
                .start_error_deg = 90.0});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_LT(report->success_rate, 1.0);
  EXPECT_GT(report->tre_mm.max, 10.0);
  EXPECT_LT(report->tre_success_mm.max, 10.0);
}

TEST_F(EvaluateRecording, WritesTheJsonThatScriptsRead) {
  const auto report = evaluate({});
  ASSERT_TRUE(report);
  const auto json = nlohmann::json::parse(to_json(*report));
  EXPECT_EQ(json.at("method"), "field");
  EXPECT_EQ(json.at("frames"), kNumFrames);
  EXPECT_EQ(json.at("starts"), 0);
  EXPECT_DOUBLE_EQ(json.at("success_rate"), 1.0);
  for (const char* key : {"mean", "sd", "median", "p95", "max"}) {
    EXPECT_TRUE(json.at("tre_mm").at(key).is_number()) << key;
    EXPECT_TRUE(json.at("tre_success_mm").at(key).is_number()) << key;
  }
  EXPECT_TRUE(json.at("registration_ms").at("median").is_number());
  EXPECT_TRUE(json.at("registration_ms").at("p95").is_number());
  EXPECT_GT(json.at("registration_cpu_ms").at("median"), 0.0);
  EXPECT_GT(json.at("points"), 0.0);
  ASSERT_EQ(json.at("difficulty").size(), static_cast<std::size_t>(kNumFrames));
  // Nothing covers the body but the thing in the corner.
  EXPECT_GT(json.at("difficulty")[0].at("bare_share"), 0.85);
  EXPECT_GT(json.at("difficulty")[0].at("least_tre_mm"), 0.0);
  ASSERT_EQ(json.at("runs").size(), static_cast<std::size_t>(kNumFrames));
  EXPECT_GT(json.at("runs")[0].at("cpu_ms"), 0.0);
  EXPECT_LT(json.at("runs")[0].at("tre_mm"), 1.0);
  EXPECT_THAT(to_table(*report), HasSubstr("60 to 100 %"));
  EXPECT_THAT(to_table(*report), HasSubstr("TRE, mm"));
}

TEST_F(EvaluateRecording, RefusesBadOptionsNoTargetsNoTruthAndAnEmptyView) {
  EXPECT_THAT(evaluate({.num_starts = -1}).error().message, HasSubstr("starts"));
  EXPECT_THAT(evaluate({.start_error_mm = -5.0}).error().message, HasSubstr("got -5"));
  EXPECT_THAT(evaluate({.start_error_deg = 181.0}).error().message, HasSubstr("[0, 180]"));
  EXPECT_THAT(evaluate({.depth = {.far_mm = 100.0}}).error().message, HasSubstr("shows nothing"));
  const auto recording = *TumRecording::open(folder_);
  const auto quiet = [](std::string_view, double) {};
  EXPECT_FALSE(evaluate_recording(recording, body_, truth_, {}, {}, quiet));
  auto late = truth_;
  for (auto& pose : late) pose.timestamp_s += 1000.0;
  const auto refused = evaluate_recording(recording, body_, late, targets_, {}, quiet);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("none of the recording's 4 frames"));
}

TEST_F(EvaluateRecording, LeavesOutFramesWithoutTruthAndCountsThem) {
  auto fewer = truth_;
  fewer.pop_back();
  const auto report = evaluate_recording(
      *TumRecording::open(folder_), body_, fewer, targets_, {}, [](std::string_view, double) {});
  ASSERT_TRUE(report);
  EXPECT_EQ(report->num_frames, kNumFrames - 1);
  EXPECT_EQ(report->num_frames_without_truth, 1);
}

TEST(TargetRegistrationError, IsTheRootMeanSquareOverTheTargets) {
  Eigen::Isometry3d truth = internal::camera_before_body();
  Eigen::Isometry3d found = truth;
  found.pretranslate(Eigen::Vector3d(3.0, 0.0, 4.0));
  const std::vector<Target> targets = {{"a", true, {0.0, 0.0, 0.0}}, {"b", false, {9.0, 9.0, 9.0}}};
  EXPECT_NEAR(target_registration_error_mm(found, truth, targets), 5.0, 1e-9);
  EXPECT_NEAR(target_registration_error_mm(truth, truth, targets), 0.0, 1e-9);
  // A turn about one target moves only the other: its distance over the root of two.
  found =
      internal::motion_about({0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, std::numbers::pi, {0, 0, 0}) * truth;
  EXPECT_NEAR(target_registration_error_mm(found, truth, targets),
              std::sqrt(2.0 * 81.0) * 2.0 / std::sqrt(2.0),
              1e-9);
}

TEST(PerturbedStart, StaysWithinItsLimitsAndReachesNearThem) {
  const Eigen::Isometry3d truth = internal::camera_before_body();
  const Eigen::Vector3d center(30.0, -280.0, 400.0);
  std::mt19937_64 random(3);
  double largest_mm = 0.0;
  double largest_rad = 0.0;
  Eigen::Vector3d mean_shift = Eigen::Vector3d::Zero();
  constexpr int kCount = 2000;
  for (int i = 0; i < kCount; ++i) {
    const Eigen::Isometry3d start = perturbed_start(truth, center, 30.0, 0.35, random);
    const Eigen::Vector3d shift = start * (truth.inverse() * center) - center;
    largest_mm = std::max(largest_mm, shift.norm());
    largest_rad = std::max(largest_rad, rotation_angle_rad(start * truth.inverse()));
    mean_shift += shift / kCount;
  }
  EXPECT_LE(largest_mm, 30.0 + 1e-9);
  EXPECT_GT(largest_mm, 29.0);
  EXPECT_LE(largest_rad, 0.35 + 1e-9);
  EXPECT_GT(largest_rad, 0.34);
  EXPECT_LT(mean_shift.norm(), 1.0);
}

}  // namespace
}  // namespace mor
