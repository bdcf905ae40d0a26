// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/self_calibrator.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "morgagni/camera/simulated_camera.h"
#include "morgagni/depth/body_surface.h"
#include "morgagni/evaluation/recording_evaluation.h"
#include "morgagni/evaluation/target_sampling.h"
#include "morgagni/registration/testing/test_body.h"
#include "morgagni/session/routes/self_calibration_routes.h"

namespace mor {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

constexpr double kFramesPerS = 4.0;

std::shared_ptr<const Case> bumpy_case() {
  static const auto kCase = [] {
    auto body = std::make_shared<Case>();
    body->name = "bumpy";
    body->skin = internal::bumpy_surface(60);
    return body;
  }();
  return kCase;
}

/// The body some time after its CT: its skin has moved in and out.
std::shared_ptr<const TriangleMesh> changed_body() {
  auto mesh = bumpy_case()->skin->mesh;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3d at = mesh.vertices[i].cast<double>();
    const double out_mm = 1.5 * std::sin(at.y() / 30.0) * std::cos(at.x() / 45.0);
    mesh.vertices[i] += static_cast<float>(out_mm) * mesh.normals[i];
  }
  mesh.normals = vertex_normals(mesh);
  return std::make_shared<const TriangleMesh>(std::move(mesh));
}

/// A simulated camera in slow motion, tracked frame by frame, as LiveLoop does it.
class SelfCalibratorTest : public testing::Test {
 protected:
  SelfCalibratorTest()
      : store_(std::filesystem::path(testing::TempDir()) /
               ("self_calibrator_" + std::to_string(getpid()))) {
    std::filesystem::remove_all(store_.folder());
  }
  ~SelfCalibratorTest() override { std::filesystem::remove_all(store_.folder()); }

  void look_through(double bias_mm,
                    const std::string& device_id = "simulated-1",
                    std::shared_ptr<const TriangleMesh> body_now = nullptr) {
    SimulatedCameraOptions options;
    options.seed = 1003;
    options.path = SimulatedPath::kSweep;
    options.bias_mm = bias_mm;
    options.frames_per_s = kFramesPerS;
    options.has_noise = false;  // A smooth egg with noise would say too little of the pose.
    options.is_real_time = false;
    const auto body = bumpy_case();
    if (!body_now) {
      body_now = std::shared_ptr<const TriangleMesh>(body->skin, &body->skin->mesh);
    }
    camera_ = SimulatedCamera::create(body_now, options).value();
    tracker_ =
        std::make_unique<Tracker>(Tracker::create({},
                                                  body->skin,
                                                  extractor(camera_->calibration().depth),
                                                  make_fine_registration(body->skin, {}).value())
                                      .value());
    ASSERT_TRUE(tracker_->start_at(camera_->frame_at(0), camera_->ct_from_camera(0)));
    calibrator_ = std::make_unique<SelfCalibrator>(
        body,
        CalibrationInUse{[this] { return calibration(); },
                         [this] { return skin_; },
                         [this](auto calibration, auto skin, double bias_mm) {
                           sensor_bias_mm_ = bias_mm;
                           in_use_ = std::move(calibration);
                           skin_ = std::move(skin);
                           tracker_->use_camera(extractor(in_use_->depth));
                           tracker_->use_skin(skin_, make_fine_registration(skin_, {}).value());
                           return Result<void>();
                         },
                         [this](double bias_mm) { sensor_bias_mm_ = bias_mm; }},
        device_id,
        store_,
        [this] { return hindrance_; },
        SelfCalibratorOptions{.num_views = 60, .estimate = {}, .niceness = 0});
    targets_ = sample_skin_targets(body->skin->mesh, 10, 1).value();
  }

  static BodySurfaceExtractor extractor(const PinholeCamera& depth) {
    return BodySurfaceExtractor::create(depth, {}).value();
  }

  std::shared_ptr<const RgbdCalibration> calibration() const {
    return in_use_ ? in_use_ : std::make_shared<const RgbdCalibration>(camera_->calibration());
  }

  /// The next frame's error at the targets; nothing where it is not tracked.
  std::optional<double> track() {
    const auto id = next_++;
    std::shared_ptr<const RgbdFrame> frame = camera_->frame_at(id);
    if (in_use_) frame = with_calibration(*frame, in_use_);
    EXPECT_TRUE(tracker_->expect_bias(sensor_bias_mm_));
    const auto tracked = tracker_->process(frame).value();
    EXPECT_EQ(as_sensed(*tracked.frame).depth_mm, camera_->frame_at(id)->depth_mm)
        << "what is recorded stays the sensor's";
    calibrator_->look(tracked);
    if (tracked.state != TrackingState::kTracking) return std::nullopt;
    return target_registration_error_mm(
        *tracked.ct_from_depth, camera_->ct_from_camera(id), targets_);
  }

