// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/skin_glance.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "morgagni/registration/testing/test_body.h"

namespace mor::internal {
namespace {

constexpr float kToleranceMm = 6.0F;
constexpr float kEveryVertexMm = 0.01F;  ///< So small a spacing takes all of them.

Eigen::Isometry3d camera() {
  return Eigen::Isometry3d(Eigen::Translation3d(10.0, -20.0, -570.0)) *
         Eigen::AngleAxisd(0.1, Eigen::Vector3d(1.0, 2.0, 3.0).normalized());
}

/// Readings that lie on the body at one pose here, behind or before it there, and are missing
/// elsewhere.
StartPicture picture_of(const TriangleMesh& body) {
  StartPicture picture;
  picture.camera = {.width_px = 80,
                    .height_px = 60,
                    .focal_x_px = 140.0,
                    .focal_y_px = 141.0,
                    .center_x_px = 39.0,
                    .center_y_px = 30.5};
  picture.z_mm = Image<float>(80, 60, 0.0F);
  const Eigen::Isometry3f depth_from_ct = camera().inverse().cast<float>();
  for (const auto& vertex : body.vertices) {
    const Eigen::Vector3f p = depth_from_ct * vertex;
    const int x = static_cast<int>(140.0F * p.x() / p.z() + 39.5F);
    const int y = static_cast<int>(141.0F * p.y() / p.z() + 31.0F);
    if (x < 0 || y < 0 || x >= 80 || y >= 60) continue;
    float& reading = picture.z_mm(x, y);
    if (reading == 0.0F || p.z() < reading) reading = p.z();
  }
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 80; ++x) {
      if (x % 7 == 0) picture.z_mm(x, y) *= 1.05F;
      if (y % 5 == 0) picture.z_mm(x, y) *= 0.97F;
      if ((x + y) % 11 == 0) picture.z_mm(x, y) = 0.0F;
    }
  }
  return picture;
}

/// The same, point by point.
SkinAgreement one_by_one(const TriangleMesh& body,
                         const StartPicture& picture,
                         const Eigen::Isometry3d& ct_from_depth) {
  SkinAgreement sum;
  const Eigen::Vector3d eye = ct_from_depth.translation();
  for (std::size_t i = 0; i < body.vertices.size(); ++i) {
    const Eigen::Vector3d vertex = body.vertices[i].cast<double>();
    if (body.normals[i].cast<double>().dot((eye - vertex).normalized()) < 0.3) continue;
    const Eigen::Vector3d p = ct_from_depth.inverse() * vertex;
    if (p.z() < 1.0) continue;
    const auto& pinhole = picture.camera;
    const double x = std::floor(pinhole.focal_x_px * p.x() / p.z() + pinhole.center_x_px + 0.5);
    const double y = std::floor(pinhole.focal_y_px * p.y() / p.z() + pinhole.center_y_px + 0.5);
    if (x < 0 || y < 0 || x >= picture.z_mm.width() || y >= picture.z_mm.height()) continue;
    const double reading = picture.z_mm(static_cast<int>(x), static_cast<int>(y));
    if (reading == 0.0) continue;
    sum.num_seen += 1.0;
    if (reading > p.z() + 1.2 * kToleranceMm) {
      sum.num_floating += 1.0;
    } else if (reading < p.z() - kToleranceMm) {
      sum.num_hidden += 1.0;
    } else {
      const double ratio = std::min(1.0, std::abs(reading - p.z()) / kToleranceMm);
      sum.num_agree += std::pow(1.0 - ratio * ratio, 2);
    }
  }
  return sum;
}

TEST(SkinGlance, CountsAsOneByOneForAnyNumberOfPoints) {
  const TriangleMesh whole = bumpy_body(60, Eigen::Vector3f(10.0F, -20.0F, 30.0F));
  const StartPicture picture = picture_of(whole);
  for (const std::size_t num_left_out : {0U, 1U, 5U, 7U, 8U}) {
    TriangleMesh body = whole;
    body.vertices.resize(whole.vertices.size() - num_left_out);
    body.normals.resize(body.vertices.size());
    const SkinGlance glance(body, kEveryVertexMm);
    for (const double shift_mm : {0.0, -4.0, 9.0, 60.0, 400.0}) {
      const Eigen::Isometry3d pose = Eigen::Translation3d(0.3 * shift_mm, 0.0, shift_mm) * camera();
      const SkinAgreement agreement = glance.at(picture, pose, kToleranceMm);
      const SkinAgreement expected = one_by_one(body, picture, pose);
      // A point on the border of a pixel or a limit may fall to either side in single precision.
      EXPECT_NEAR(agreement.num_seen, expected.num_seen, 2.0) << shift_mm;
      EXPECT_NEAR(agreement.num_floating, expected.num_floating, 2.0) << shift_mm;
      EXPECT_NEAR(agreement.num_hidden, expected.num_hidden, 2.0) << shift_mm;
      EXPECT_NEAR(agreement.num_agree, expected.num_agree, 2.0) << shift_mm;
    }
  }
  const SkinAgreement at_pose = one_by_one(whole, picture, camera());
  EXPECT_GT(at_pose.num_agree, 100.0);
  EXPECT_GT(at_pose.num_floating, 20.0);
  EXPECT_GT(at_pose.num_hidden, 20.0);
}

TEST(SkinGlance, SeesNothingOfABodyBehindTheCameraOrTurnedAway) {
  const TriangleMesh body = bumpy_body(60, Eigen::Vector3f(10.0F, -20.0F, 30.0F));
  const StartPicture picture = picture_of(body);
  const SkinGlance glance(body, kEveryVertexMm);
  const Eigen::Isometry3d turned(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitY()));
  EXPECT_EQ(glance.at(picture, camera() * turned, kToleranceMm).num_seen, 0.0);
  const Eigen::Isometry3d inside(Eigen::Translation3d(10.0, -20.0, 30.0));
  EXPECT_EQ(glance.at(picture, inside, kToleranceMm).num_seen, 0.0);
}

TEST(SkinGlance, TakesOneVertexOfEachCube) {
  const TriangleMesh body = bumpy_body(60, Eigen::Vector3f::Zero());
  const StartPicture picture = picture_of(body);
  const double all = SkinGlance(body, kEveryVertexMm).at(picture, camera(), 1e6F).num_seen;
  const double some = SkinGlance(body, 40.0F).at(picture, camera(), 1e6F).num_seen;
  EXPECT_GT(some, 3.0);
  EXPECT_LT(some, 0.5 * all);
}

}  // namespace
}  // namespace mor::internal
