// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/frame_difficulty.h"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "morgagni/geometry/depth_raster.h"
#include "morgagni/registration/testing/test_body.h"

namespace mor {
namespace {

/// 240 pixels high times `factor`, the same field of view.
PinholeCamera camera_of(double factor) {
  return {static_cast<int>(320 * factor),
          static_cast<int>(240 * factor),
          262.5 * factor,
          262.5 * factor,
          160.0 * factor - 0.5,
          120.0 * factor - 0.5,
          {}};
}

Image<std::uint16_t> seen(const TriangleMesh& mesh,
                          const PinholeCamera& camera,
                          const Eigen::Isometry3d& ct_from_depth) {
  const DepthRaster raster = rasterize_depth(mesh, camera, ct_from_depth.inverse());
  Image<std::uint16_t> depth(camera.width_px, camera.height_px);
  for (std::size_t i = 0; i < depth.size(); ++i) {
    depth.data()[i] = static_cast<std::uint16_t>(std::lround(raster.depth_mm.data()[i]));
  }
  return depth;
}

class FrameDifficultyTest : public testing::Test {
 protected:
  [[nodiscard]] FrameDifficulty of(const Image<std::uint16_t>& depth,
                                   const PinholeCamera& camera) const {
    return frame_difficulty(body_->mesh, depth.view(), camera, truth_, targets_);
  }

  static inline const std::shared_ptr<const FixedSurface> body_ = internal::bumpy_surface();
  Eigen::Isometry3d truth_ = internal::camera_before_body();
  std::vector<Target> targets_ = {{"center", false, body_->mesh.bounds().center().cast<double>()}};
};

TEST_F(FrameDifficultyTest, FindsAnUncoveredBodyBareAndSmallErrorsPossible) {
  const PinholeCamera camera = camera_of(2.0);
  const FrameDifficulty difficulty = of(seen(body_->mesh, camera, truth_), camera);
  EXPECT_DOUBLE_EQ(difficulty.bare_share, 1.0);
  // Some 40,000 readings of 1.3 mm.
  EXPECT_GT(difficulty.least_tre_mm, 0.01);
  EXPECT_LT(difficulty.least_tre_mm, 0.1);
}

TEST_F(FrameDifficultyTest, CoversHalfOfTheBodyAndLeavesLessToGoBy) {
  const PinholeCamera camera = camera_of(1.0);
  Image<std::uint16_t> depth = seen(body_->mesh, camera, truth_);
  const double open_mm = of(depth, camera).least_tre_mm;
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width() / 2; ++x) depth(x, y) = 450;
  }
  const FrameDifficulty covered = of(depth, camera);
  EXPECT_NEAR(covered.bare_share, 0.5, 0.2);
  EXPECT_GT(covered.least_tre_mm, 1.3 * open_mm);
}

TEST_F(FrameDifficultyTest, HalvesTheBoundWithFourTimesThePixels) {
  const PinholeCamera coarse = camera_of(1.0);
  const PinholeCamera fine = camera_of(2.0);
  const double ratio = of(seen(body_->mesh, fine, truth_), fine).least_tre_mm /
                       of(seen(body_->mesh, coarse, truth_), coarse).least_tre_mm;
  // Finer pixels stray less to the side, so somewhat more than by half.
  EXPECT_GT(ratio, 0.25);
  EXPECT_LT(ratio, 0.52);
}

TEST_F(FrameDifficultyTest, TakesTheInsideOfTheBodyForNoSkin) {
  const PinholeCamera camera = camera_of(1.0);
  TriangleMesh inside_out = body_->mesh;
  for (auto& [a, b, c] : inside_out.triangles) std::swap(b, c);
  const FrameDifficulty difficulty = frame_difficulty(
      inside_out, seen(body_->mesh, camera, truth_).view(), camera, truth_, targets_);
  EXPECT_EQ(difficulty.bare_share, 0.0);
  EXPECT_TRUE(std::isinf(difficulty.least_tre_mm));
}

TEST_F(FrameDifficultyTest, HasNoBoundWhereNothingIsSeen) {
  const PinholeCamera camera = camera_of(1.0);
  const Image<std::uint16_t> nothing(camera.width_px, camera.height_px, 0);
  const FrameDifficulty difficulty = of(nothing, camera);
  EXPECT_EQ(difficulty.bare_share, 0.0);
  EXPECT_TRUE(std::isinf(difficulty.least_tre_mm));
}

TEST(FrameDifficulty, LeavesAPlaneOpen) {
  TriangleMesh plane;
  plane.vertices = {{-400, -400, 0}, {400, -400, 0}, {400, 400, 0}, {-400, 400, 0}};
  plane.normals.assign(4, Eigen::Vector3f(0, 0, -1));
  plane.triangles = {{0, 2, 1}, {0, 3, 2}};
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  truth.translation().z() = -700.0;
  const PinholeCamera camera = camera_of(1.0);
  const auto depth = seen(plane, camera, truth);
  const FrameDifficulty difficulty =
      frame_difficulty(plane, depth.view(), camera, truth, {{"a", false, {0.0, 0.0, 50.0}}});
  EXPECT_EQ(difficulty.bare_share, 1.0);
  EXPECT_TRUE(std::isinf(difficulty.least_tre_mm));
}

}  // namespace
}  // namespace mor