  /// Frames until the calibrator has come to a result; a frame waits for the view of the last one,
  /// so that a loaded machine gathers the same views. @return Mean error at the targets.
  double track_until_it_says_something() {
    double sum_mm = 0.0;
    int count = 0;
    const auto working = [this] {
      const auto phase = calibrator_->status().phase;
      return phase == SelfCalibratorPhase::kGathering || phase == SelfCalibratorPhase::kEstimating;
    };
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(4);
    const auto first = next_;
    while (next_ < first + 1200 && working() && std::chrono::steady_clock::now() < end) {
      if (calibrator_->status().phase == SelfCalibratorPhase::kEstimating) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        continue;
      }
      if (const auto error_mm = track()) {
        sum_mm += *error_mm;
        ++count;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(15));
    }
    return sum_mm / std::max(1, count);
  }

  /// What was found, for whoever reads why a test failed.
  std::string found_in_words() const {
    const auto& found = calibrator_->status().found;
    if (!found) return "nothing was found";
    const auto& held = found->held_out;
    return fmt::format(
        "{}: moved by {:.2f} mm, {:.2f} of {:.2f} mm stay unknown, {:.2f} open; skin moved by "
        "{:.2f} mm; held "
        "out {:.3f} mm, {:.3f} by the skin, {:.3f} by the sensor, {:.3f} by both; gain at {:.1f}",
        to_string(found->verdict),
        found->shift_mm,
        found->remaining_mm,
        found->before_mm,
        found->open_share,
        found->skin_shift_mm,
        held.as_it_is_mm,
        held.skin_mm,
        held.sensor_mm,
        held.both_mm,
        held.sensor.significance);
  }

  Json ask(const std::string& method, const std::string& what, int status = 200) {
    for (const auto& route : make_self_calibration_routes(
             std::shared_ptr<SelfCalibrator>(calibrator_.get(), [](auto*) {}))) {
      if (route.method != method || route.path != "/api/self-calibration" + what) continue;
      const auto answer = route.handler({route.path, {}, ""});
      EXPECT_EQ(answer.status, status) << answer.body;
      return Json::parse(answer.body);
    }
    ADD_FAILURE() << "no route " << what;
    return {};
  }

  CalibrationStore store_;
  std::unique_ptr<SimulatedCamera> camera_;
  std::unique_ptr<Tracker> tracker_;
  std::shared_ptr<const RgbdCalibration> in_use_;
  std::shared_ptr<const FixedSurface> skin_ = bumpy_case()->skin;
  std::atomic<double> sensor_bias_mm_ = 0.0;
  std::string hindrance_;
  std::vector<Target> targets_;
  std::uint64_t next_ = 0;
  std::unique_ptr<SelfCalibrator> calibrator_;
};

TEST_F(SelfCalibratorTest, ProposesAppliesChecksItselfAndTakesBack) {
  look_through(4.0);
  const double before_mm = track_until_it_says_something();
  const auto status = calibrator_->status();
  ASSERT_EQ(status.phase, SelfCalibratorPhase::kProposed) << found_in_words();
  const auto proposed = ask("GET", "");
  EXPECT_EQ(proposed["phase"], "proposed");
  EXPECT_EQ(proposed["found"]["map"]["add_mm"].size(), 130U);
  EXPECT_GT(proposed["found"]["shift_mm"], 1.0);
  EXPECT_EQ(in_use_, nullptr) << "nothing changes without a yes";
  const double waiting_bias_mm = sensor_bias_mm_;
  EXPECT_GT(waiting_bias_mm, status.found->shift_mm)
      << "a sensor that is known to be off widens the bound while that waits";

  hindrance_ = "a recording goes on";
  EXPECT_THAT(ask("POST", "/apply", 400)["error"], HasSubstr("a recording goes on"));
  hindrance_.clear();
  const auto applied = ask("POST", "/apply");
  EXPECT_EQ(applied["phase"], "gathering");
  EXPECT_EQ(applied["applied"]["kept"], true);
  EXPECT_THAT(applied["applied"]["origin"],
              HasSubstr("self-calibration on the CT skin, built on "
                        "[the camera's own], 20"));
  EXPECT_GT(sensor_bias_mm_, 0.5) << "what stays unknown widens the bound";
  EXPECT_LT(sensor_bias_mm_, waiting_bias_mm);
  const auto kept = store_.newest("simulated-1");
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->calibration, *in_use_);
  EXPECT_THAT(ask("POST", "/apply", 400)["error"], HasSubstr("no correction is proposed"));

  const double after_mm = track_until_it_says_something();
  EXPECT_LT(after_mm, 0.75 * before_mm) << "an egg leaves much unknown";
  EXPECT_EQ(calibrator_->status().phase, SelfCalibratorPhase::kResting)
      << "nothing more to remove, but " << found_in_words();

  const auto undone = ask("POST", "/undo");
  EXPECT_EQ(undone["applied"], nullptr);
  EXPECT_EQ(*in_use_, camera_->calibration());
  EXPECT_EQ(sensor_bias_mm_, waiting_bias_mm) << "the sensor errs as before, and that is known";
  EXPECT_FALSE(store_.newest("simulated-1"));
  EXPECT_EQ(undone["phase"], "resting") << "what was taken back is not proposed again by itself";
  EXPECT_THAT(ask("POST", "/undo", 400)["error"], HasSubstr("no correction was applied"));
}

