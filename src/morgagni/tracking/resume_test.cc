// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// The tracker with the real registration, on the simulated camera over a bumpy body: what it does
// when the camera is covered and comes back from elsewhere.

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/camera/simulated_camera.h"
#include "morgagni/geometry/depth_raster.h"
#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/testing/test_body.h"
#include "morgagni/tracking/tracker.h"

namespace mor {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPeriod{33};
constexpr double kRightMm = 5.0;
constexpr int kWithinFrames = 15;  ///< Half a second.

class ResumeTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto skin = std::shared_ptr<const TriangleMesh>(body_, &body_->mesh);
    camera_ = SimulatedCamera::create(skin,
                                      {.seed = 7,
                                       .width_px = 320,
                                       .height_px = 240,
                                       .distance_mm = 750.0,
                                       .is_real_time = false})
                  .value();
    tracker_.emplace(Tracker::create({},
                                     body_,
                                     BodySurfaceExtractor::create(camera_->calibration().depth,
                                                                  {.down_sampling = 1.5})
                                         .value(),
                                     make_fine_registration(body_, {}).value())
                         .value());
  }

  TrackedFrame show(std::uint64_t frame_id) { return process(*camera_->frame_at(frame_id)); }

  /// The same frame with this reading everywhere: 0, or a hand before the sensor.
  TrackedFrame cover(std::uint64_t frame_id, std::uint16_t reading_mm) {
    RgbdFrame frame = *camera_->frame_at(frame_id);
    frame.depth_mm = Image<std::uint16_t>(320, 240, reading_mm);
    return process(std::move(frame));
  }

  TrackedFrame process(RgbdFrame frame) {
    now_ += kPeriod;
    frame.captured_at = now_;
    return tracker_->process(std::make_shared<const RgbdFrame>(std::move(frame))).value();
  }

  void start_at(std::uint64_t frame_id) {
    const auto frame = camera_->frame_at(frame_id);
    ASSERT_TRUE(tracker_->start_at(frame, camera_->ct_from_camera(frame_id)));
    ASSERT_EQ(show(frame_id).state, TrackingState::kTracking);
  }

  double error_mm(const TrackedFrame& tracked, std::uint64_t frame_id) const {
    const Eigen::Isometry3d truth = camera_->ct_from_camera(frame_id);
    const Eigen::Vector3d center = body_->mesh.bounds().center().cast<double>();
    return displacement_mm(*tracked.ct_from_depth, truth, truth.inverse() * center);
  }

  /// Two moments of the path between which the camera moves by at least so much.
  std::pair<std::uint64_t, std::uint64_t> far_apart(double shift_mm, double angle_rad) const {
    for (std::uint64_t a = 0; a < 900; a += 30) {
      for (std::uint64_t b = a; b < 900; b += 10) {
        const Eigen::Isometry3d moved =
            camera_->ct_from_camera(a).inverse() * camera_->ct_from_camera(b);
        if (moved.translation().norm() >= shift_mm && rotation_angle_rad(moved) >= angle_rad) {
          return {a, b};
        }
      }
    }
    ADD_FAILURE() << "the path never moves so far";
    return {0, 0};
  }

  /// Frames until it tracks at the true pose; it must never show a wrong one.
  int frames_to_tracking(std::uint64_t frame_id) {
    for (int i = 1; i <= 2 * kWithinFrames; ++i) {
      const auto tracked = show(frame_id + static_cast<std::uint64_t>(i));
      if (!tracked.ct_from_depth || tracked.is_held) continue;
      EXPECT_LT(error_mm(tracked, frame_id + static_cast<std::uint64_t>(i)), kRightMm);
      if (tracked.state == TrackingState::kTracking) return i;
    }
    return 1000;
  }

  std::shared_ptr<const FixedSurface> body_ = internal::bumpy_surface();
  std::unique_ptr<SimulatedCamera> camera_;
  std::optional<Tracker> tracker_;
  std::chrono::steady_clock::time_point now_{std::chrono::hours(1)};
};

TEST_F(ResumeTest, FollowsTheHandWithABoundAndNoDoubt) {
  start_at(0);
  for (std::uint64_t i = 1; i <= 40; ++i) {
    const auto tracked = show(i);
    ASSERT_EQ(tracked.state, TrackingState::kTracking) << "frame " << i;
    EXPECT_LT(error_mm(tracked, i), 2.0);
    ASSERT_TRUE(tracked.covariance);
    EXPECT_LT(error_bound_mm(*tracked.covariance, tracked.skin->seen_center_mm), 5.0);
  }
}

