// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/depth/body_surface.h"

#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

const PinholeCamera kKinect{640, 480, 525.0, 525.0, 319.5, 239.5, {}};

using DepthImage = Image<std::uint16_t>;

/// Depth where the ray of each pixel meets the plane n . p = d.
DepthImage plane_image(const PinholeCamera& camera, const Eigen::Vector3d& normal, double d) {
  DepthImage image(camera.width_px, camera.height_px);
  for (int y = 0; y < camera.height_px; ++y) {
    for (int x = 0; x < camera.width_px; ++x) {
      const Eigen::Vector2d ray = camera.ray({x, y});
      const double z = d / normal.dot(Eigen::Vector3d(ray.x(), ray.y(), 1.0));
      if (z > 0.0 && z < 60000.0) image(x, y) = static_cast<std::uint16_t>(std::lround(z));
    }
  }
  return image;
}

/// Depth of a sphere, 0 around it.
DepthImage sphere_image(const Eigen::Vector3d& center, double radius_mm) {
  DepthImage image(kKinect.width_px, kKinect.height_px);
  for (int y = 0; y < kKinect.height_px; ++y) {
    for (int x = 0; x < kKinect.width_px; ++x) {
      const Eigen::Vector2d xy = kKinect.ray({x, y});
      const Eigen::Vector3d ray(xy.x(), xy.y(), 1.0);
      const double b = ray.dot(center) / ray.squaredNorm();
      const double c = (center.squaredNorm() - radius_mm * radius_mm) / ray.squaredNorm();
      if (b * b > c)
        image(x, y) = static_cast<std::uint16_t>(std::lround(b - std::sqrt(b * b - c)));
    }
  }
  return image;
}

BodySurface extract(const DepthImage& image,
                    const BodySurfaceOptions& options = {},
                    const PinholeCamera& camera = kKinect) {
  auto extractor = BodySurfaceExtractor::create(camera, options);
  EXPECT_TRUE(extractor) << extractor.error().message;
  auto surface = extractor->extract(image.view());
  EXPECT_TRUE(surface) << surface.error().message;
  return *std::move(surface);
}

double angle_deg(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return std::acos(std::clamp(a.dot(b), -1.0F, 1.0F)) * 180.0 / std::numbers::pi;
}

TEST(BodySurface, PutsEveryPointOfAPlaneOnThePlaneAtEveryFactor) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.2, 1.0).normalized();
  const DepthImage image = plane_image(kKinect, normal, 650.0);
  for (const double factor : {1.0, 1.7, 2.0, 2.5, 4.0}) {
    const BodySurface surface = extract(image, {.max_edge_mm = 20.0, .down_sampling = factor});
    const int columns = static_cast<int>(std::floor(639.49 / factor)) + 1;
    const int rows = static_cast<int>(std::floor(479.49 / factor)) + 1;
    EXPECT_EQ(surface.cloud.size(), static_cast<std::size_t>(columns * rows)) << factor;
    EXPECT_EQ(surface.triangles.size(), static_cast<std::size_t>(2 * (columns - 1) * (rows - 1)));
    for (const auto& point : surface.cloud.points) {
      ASSERT_NEAR(normal.cast<float>().dot(point), 650.0F, 0.6F);
    }
  }
}

TEST(BodySurface, TurnsNormalsOfATiltedPlaneToTheCamera) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.5, 0.3, 1.0).normalized();
  const BodySurface surface = extract(plane_image(kKinect, normal, 600.0));
  double sum_deg = 0.0;
  double worst_deg = 0.0;
  for (const auto& found : surface.cloud.normals) {
    ASSERT_NEAR(found.norm(), 1.0F, 1e-4F);
    const double off_deg = angle_deg(found, -normal.cast<float>());
    sum_deg += off_deg;
    worst_deg = std::max(worst_deg, off_deg);
  }
  // Depth comes in whole millimetres; the worst windows are cut by the picture's corners.
  EXPECT_LT(sum_deg / static_cast<double>(surface.cloud.size()), 1.0);
  EXPECT_LT(worst_deg, 10.0);
}

