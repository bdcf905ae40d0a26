// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The free view against who computes the same in another way: OpenCV projects, rays are cast one by
// one through all triangles.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "morgagni/render/free_view.h"
#include "morgagni/render/testing/pictures.h"
#include "morgagni/render/testing/shapes.h"

namespace mor {
namespace {

constexpr PinholeCamera kColorCamera{
    256, 240, 240.0, 243.0, 124.0, 123.0, {-0.21, 0.06, 0.002, -0.003, 0.01}};
constexpr PinholeCamera kViewCamera{176, 160, 200.0, 200.0, 87.5, 79.5, {}};
const Eigen::Isometry3d kColorFromCt = testing::at(5.0, -8.0, 520.0);

Eigen::Vector2d projected_by_opencv(const PinholeCamera& camera, const Eigen::Vector3d& point) {
  const cv::Matx33d matrix(
      camera.focal_x_px, 0, camera.center_x_px, 0, camera.focal_y_px, camera.center_y_px, 0, 0, 1);
  const auto& d = camera.distortion;
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(std::vector<cv::Point3d>{{point.x(), point.y(), point.z()}},
                    cv::Vec3d(0, 0, 0),
                    cv::Vec3d(0, 0, 0),
                    matrix,
                    cv::Vec<double, 5>(d[0], d[1], d[2], d[3], d[4]),
                    pixels);
  return {pixels[0].x, pixels[0].y};
}

Image<Rgb8> places_picture() {
  Image<Rgb8> picture(kColorCamera.width_px, kColorCamera.height_px);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      picture(x, y) = {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y), 200};
    }
  }
  return picture;
}

Eigen::Isometry3d view_from(double yaw_rad, double pitch_rad) {
  Eigen::Isometry3d view_from_ct = testing::at(0.0, 0.0, 520.0);
  view_from_ct.rotate(Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitX()));
  view_from_ct.rotate(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitY()));
  return view_from_ct;
}

struct Scene {
  TriangleMesh skin;
  Image<Rgb8> color = places_picture();
  FreeView view;

  Scene(TriangleMesh mesh, double yaw_rad, double pitch_rad) : skin(std::move(mesh)) {
    view.camera = kViewCamera;
    view.view_from_ct = view_from(yaw_rad, pitch_rad);
    view.picture = {.color = color.view(), .camera = kColorCamera, .color_from_ct = kColorFromCt};
  }

  [[nodiscard]] Eigen::Vector3d ray(int x, int y) const {
    return view.view_from_ct.inverse().linear() *
           kViewCamera.ray(Eigen::Vector2d(x, y)).homogeneous();
  }
  [[nodiscard]] Eigen::Vector3d eye() const { return view.view_from_ct.inverse().translation(); }
};

TEST(PinholeCamera, ProjectsAsOpencvDoes) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> beside(-200.0, 200.0);
  std::uniform_real_distribution<double> away(350.0, 900.0);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d point(beside(random), beside(random), away(random));
    const Eigen::Vector2d ours = kColorCamera.project(point).value();
    ASSERT_LT((ours - projected_by_opencv(kColorCamera, point)).norm(), 1e-9) << point.transpose();
  }
}

/// Equations (3) and (4) with distortion, through the shader: a colour says where it was taken.
TEST(FreeViewTruth, EachPixelOfTheSkinHasTheColorFromWhereOpencvProjectsIt) {
  for (const double yaw : {-0.6, 0.0, 0.5}) {
    const Scene scene(testing::make_sphere({0, 0, 0}, 110.0, 64), yaw, 0.3);
    auto renderer = FreeViewRenderer::create({.structures = {}, .skin = scene.skin}).value();
    const FreePicture shown = renderer->render(scene.view).value();
    int num_compared = 0;
    for (int y = 0; y < shown.picture.height(); ++y) {
      for (int x = 0; x < shown.picture.width(); ++x) {
        if (shown.depth_mm(x, y) <= 0.0F) continue;
        const Eigen::Vector3d ct = scene.eye() + shown.depth_mm(x, y) * scene.ray(x, y);
        const Eigen::Vector3d to_color = kColorFromCt.inverse().translation() - ct;
        const Eigen::Vector3d to_view = scene.eye() - ct;
        // Where it turns away from the colour camera it fades, and the view's outline is softened.
        if (ct.normalized().dot(to_color.normalized()) < 0.3) continue;
        if (ct.normalized().dot(to_view.normalized()) < 0.3) continue;
        const auto at = projected_by_opencv(kColorCamera, kColorFromCt * ct);
        ASSERT_NEAR(shown.picture(x, y).r, at.x(), 0.6) << "yaw " << yaw << ": " << x << ", " << y;
        ASSERT_NEAR(shown.picture(x, y).g, at.y(), 0.6) << "yaw " << yaw << ": " << x << ", " << y;
        ++num_compared;
      }
    }
    EXPECT_GT(num_compared, 3000);
  }
}

/// A body with parts before it, as arms before a chest: two balls, a ring, a bumpy trunk.
TriangleMesh body_with_parts() {
  TriangleMesh mesh = testing::closed_grid(48, 60, [](double u, double v) -> Eigen::Vector3d {
    // A trunk that is closed on itself both ways: a thick ring whose tube has bumps.
    const double tube = 34.0 + 4.0 * std::sin(5.0 * u) * std::cos(3.0 * v);
    const double r = 70.0 + tube * std::cos(v);
    return {r * std::cos(u), r * std::sin(u), tube * std::sin(v)};
  });
  testing::append(mesh, testing::make_sphere({15.0, 0.0, -75.0}, 24.0, 22));
  testing::append(mesh, testing::make_sphere({-55.0, 40.0, -60.0}, 16.0, 18));
  testing::append(mesh, testing::make_torus({-20.0, -45.0, -55.0}, 22.0, 6.0, 40, 24));
  return mesh;
}

