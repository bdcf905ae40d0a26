// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/start_evaluation.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "morgagni/camera/simulated_camera.h"
#include "morgagni/registration/testing/test_body.h"

namespace mor {
namespace {

/// The bumpy body with a head and a hip: without them it looks alike from several sides.
std::shared_ptr<const FixedSurface> lopsided_surface() {
  auto surface = std::make_shared<FixedSurface>();
  surface->mesh = internal::bumpy_body(100, Eigen::Vector3f::Zero());
  for (auto& vertex : surface->mesh.vertices) {
    const Eigen::Vector3f d = vertex.normalized();
    const auto near = [&d](const Eigen::Vector3f& at) {
      return std::exp(-(d - at.normalized()).squaredNorm() / 0.18F);
    };
    vertex += 60.0F * near({0.3F, -0.2F, 0.9F}) * Eigen::Vector3f(0.3F, -0.1F, 0.9F) +
              45.0F * near({-0.9F, -0.2F, -0.4F}) * Eigen::Vector3f(-1.0F, 0.0F, -0.2F);
  }
  surface->mesh.normals = vertex_normals(surface->mesh);
  surface->field = *DistanceField::build(surface->mesh);
  return surface;
}

std::unique_ptr<SimulatedCamera> camera_over(const std::shared_ptr<const FixedSurface>& body,
                                             const char* keys) {
  return *SimulatedCamera::create(std::shared_ptr<const TriangleMesh>(body, &body->mesh),
                                  *SimulatedCameraOptions::parse(keys));
}

StartViews views_of(const SimulatedCamera& camera, const Eigen::Isometry3d& truth_error) {
  return [&camera, truth_error](std::size_t i, std::size_t /*frame*/) -> Result<StartView> {
    return StartView{camera.frame_at(i), truth_error * camera.ct_from_camera(i)};
  };
}

TEST(StartEvaluation, GuardsTheRatesOverRandomViews) {
  const auto body = lopsided_surface();
  const auto plain = camera_over(body, "path=views,seed=31");
  const auto with_hand = camera_over(body, "path=views,seed=32,clutter=hand");
  for (const auto* camera : {plain.get(), with_hand.get()}) {
    const auto report =
        evaluate_starts(views_of(*camera, Eigen::Isometry3d::Identity()), 16, body, {}, {});
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->num_views, 16);
    EXPECT_GE(report->num_right, camera == plain.get() ? 15 : 13) << to_table(*report);
    EXPECT_EQ(report->num_wrong, 0) << to_table(*report);
    EXPECT_LT(report->shift_mm.median, 1.5);
    EXPECT_LT(report->fine_tre_mm.median, 2.0);
    EXPECT_GT(report->wall_ms.median, 0.0);
  }
}

TEST(StartEvaluation, CountsAFoundPoseFarFromTheTruthAsWrong) {
  const auto body = lopsided_surface();
  const auto camera = camera_over(body, "path=views,seed=31");
  const Eigen::Isometry3d far(Eigen::Translation3d(40.0, 0.0, 0.0));
  const Eigen::Isometry3d near(Eigen::Translation3d(8.0, 0.0, 0.0));
  const auto wrong = evaluate_starts(views_of(*camera, far), 2, body, {}, {});
  ASSERT_TRUE(wrong);
  EXPECT_EQ(wrong->num_wrong, 2);
  EXPECT_EQ(wrong->num_right, 0);
  EXPECT_NEAR(wrong->shift_mm.median, 40.0, 2.0);
  const auto neither = evaluate_starts(views_of(*camera, near), 2, body, {}, {});
  ASSERT_TRUE(neither);
  EXPECT_EQ(neither->num_near, 2);
  const auto json = nlohmann::json::parse(to_json(*neither));
  EXPECT_EQ(json["near"], 2);
  EXPECT_EQ(json["runs"].size(), 2);
  EXPECT_EQ(json["runs"][0]["status"], "found");
}

TEST(StartEvaluation, GoesOnInTheNextPictureUntilItHasFound) {
  const auto body = lopsided_surface();
  const auto camera = camera_over(body, "path=views,hold=3,fps=5,seed=31");
  const StartViews views = [&](std::size_t i, std::size_t frame) -> Result<StartView> {
    auto seen = camera->frame_at(3 * i + frame);
    if (frame == 0) {  // Nothing to be seen yet.
      auto covered = std::make_shared<RgbdFrame>(*seen);
      covered->depth_mm = Image<std::uint16_t>(640, 480, 0);
      seen = covered;
    }
    return StartView{seen, camera->ct_from_camera(3 * i + frame)};
  };
  const auto report = evaluate_starts(views, 2, body, {.frames_a_view = 3}, {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->num_right, 2);
  EXPECT_EQ(report->num_right_by_frame, (std::vector{0, 2, 2}));
  EXPECT_EQ(report->runs[0].num_frames, 2U);
  EXPECT_GT(report->runs[0].until_ms, 200.0);
  EXPECT_THAT(to_table(*report), testing::HasSubstr("right within 2 pictures"));
  const auto refused = evaluate_starts(views, 2, body, {}, {});
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->num_not_found, 2);
}

TEST(StartEvaluation, SaysWhatIsWrongWithItsInput) {
  const auto body = lopsided_surface();
  const auto camera = camera_over(body, "path=views,seed=31");
  const auto views = views_of(*camera, Eigen::Isometry3d::Identity());
  const auto none = evaluate_starts(views, 0, body, {}, {});
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message, testing::HasSubstr("at least one view"));
  const auto bad = evaluate_starts(views, 1, body, {.right_mm = 0.0}, {});
  ASSERT_FALSE(bad);
  EXPECT_THAT(bad.error().message, testing::HasSubstr("right_mm"));
  const auto no_frame = evaluate_starts(views, 1, body, {.frames_a_view = 0}, {});
  ASSERT_FALSE(no_frame);
  EXPECT_THAT(no_frame.error().message, testing::HasSubstr("frames_a_view must be in [1, 100]"));
}

}  // namespace
}  // namespace mor