TEST(BodySurface, GivesTheNormalsOfASphere) {
  const Eigen::Vector3d center(20.0, -10.0, 800.0);
  const BodySurface surface = extract(sphere_image(center, 120.0));
  ASSERT_GT(surface.cloud.size(), 2000U);
  int num_bad = 0;
  for (std::size_t i = 0; i < surface.cloud.size(); ++i) {
    const Eigen::Vector3f truth = (surface.cloud.points[i] - center.cast<float>()).normalized();
    EXPECT_LT(surface.cloud.normals[i].dot(surface.cloud.points[i]), 0.0F);
    if (angle_deg(surface.cloud.normals[i], truth) > 8.0) ++num_bad;
  }
  // At the rim the window is cut and the slope steep.
  EXPECT_LT(num_bad, static_cast<int>(surface.cloud.size()) / 20);
}

TEST(BodySurface, AveragesTheReadingsBetweenItsPoints) {
  // Head on, noise of even steps.
  DepthImage image(kKinect.width_px, kKinect.height_px, 800);
  std::mt19937 random(7);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      image(x, y) = static_cast<std::uint16_t>(797 + random() % 7U);
    }
  }
  const auto deviation_mm = [&image](bool averages) {
    const BodySurface surface = extract(image, {.averages = averages});
    double sum_sq = 0.0;
    for (const auto& point : surface.cloud.points) {
      sum_sq += std::pow(static_cast<double>(point.z()) - 800.0, 2.0);
    }
    return std::sqrt(sum_sq / static_cast<double>(surface.cloud.size()));
  };
  EXPECT_NEAR(deviation_mm(false), 2.0, 0.05);
  // A reading that belongs to one point and one that two or four share: 3/8 of it, and a fifth more
  // by what is taken from the neighbours.
  EXPECT_NEAR(deviation_mm(true), 0.455 * 2.0, 0.03);
}

TEST(BodySurface, WeighsAllReadingsAlike) {
  // One column, then the next, is 4 mm farther: whichever it is, the mean over the surface moves as
  // much.
  for (const double factor : {1.5, 2.0, 2.5, 3.0, 3.5, 4.0}) {
    for (int column = 300; column < 306; ++column) {
      DepthImage image(kKinect.width_px, kKinect.height_px, 800);
      for (int y = 0; y < image.height(); ++y) image(column, y) = 804;
      double sum_mm = 0.0;
      for (const auto& point : extract(image, {.down_sampling = factor}).cloud.points) {
        sum_mm += static_cast<double>(point.z()) - 800.0;
      }
      // Readings stand for factor^2 pixels; the picture's first and last row have no box of theirs.
      const double total_mm = sum_mm * factor * factor / image.height();
      EXPECT_NEAR(total_mm, 4.0, 0.2) << factor << ", column " << column;
    }
  }
}

TEST(BodySurface, LeavesACurvedSurfaceWhereItIs) {
  // The mean over a pixel's neighbours lies inside a sphere: by 0.03 mm here, were it left so.
  const Eigen::Vector3d center(0.0, 0.0, 800.0);
  const DepthImage image = sphere_image(center, 40.0);
  const auto off_mm = [&](double factor) {
    double sum = 0.0;
    int count = 0;
    for (const auto& point : extract(image, {.down_sampling = factor}).cloud.points) {
      const Eigen::Vector3d from_center = point.cast<double>() - center;
      if (from_center.z() > -25.0) continue;
      sum += from_center.norm() - 40.0;
      ++count;
    }
    EXPECT_GT(count, 150);
    return sum / count;
  };
  EXPECT_NEAR(off_mm(2.0), 0.0, 0.012);
  EXPECT_NEAR(off_mm(2.5), 0.0, 0.015);
}

TEST(BodySurface, TakesTheRoundingOfADisparitySensorOut) {
  // A steep floor, 0.65 to 1.4 m away, told in a Kinect's steps and whole millimetres.
  constexpr double kK = 348e3;
  const Eigen::Vector3d normal = Eigen::Vector3d(0.0, 0.75, 1.0).normalized();
  DepthImage image(640, 480);
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise_mm(0.0, 2.0);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const Eigen::Vector2d ray = kKinect.ray({x, y});
      const double mm = 700.0 / normal.dot(Eigen::Vector3d(ray.x(), ray.y(), 1.0));
      const double step = std::round(kK / (mm + noise_mm(random)));
      image(x, y) = static_cast<std::uint16_t>(std::lround(kK / step));
    }
  }
  const BodySurface surface =
      extract(image, {.far_mm = 1500.0, .max_edge_mm = 30.0, .down_sampling = 2.5});
  // Over 20 mm of depth there are few steps: their rounding shows as up to 0.3 mm. The noise of a
  // band's mean is 0.03 mm.
  std::map<int, std::pair<double, int>> off_mm;
  for (const auto& point : surface.cloud.points) {
    auto& [sum, count] = off_mm[static_cast<int>(point.z() / 20.0F)];
    sum += normal.cast<float>().dot(point) - 700.0F;
    ++count;
  }
  int num_bands = 0;
  for (const auto& [band, off] : off_mm) {
    if (off.second < 500) continue;
    ++num_bands;
    EXPECT_LT(std::abs(off.first / off.second), 0.1) << 20 * band << " mm";
  }
  EXPECT_GT(num_bands, 10);
}

