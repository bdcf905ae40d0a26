// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/geometry/depth_raster.h"

#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include <gtest/gtest.h>

namespace mor {
namespace {

constexpr PinholeCamera kCamera{.width_px = 160,
                                .height_px = 120,
                                .focal_x_px = 130.0,
                                .focal_y_px = 131.0,
                                .center_x_px = 79.3,
                                .center_y_px = 59.8};

Eigen::Isometry3d moved(double x_mm, double y_mm, double z_mm) {
  return Eigen::Isometry3d(Eigen::Translation3d(x_mm, y_mm, z_mm));
}

/// A ball about the origin; fine enough for its facets to stay within a hundredth of a millimetre.
TriangleMesh ball(float radius_mm, unsigned num_rings) {
  TriangleMesh mesh;
  const unsigned num_columns = 2 * num_rings;
  for (unsigned ring = 0; ring <= num_rings; ++ring) {
    const float polar = std::numbers::pi_v<float> * ring / num_rings;
    for (unsigned column = 0; column < num_columns; ++column) {
      const float azimuth = 2.0F * std::numbers::pi_v<float> * column / num_columns;
      mesh.vertices.emplace_back(radius_mm * std::sin(polar) * std::cos(azimuth),
                                 radius_mm * std::sin(polar) * std::sin(azimuth),
                                 radius_mm * std::cos(polar));
    }
  }
  for (unsigned ring = 0; ring < num_rings; ++ring) {
    for (unsigned column = 0; column < num_columns; ++column) {
      const unsigned next = (column + 1) % num_columns;
      const unsigned a = ring * num_columns + column;
      const unsigned b = ring * num_columns + next;
      mesh.triangles.push_back({a, a + num_columns, b});
      mesh.triangles.push_back({b, a + num_columns, b + num_columns});
    }
  }
  return mesh;
}

Eigen::Vector3d ray_of(int x, int y) {
  return {(x - kCamera.center_x_px) / kCamera.focal_x_px,
          (y - kCamera.center_y_px) / kCamera.focal_y_px,
          1.0};
}

/// Depth at which a ray from the origin meets a triangle (Moeller and Trumbore 1997).
std::optional<double> meet(const Eigen::Vector3d& ray,
                           const Eigen::Vector3d& a,
                           const Eigen::Vector3d& b,
                           const Eigen::Vector3d& c) {
  const Eigen::Vector3d p = ray.cross(c - a);
  const double determinant = (b - a).dot(p);
  if (std::abs(determinant) < 1e-12) return std::nullopt;
  const double u = -a.dot(p) / determinant;
  const Eigen::Vector3d q = (-a).cross(b - a);
  const double v = ray.dot(q) / determinant;
  const double depth = (c - a).dot(q) / determinant;
  if (u < 0.0 || v < 0.0 || u + v > 1.0 || depth <= 0.0) return std::nullopt;
  return depth;
}

TEST(DepthRaster, SeesABallAtItsAnalyticDepth) {
  constexpr double kRadiusMm = 100.0;
  const Eigen::Vector3d center(20.0, -10.0, 500.0);
  const auto raster =
      rasterize_depth(ball(kRadiusMm, 200), kCamera, moved(center.x(), center.y(), center.z()));
  int num_seen = 0;
  for (int y = 0; y < kCamera.height_px; ++y) {
    for (int x = 0; x < kCamera.width_px; ++x) {
      const Eigen::Vector3d ray = ray_of(x, y);
      const double half_b = ray.dot(center);
      const double discriminant =
          half_b * half_b - ray.squaredNorm() * (center.squaredNorm() - kRadiusMm * kRadiusMm);
      const float seen = raster.depth_mm(x, y);
      // How far the ray passes from the ball's surface decides whether a pixel belongs to it.
      const double off_mm = ray.cross(center).norm() / ray.norm() - kRadiusMm;
      if (off_mm > 0.02) {
        EXPECT_EQ(seen, 0.0F) << x << ' ' << y;
      }
      if (off_mm < -0.05) {
        EXPECT_GT(seen, 0.0F) << x << ' ' << y;
      }
      if (off_mm < -5.0) {
        EXPECT_NEAR(seen, (half_b - std::sqrt(discriminant)) / ray.squaredNorm(), 0.05);
      }
      EXPECT_EQ(seen > 0.0F, raster.triangle_idx(x, y) != DepthRaster::kNothing);
      num_seen += seen > 0.0F ? 1 : 0;
    }
  }
  EXPECT_GT(num_seen, 2000);
}

TEST(DepthRaster, InterpolatesATiltedPlaneWithPerspective) {
  TriangleMesh mesh;
  mesh.vertices = {{-900, -900, 300}, {900, -900, 700}, {900, 900, 900}, {-900, 900, 500}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  const Eigen::Vector3d origin = mesh.vertices[0].cast<double>();
  const Eigen::Vector3d normal =
      (mesh.vertices[1].cast<double>() - origin).cross(mesh.vertices[3].cast<double>() - origin);
  const auto raster = rasterize_depth(mesh, kCamera, Eigen::Isometry3d::Identity());
  for (int y = 0; y < kCamera.height_px; ++y) {
    for (int x = 0; x < kCamera.width_px; ++x) {
      EXPECT_NEAR(raster.depth_mm(x, y), origin.dot(normal) / ray_of(x, y).dot(normal), 0.02);
    }
  }
}

TEST(DepthRaster, AgreesWithBruteForceRayCasting) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> sideways(-250.0F, 250.0F);
  std::uniform_real_distribution<float> forward(150.0F, 600.0F);
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < 150; ++i) {
    const Eigen::Vector3f center(sideways(random), sideways(random), forward(random));
    for (int corner = 0; corner < 3; ++corner) {
      mesh.vertices.push_back(
          center + 0.25F * Eigen::Vector3f(sideways(random), sideways(random), sideways(random)));
    }
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const auto raster = rasterize_depth(mesh, kCamera, Eigen::Isometry3d::Identity());
  int num_different = 0;
  for (int y = 0; y < kCamera.height_px; ++y) {
    for (int x = 0; x < kCamera.width_px; ++x) {
      double nearest = 0.0;
      for (const auto& [a, b, c] : mesh.triangles) {
        const auto depth = meet(ray_of(x, y),
                                mesh.vertices[a].cast<double>(),
                                mesh.vertices[b].cast<double>(),
                                mesh.vertices[c].cast<double>());
        if (depth && (nearest == 0.0 || *depth < nearest)) nearest = *depth;
      }
      // A pixel centre within rounding of an edge may fall either way, and nothing else may.
      if (std::abs(raster.depth_mm(x, y) - nearest) > 0.05) ++num_different;
    }
  }
  EXPECT_LE(num_different, 3);
}

TEST(DepthRaster, LeavesNoGapBetweenTrianglesThatShareAnEdge) {
  TriangleMesh mesh;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> shift(-3.0F, 3.0F);
  constexpr unsigned kSide = 80;
  for (unsigned i = 0; i < kSide * kSide; ++i) {
    mesh.vertices.emplace_back(10.0F * (i % kSide) - 400.0F + shift(random),
                               10.0F * (i / kSide) - 400.0F + shift(random),
                               400.0F + 3.0F * shift(random));
  }
  for (unsigned i = 0; i + kSide < kSide * kSide; ++i) {
    if (i % kSide == kSide - 1) continue;
    mesh.triangles.push_back({i, i + 1, i + kSide});
    mesh.triangles.push_back({i + 1, i + kSide + 1, i + kSide});
  }
  const auto raster = rasterize_depth(mesh, kCamera, Eigen::Isometry3d::Identity());
  for (std::size_t i = 0; i < raster.depth_mm.size(); ++i) {
    ASSERT_NE(raster.depth_mm.data()[i], 0.0F) << i;
  }
}

TEST(DepthRaster, SeesATriangleFromBothSidesAndTheNearerOfTwo) {
  TriangleMesh mesh;
  mesh.vertices = {
      {-50, -50, 400}, {50, -50, 400}, {0, 60, 400}, {-50, -50, 300}, {50, -50, 300}, {0, 60, 300}};
  for (const Triangle& triangle : {Triangle{3, 4, 5}, Triangle{3, 5, 4}}) {
    mesh.triangles = {triangle, {0, 1, 2}};
    const auto raster = rasterize_depth(mesh, kCamera, Eigen::Isometry3d::Identity());
    EXPECT_NEAR(raster.depth_mm(79, 60), 300.0F, 0.01F);
    EXPECT_EQ(raster.triangle_idx(79, 60), 0U);
  }
}

TEST(DepthRaster, TellsTheOuterSideFromTheInnerOne) {
  const auto sides = rasterize_sides(ball(60.0F, 120), kCamera, moved(0.0, 0.0, 400.0));
  const auto together = rasterize_depth(ball(60.0F, 120), kCamera, moved(0.0, 0.0, 400.0));
  int num_seen = 0;
  for (int y = 0; y < kCamera.height_px; ++y) {
    for (int x = 0; x < kCamera.width_px; ++x) {
      const Eigen::Vector3d ray = ray_of(x, y).normalized();
      const double middle = 400.0 * ray.z();
      const double beside_sq = 400.0 * 400.0 - middle * middle;
      if (beside_sq > 58.0 * 58.0) continue;  // Its outline, to which facets are tangents.
      ++num_seen;
      const double half = std::sqrt(60.0 * 60.0 - beside_sq);
      ASSERT_NEAR(sides.outer_mm(x, y), (middle - half) * ray.z(), 0.05) << x << ", " << y;
      ASSERT_NEAR(sides.inner_mm(x, y), (middle + half) * ray.z(), 0.05) << x << ", " << y;
      ASSERT_EQ(sides.outer_mm(x, y), together.depth_mm(x, y));
    }
  }
  EXPECT_GT(num_seen, 900);
  EXPECT_EQ(sides.outer_mm(1, 1), 0.0F);
  EXPECT_EQ(sides.inner_mm(1, 1), 0.0F);
}

TEST(DepthRaster, DropsWhatIsBehindOrTouchesTheCamera) {
  TriangleMesh mesh;
  mesh.vertices = {{-50, -50, -400}, {50, -50, -400}, {0, 60, -400}, {0, 0, 0.5F}, {0, 0, 400}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 4}, {3, 4, 4}, {3, 1, 4}};
  const auto raster = rasterize_depth(mesh, kCamera, Eigen::Isometry3d::Identity());
  for (std::size_t i = 0; i < raster.depth_mm.size(); ++i) {
    ASSERT_EQ(raster.depth_mm.data()[i], 0.0F);
    ASSERT_EQ(raster.triangle_idx.data()[i], DepthRaster::kNothing);
  }
}

TEST(DepthRaster, FillsPicturesOfAnyWidth) {
  TriangleMesh mesh;
  mesh.vertices = {{-900, -900, 500}, {900, -900, 500}, {0, 900, 500}};
  mesh.triangles = {{0, 1, 2}};
  for (int width = 1; width < 12; ++width) {
    PinholeCamera camera = kCamera;
    camera.width_px = width;
    const auto raster = rasterize_depth(mesh, camera, Eigen::Isometry3d::Identity());
    ASSERT_EQ(raster.depth_mm.width(), width);
    ASSERT_EQ(raster.triangle_idx.width(), width);
    for (int x = 0; x < width; ++x) EXPECT_NEAR(raster.depth_mm(x, 60), 500.0F, 0.01F) << width;
  }
}

TEST(DepthRaster, SurvivesTrianglesFarLargerThanThePicture) {
  TriangleMesh mesh;
  mesh.vertices = {{-1e9F, -1e9F, 500},
                   {1e9F, -1e9F, 500},
                   {0, 1e9F, 500},
                   {-1e30F, 0, 2},
                   {1e30F, 0, 2},
                   {0, 1e30F, 2}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  const auto raster = rasterize_depth(mesh, kCamera, Eigen::Isometry3d::Identity());
  EXPECT_GT(raster.depth_mm(80, 60), 0.0F);
}

}  // namespace
}  // namespace mor