TEST_F(ResumeTest, AfterTwoSecondsCoveredTheBodyIsFoundAgainAtOnce) {
  start_at(0);
  for (int i = 0; i < 60; ++i) {
    const auto tracked = cover(1, i % 2 == 0 ? 0 : 120);
    ASSERT_NE(tracked.state, TrackingState::kTracking);
  }
  EXPECT_EQ(cover(1, 0).state, TrackingState::kLost);
  EXPECT_LE(frames_to_tracking(60), kWithinFrames);
}

TEST_F(ResumeTest, FindsTheBodyAfterTheCameraMovedFarUnseen) {
  const auto [from, to] = far_apart(400.0, 30.0 * std::numbers::pi / 180.0);
  start_at(from);
  for (int i = 0; i < 60; ++i) cover(from, 0);
  EXPECT_LE(frames_to_tracking(to), kWithinFrames);
}

/// The body sunk a little into a table of 3 x 3 m, so that one surface runs from one to the other.
TriangleMesh in_table(TriangleMesh body) {
  constexpr std::uint32_t kPieces = 30;
  constexpr float kPieceMm = 100.0F;
  const float table_y_mm = body.bounds().max().y() - 40.0F;
  const auto first = static_cast<std::uint32_t>(body.vertices.size());
  for (std::uint32_t i = 0; i <= kPieces; ++i) {
    for (std::uint32_t j = 0; j <= kPieces; ++j) {
      const auto at = [](std::uint32_t n) { return kPieceMm * (static_cast<float>(n) - 15.0F); };
      body.vertices.emplace_back(at(j), table_y_mm, at(i));
      if (i == kPieces || j == kPieces) continue;
      const std::uint32_t corner = first + i * (kPieces + 1) + j;
      body.triangles.push_back({corner, corner + 1, corner + kPieces + 1});
      body.triangles.push_back({corner + 1, corner + kPieces + 2, corner + kPieces + 1});
    }
  }
  return body;
}

/// A camera straight above.
Eigen::Isometry3d above(const Eigen::Vector3d& center_ct) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() << -1, 0, 0, 0, 0, 1, 0, 1, 0;
  pose.translation() = center_ct;
  return pose;
}

// From where the camera was, what it sees now is mostly table, which no pose of the body explains.
TEST_F(ResumeTest, FindsTheBodyAtThePicturesEdgeWhereItsMiddleShowsTheTable) {
  const TriangleMesh scene = in_table(body_->mesh);
  const auto seen_from = [&](const Eigen::Isometry3d& ct_from_depth) {
    RgbdFrame frame = *camera_->frame_at(0);
    const auto raster =
        rasterize_depth(scene, camera_->calibration().depth, ct_from_depth.inverse());
    for (std::size_t i = 0; i < frame.depth_mm.size(); ++i) {
      frame.depth_mm.data()[i] = static_cast<std::uint16_t>(std::lround(raster.depth_mm.data()[i]));
    }
    return frame;
  };
  const Eigen::Vector3d center = body_->mesh.bounds().center().cast<double>();
  const Eigen::Isometry3d before = above(center + Eigen::Vector3d(210.0, -890.0, 160.0));
  const Eigen::Isometry3d now = above(center + Eigen::Vector3d(270.0, -890.0, 85.0));
  ASSERT_TRUE(tracker_->start_at(std::make_shared<const RgbdFrame>(seen_from(before)), before));
  for (int i = 0; i < 60; ++i) cover(0, 0);
  const auto tracked = process(seen_from(now));
  ASSERT_EQ(tracked.state, TrackingState::kTracking);
  EXPECT_LT(displacement_mm(*tracked.ct_from_depth, now, now.inverse() * center), kRightMm);
}

TEST_F(ResumeTest, ABodyThatIsNotThereIsNeverFound) {
  start_at(0);
  RgbdFrame table = *camera_->frame_at(0);
  table.depth_mm = Image<std::uint16_t>(320, 240, 800);
  for (int i = 0; i < 60; ++i) {
    const auto tracked = process(table);
    EXPECT_NE(tracked.state, TrackingState::kTracking);
    EXPECT_TRUE(!tracked.ct_from_depth || tracked.is_held);
  }
}

}  // namespace
}  // namespace mor