TEST(BodySurface, AveragesNeitherAcrossAStepNorOverHoles) {
  DepthImage image(kKinect.width_px, kKinect.height_px, 700);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      if (x >= 320) image(x, y) = 720;
      if ((x + 3 * y) % 11 == 0) image(x, y) = 0;
    }
  }
  const BodySurface surface = extract(image, {.max_edge_mm = 30.0});
  ASSERT_GT(surface.cloud.size(), 30000U);
  for (const auto& point : surface.cloud.points) {
    ASSERT_TRUE(point.z() == 700.0F || point.z() == 720.0F) << point.z();
  }
}

TEST(BodySurface, GivesSingleReadingsWhereAskedTo) {
  const DepthImage image = plane_image(kKinect, Eigen::Vector3d(0.5, 0.3, 1.0).normalized(), 600.0);
  for (const auto& point : extract(image, {.averages = false}).cloud.points) {
    ASSERT_EQ(point.z(), std::round(point.z()));
  }
}

TEST(BodySurface, FacesTrianglesToTheCameraWithoutRepeatingAny) {
  const BodySurface surface = extract(sphere_image({0.0, 0.0, 700.0}, 100.0));
  std::set<Triangle> seen;
  for (const auto& triangle : surface.triangles) {
    const Eigen::Vector3f& a = surface.cloud.points.at(triangle[0]);
    const Eigen::Vector3f& b = surface.cloud.points.at(triangle[1]);
    const Eigen::Vector3f& c = surface.cloud.points.at(triangle[2]);
    ASSERT_LT((b - a).cross(c - a).dot(a), 0.0F);
    ASSERT_LE(std::max({(a - b).norm(), (b - c).norm(), (c - a).norm()}), 10.0F);
    ASSERT_TRUE(seen.insert(triangle).second);
  }
}

TEST(BodySurface, UndoesLensDistortion) {
  PinholeCamera camera = kKinect;
  camera.distortion = {0.1, -0.2, 0.001, -0.002, 0.05};
  const Eigen::Vector3d normal = Eigen::Vector3d(-0.2, 0.4, 1.0).normalized();
  const BodySurface surface = extract(plane_image(camera, normal, 700.0), {}, camera);
  for (std::size_t i = 0; i < surface.cloud.size(); ++i) {
    ASSERT_NEAR(normal.cast<float>().dot(surface.cloud.points[i]), 700.0F, 0.6F);
    ASSERT_LT(angle_deg(surface.cloud.normals[i], -normal.cast<float>()), 6.0);
  }
}

TEST(BodySurface, KeepsOnlyThePartThatHoldsTheCenter) {
  DepthImage image(640, 480, 900);
  for (int y = 100; y < 380; ++y) {
    for (int x = 200; x < 440; ++x) image(x, y) = 700;
  }
  const BodySurface surface = extract(image, {.down_sampling = 1.0});
  EXPECT_EQ(surface.cloud.size(), 280U * 240U);
  for (const auto& point : surface.cloud.points) ASSERT_EQ(point.z(), 700.0F);
}

TEST(BodySurface, GrowsFromTheNearestReadingWhereTheCenterHasNone) {
  DepthImage image(640, 480, 0);
  for (int y = 200; y < 280; ++y) {
    for (int x = 350; x < 400; ++x) image(x, y) = 600;  // Nearer to the centre ...
    for (int x = 100; x < 200; ++x) image(x, y) = 500;  // ... than this.
  }
  const BodySurface surface = extract(image, {.down_sampling = 1.0});
  EXPECT_EQ(surface.cloud.size(), 80U * 50U);
}