TEST_F(SelfCalibratorTest, ProposesNothingWhereThereIsNoError) {
  look_through(0.0);
  track_until_it_says_something();
  EXPECT_EQ(calibrator_->status().phase, SelfCalibratorPhase::kResting);
  EXPECT_THAT(ask("POST", "/discard", 400)["error"], HasSubstr("no correction is proposed"));
  EXPECT_EQ(ask("POST", "/again")["phase"], "gathering");
}

TEST_F(SelfCalibratorTest, ACameraWithoutNumberIsCorrectedForTheSessionAlone) {
  look_through(4.0, "");
  track_until_it_says_something();
  ASSERT_EQ(calibrator_->status().phase, SelfCalibratorPhase::kProposed);
  const auto applied = ask("POST", "/apply");
  EXPECT_EQ(applied["applied"]["kept"], false);
  EXPECT_EQ(applied["device"], nullptr);
  EXPECT_NE(in_use_, nullptr);
  EXPECT_TRUE(store_.list().empty());
}

TEST_F(SelfCalibratorTest, ANoLeavesTheBoundAsWideAsTheSensorIsOff) {
  look_through(4.0);
  track_until_it_says_something();
  ASSERT_EQ(calibrator_->status().phase, SelfCalibratorPhase::kProposed);
  const double waiting_bias_mm = sensor_bias_mm_;
  EXPECT_EQ(ask("POST", "/discard")["phase"], "resting");
  EXPECT_EQ(sensor_bias_mm_, waiting_bias_mm);
  EXPECT_EQ(ask("POST", "/again")["phase"], "gathering");
  EXPECT_EQ(sensor_bias_mm_, 0.0);
}

TEST_F(SelfCalibratorTest, FollowsAChangedSkinForTheSessionAndTakesItBack) {
  look_through(0.0, "simulated-1", changed_body());
  const double before_mm = track_until_it_says_something();
  ASSERT_EQ(calibrator_->status().phase, SelfCalibratorPhase::kProposed) << found_in_words();
  const auto proposed = ask("GET", "")["found"];
  EXPECT_EQ(proposed["verdict"], "skin-changed");
  EXPECT_EQ(proposed["follows_skin"], true);
  EXPECT_EQ(proposed["corrects_sensor"], false);
  EXPECT_GT(proposed["skin_most_mm"], 0.5);
  EXPECT_EQ(skin_, bumpy_case()->skin) << "nothing changes without a yes";
  const double waiting_bias_mm = sensor_bias_mm_;
  EXPECT_GT(waiting_bias_mm, 0.0);

  const auto applied = ask("POST", "/apply")["applied"];
  EXPECT_EQ(applied["follows_skin"], true);
  EXPECT_EQ(applied["kept"], false) << "a changed body is not the device's";
  EXPECT_TRUE(store_.list().empty());
  EXPECT_EQ(*in_use_, camera_->calibration());
  EXPECT_NE(skin_, bumpy_case()->skin);
  EXPECT_THAT(skin_->change, HasSubstr("mm from the CT's"));
  EXPECT_LT(sensor_bias_mm_, waiting_bias_mm);
  EXPECT_LT(track_until_it_says_something(), before_mm);
  EXPECT_EQ(calibrator_->status().phase, SelfCalibratorPhase::kResting)
      << "nothing more to follow, but " << found_in_words();

  EXPECT_EQ(ask("POST", "/undo")["applied"], nullptr);
  EXPECT_EQ(skin_, bumpy_case()->skin);
}

TEST_F(SelfCalibratorTest, EndsAtOnceWhileItWorks) {
  look_through(4.0);
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(2);
  while (calibrator_->status().phase != SelfCalibratorPhase::kEstimating &&
         std::chrono::steady_clock::now() < end) {
    track();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_EQ(calibrator_->status().phase, SelfCalibratorPhase::kEstimating);
  calibrator_->look_again();
  EXPECT_EQ(calibrator_->status().phase, SelfCalibratorPhase::kGathering);
  EXPECT_EQ(calibrator_->status().num_views, 0);
  EXPECT_FALSE(calibrator_->status().found);
}

}  // namespace
}  // namespace mor