struct Meeting {
  double along;  ///< In lengths of the ray.
  Eigen::Vector3d normal;
};

/// All that a ray meets, nearest first (Moeller and Trumbore 1997).
std::vector<Meeting> meetings(const TriangleMesh& mesh,
                              const Eigen::Vector3d& from,
                              const Eigen::Vector3d& ray) {
  std::vector<Meeting> found;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[i].cast<double>();
    const Eigen::Vector3d ab = mesh.vertices[j].cast<double>() - a;
    const Eigen::Vector3d ac = mesh.vertices[k].cast<double>() - a;
    const Eigen::Vector3d p = ray.cross(ac);
    const double det = ab.dot(p);
    if (std::abs(det) < 1e-12) continue;
    const double u = (from - a).dot(p) / det;
    if (u < 0.0 || u > 1.0) continue;
    const Eigen::Vector3d q = (from - a).cross(ab);
    const double v = ray.dot(q) / det;
    if (v < 0.0 || u + v > 1.0) continue;
    const double along = ac.dot(q) / det;
    if (along > 1e-9) found.push_back({along, ab.cross(ac).normalized()});
  }
  std::sort(
      found.begin(), found.end(), [](const auto& a, const auto& b) { return a.along < b.along; });
  return found;
}

struct Truth {
  bool is_in_color = false;
  double depth_mm = 0.0;  ///< Of what the ray meets first; 0: nothing.
  double facing = 1.0;    ///< To the colour camera, of the point in colour.
};

/// What a pixel shows: the first point of the skin on its ray whose outer side is seen by both
/// cameras; nothing, where the ray meets an inner side before.
Truth truth_at(const Scene& scene, int x, int y) {
  const Eigen::Vector3d ray = scene.ray(x, y);
  const Eigen::Vector3d eye = kColorFromCt.inverse().translation();
  Truth truth;
  for (const Meeting& meeting : meetings(scene.skin, scene.eye(), ray)) {
    if (truth.depth_mm == 0.0) truth.depth_mm = meeting.along;
    if (meeting.normal.dot(ray) > 0.0) return truth;
    const Eigen::Vector3d point = scene.eye() + meeting.along * ray;
    const Eigen::Vector3d way = point - eye;
    truth.facing = -meeting.normal.dot(way.normalized());
    if (truth.facing <= 0.0) continue;
    const auto before = meetings(scene.skin, eye, way);
    if (!before.empty() && before.front().along < 1.0 - 1e-6) continue;
    const auto at = kColorCamera.project(kColorFromCt * point);
    truth.is_in_color = at && at->x() >= 0.0 && at->y() >= 0.0 &&
                        at->x() <= kColorCamera.width_px - 1.0 &&
                        at->y() <= kColorCamera.height_px - 1.0;
    if (truth.is_in_color) return truth;
  }
  return truth;
}

/// Whether within `reach` pixels of (x, y) there is an edge: in colour or not, nearer or farther.
bool is_edge(const Image<Truth>& truth, int x, int y, int reach) {
  const Truth& here = truth(x, y);
  for (int v = y - reach; v <= y + reach; ++v) {
    for (int u = x - reach; u <= x + reach; ++u) {
      if (!truth.view().contains(u, v)) continue;
      const Truth& there = truth(u, v);
      if (there.is_in_color != here.is_in_color) return true;
      if (std::abs(there.depth_mm - here.depth_mm) > 8.0) return true;
    }
  }
  return false;
}

TEST(FreeViewTruth, WhatIsCutAwayIsWhatRaysSayThatTheColorCameraDoesNotSee) {
  constexpr int kEdgePx = 2;
  for (const double yaw : {-0.9, 0.0, 0.6}) {
    const Scene scene(body_with_parts(), yaw, 0.15);
    auto renderer = FreeViewRenderer::create({.structures = {}, .skin = scene.skin}).value();
    const FreePicture shown = renderer->render(scene.view).value();
    Image<Truth> truth(kViewCamera.width_px, kViewCamera.height_px);
    for (int y = 0; y < truth.height(); ++y) {
      for (int x = 0; x < truth.width(); ++x) truth(x, y) = truth_at(scene, x, y);
    }
    int num_in_color = 0;
    int num_wrong = 0;
    for (int y = 0; y < truth.height(); ++y) {
      for (int x = 0; x < truth.width(); ++x) {
        const Truth& here = truth(x, y);
        num_in_color += here.is_in_color ? 1 : 0;
        const bool is_in_color = shown.picture(x, y).b > 100;
        if (is_in_color == here.is_in_color || here.facing < 0.2) continue;  // It fades there.
        ++num_wrong;
        EXPECT_TRUE(is_edge(truth, x, y, kEdgePx))
            << "yaw " << yaw << ": " << x << ", " << y << ", truth " << here.is_in_color
            << ", blue " << int{shown.picture(x, y).b} << ", facing " << here.facing;
      }
    }
    EXPECT_GT(num_in_color, 1500) << yaw;
    EXPECT_LT(num_wrong, 0.015 * num_in_color) << yaw;
  }
}

}  // namespace
}  // namespace mor