TEST(BodySurface, GrowsFromWhereTheBodyIsExpected) {
  DepthImage image(640, 480, 900);
  for (int y = 20; y < 60; ++y) {
    for (int x = 500; x < 600; ++x) image(x, y) = 700;
  }
  auto extractor = *BodySurfaceExtractor::create(kKinect, {.down_sampling = 1.0});
  EXPECT_EQ(extractor.extract(image.view(), Eigen::Vector2d(550.0, 40.0))->cloud.size(), 4000U);
  EXPECT_EQ(extractor.extract(image.view())->cloud.size(), 640U * 480U - 4000U);
  // Beside the picture: from its border. Not a number: from its centre.
  EXPECT_GT(extractor.extract(image.view(), Eigen::Vector2d(-1e9, 40.0))->cloud.size(), 4000U);
  EXPECT_GT(extractor.extract(image.view(), Eigen::Vector2d(std::nan(""), 0.0))->cloud.size(),
            4000U);
}

TEST(BodySurface, KeepsThePartsOnWhichMostExpectedPlacesLie) {
  // A body cut in two by an arm before it, and a lone reading beside it.
  DepthImage image(kKinect.width_px, kKinect.height_px);
  for (int y = 100; y < 400; ++y) {
    for (int x = 50; x < 550; ++x) image(x, y) = x < 250 || x >= 400 ? 800 : 600;
  }
  image(600, 200) = 800;
  auto extractor = *BodySurfaceExtractor::create(kKinect, {.down_sampling = 1.0});
  const auto num_points = [&](int left, int arm, int right, int lone, double z_mm) {
    std::vector<Eigen::Vector3d> places;
    const auto add = [&](int count, double x) {
      for (int i = 0; i < count; ++i) {
        places.push_back(z_mm * Eigen::Vector3d(kKinect.ray({x, 200.0 + i}).homogeneous()));
      }
    };
    add(left, 100.0);
    add(arm, 320.0);
    add(right, 450.0);
    add(lone, 600.0);
    add(5, -9.0);
    add(5, 900.0);
    return extractor.extract(image.view(), places)->cloud.size();
  };
  constexpr std::size_t kLeft = 300U * 200U;
  constexpr std::size_t kArm = 300U * 150U;
  constexpr std::size_t kRight = 300U * 150U;
  EXPECT_EQ(num_points(30, 10, 0, 1, 810.0), kLeft);
  EXPECT_EQ(num_points(30, 10, 15, 1, 790.0), kLeft + kRight);
  EXPECT_EQ(num_points(30, 10, 15, 1, 630.0), kArm);
  // Where nothing is as expected, or behind the camera: from the centre, which the arm holds.
  EXPECT_EQ(num_points(30, 10, 15, 1, 200.0), kArm);
  EXPECT_EQ(num_points(30, 10, 15, 1, -800.0), kArm);
  EXPECT_EQ(num_points(0, 0, 0, 0, 800.0), kArm);
}

TEST(BodySurface, ConnectsAcrossADiagonalOnly) {
  DepthImage image(640, 480, 0);
  image(320, 240) = 600;
  image(321, 241) = 600;
  image(319, 241) = 601;
  image(322, 244) = 600;
  const BodySurface surface = extract(image, {.down_sampling = 1.0});
  EXPECT_EQ(surface.cloud.size(), 3U);
  EXPECT_TRUE(surface.triangles.empty());
}

TEST(BodySurface, MakesOneTriangleWhereOnlyThreeCornersConnect) {
  for (int missing = 0; missing < 4; ++missing) {
    DepthImage image(640, 480, 0);
    for (int corner = 0; corner < 4; ++corner) {
      if (corner != missing) image(320 + corner % 2, 240 + corner / 2) = 600;
    }
    const BodySurface surface = extract(image, {.down_sampling = 1.0});
    ASSERT_EQ(surface.cloud.size(), 3U) << missing;
    ASSERT_EQ(surface.triangles.size(), 1U) << missing;
    const auto& [a, b, c] = surface.triangles[0];
    const auto& points = surface.cloud.points;
    EXPECT_LT((points[b] - points[a]).cross(points[c] - points[a]).z(), 0.0F);
  }
}

TEST(BodySurface, LeavesOutTrianglesOfWhatLiesBehind) {
  // A square in front of a wall: at its lower right corner the wall alone spans three of a cell.
  DepthImage image(100, 80);
  for (int y = 0; y < 80; ++y) {
    for (int x = 0; x < 100; ++x) {
      const bool is_front = x >= 30 && x < 70 && y >= 20 && y < 60;
      image(x, y) = is_front ? 500 : 900;
    }
  }
  const PinholeCamera camera{100, 80, 200.0, 200.0, 49.5, 39.5, {}};
  const BodySurface surface = extract(image, {.down_sampling = 1.0}, camera);
  ASSERT_EQ(surface.cloud.size(), 40U * 40U);
  EXPECT_EQ(surface.triangles.size(), 2U * 39U * 39U);
  for (const auto& triangle : surface.triangles) {
    for (const std::uint32_t corner : triangle) ASSERT_LT(corner, surface.cloud.size());
  }
}

TEST(BodySurface, ClipsToNearAndFar) {
  DepthImage image(640, 480, 0);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) image(x, y) = static_cast<std::uint16_t>(400 + y);
  }
  const BodySurface surface =
      extract(image, {.near_mm = 500.0, .far_mm = 700.0, .down_sampling = 1.0});
  EXPECT_EQ(surface.cloud.size(), 201U * 640U);
}

TEST(BodySurface, IsEmptyWhereNothingIsInRange) {
  EXPECT_TRUE(extract(DepthImage(640, 480, 0)).cloud.empty());
  const BodySurface far_away = extract(DepthImage(640, 480, 5000));
  EXPECT_TRUE(far_away.cloud.empty());
  EXPECT_TRUE(far_away.triangles.empty());
}

TEST(BodySurface, TakesPicturesOfAnySize) {
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(2, 3), std::pair(1, 9)}) {
    const PinholeCamera camera{width, height, 500.0, 500.0, 0.5, 0.5, {}};
    const BodySurface surface =
        extract(DepthImage(width, height, 500), {.down_sampling = 1.0}, camera);
    EXPECT_EQ(surface.cloud.size(), static_cast<std::size_t>(width * height));
  }
}

TEST(BodySurface, GivesTheSameSurfaceFromUsedBuffers) {
  auto extractor = *BodySurfaceExtractor::create(kKinect, {});
  const DepthImage sphere = sphere_image({0.0, 0.0, 700.0}, 100.0);
  const BodySurface first = *extractor.extract(sphere.view());
  ASSERT_TRUE(extractor.extract(DepthImage(640, 480, 800).view()));
  const BodySurface again = *extractor.extract(sphere.view());
  EXPECT_EQ(first.cloud.points, again.cloud.points);
  EXPECT_EQ(first.cloud.normals, again.cloud.normals);
  EXPECT_EQ(first.triangles, again.triangles);
}

TEST(BodySurface, RefusesBadOptionsNamingValueAndLimit) {
  const auto message = [](const BodySurfaceOptions& options) {
    const auto made = BodySurfaceExtractor::create(kKinect, options);
    return made ? std::string() : made.error().message;
  };
  using testing::HasSubstr;
  EXPECT_THAT(message({.near_mm = -1.0}), HasSubstr("near_mm must be >= 0, got -1"));
  EXPECT_THAT(message({.near_mm = 500.0, .far_mm = 500.0}), HasSubstr("far_mm"));
  EXPECT_THAT(message({.far_mm = std::nan("")}), HasSubstr("far_mm"));
  EXPECT_THAT(message({.max_edge_mm = 0.0}), HasSubstr("max_edge_mm"));
  EXPECT_THAT(message({.down_sampling = 0.5}), HasSubstr("[1, 4], got 0.5"));
  EXPECT_THAT(message({.down_sampling = 4.5}), HasSubstr("down_sampling"));
  EXPECT_FALSE(BodySurfaceExtractor::create(PinholeCamera{}, {}));
}

TEST(BodySurface, RefusesAnImageOfAnotherSize) {
  auto extractor = *BodySurfaceExtractor::create(kKinect, {});
  const auto surface = extractor.extract(DepthImage(320, 240, 500).view());
  ASSERT_FALSE(surface);
  EXPECT_THAT(surface.error().message, testing::HasSubstr("320x240"));
}

}  // namespace
}  // namespace mor
