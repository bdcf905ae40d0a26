// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_verification.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Eigenvalues>

#include "morgagni/geometry/depth_raster.h"
#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/internal/sensor_points.h"
#include "morgagni/registration/internal/start_evenness.h"

namespace mor::internal {
namespace {

constexpr float kSpacing = 1.0F / 36.0F;  ///< Of the skin's points, of the body's extent.
constexpr float kInPlaneMm = 3.0F;
constexpr float kNoises = 2.0F;
constexpr float kWellMeasured = 0.6F;  ///< Misfit in tolerances.
/// Skin whose neighbouring pixels differ by more than this share of their distance is at an
/// outline.
constexpr float kOutlineReach = 0.012F;

/// The readings in the 3x3 pixels around one.
struct ReadingsAround {
  float nearest_mm = 0.0F;  ///< What comes nearest to the skin; 0 without any.
  float least_mm = std::numeric_limits<float>::infinity();
};

ReadingsAround readings_around(const StartPicture& picture, int x, int y, float z) {
  ReadingsAround around;
  for (int v = std::max(0, y - 1); v <= std::min(picture.z_mm.height() - 1, y + 1); ++v) {
    for (int u = std::max(0, x - 1); u <= std::min(picture.z_mm.width() - 1, x + 1); ++u) {
      const float reading = picture.z_mm(u, v);
      if (reading <= 0.0F) continue;
      around.least_mm = std::min(around.least_mm, reading);
      if (std::abs(reading - z) < std::abs(around.nearest_mm - z)) around.nearest_mm = reading;
    }
  }
  return around;
}

/// Whether the surface goes on over the pixels around (x, y). At an outline a sensor's readings
/// stray sideways, and on skin that it grazes.
bool goes_on(const Image<float>& expected_mm, int x, int y) {
  const float z = expected_mm(x, y);
  if (x < 1 || y < 1 || x + 1 >= expected_mm.width() || y + 1 >= expected_mm.height()) return false;
  for (int v = y - 1; v <= y + 1; ++v) {
    for (int u = x - 1; u <= x + 1; ++u) {
      if (std::abs(expected_mm(u, v) - z) > kOutlineReach * z) return false;
    }
  }
  return true;
}

void judge(float reading, float expected, float tolerance_mm, SkinAgreement& agreement) {
  agreement.num_seen += 1.0;
  if (reading > expected + kFloatingTolerances * tolerance_mm) {
    agreement.num_floating += 1.0;
  } else if (reading < expected - tolerance_mm) {
    agreement.num_hidden += 1.0;
  } else {
    const float ratio = std::min(1.0F, std::abs(reading - expected) / tolerance_mm);
    agreement.num_agree += static_cast<double>((1.0F - ratio * ratio) * (1.0F - ratio * ratio));
  }
}

double area_mm2(const TriangleMesh& mesh, const Triangle& triangle) {
  const auto& [a, b, c] = triangle;
  const Eigen::Vector3f to_b = mesh.vertices[b] - mesh.vertices[a];
  const Eigen::Vector3f to_c = mesh.vertices[c] - mesh.vertices[a];
  return 0.5 * static_cast<double>(to_b.cross(to_c).norm());
}

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Gathers the skin that is measured where it should be: how much, and how firmly it holds a pose.
class HoldingSkin {
 public:
  explicit HoldingSkin(const TriangleMesh& mesh)
      : mesh_(mesh),
        center_(mesh.bounds().center()),
        reach_mm_(0.5F * mesh.bounds().sizes().maxCoeff()) {}

  /// @param at  On the skin, frame ct; seen by `camera` through a pixel of this size at distance 1.
  void add(const Eigen::Vector3f& at,
           const Triangle& triangle,
           const Eigen::Vector3f& camera,
           float pixel_sr) {
    constexpr float kLeastFacing = 0.2F;
    const Eigen::Vector3f normal =
        (mesh_.normals[triangle[0]] + mesh_.normals[triangle[1]] + mesh_.normals[triangle[2]])
            .normalized();
    const Eigen::Vector3f to_camera = camera - at;
    const float facing = std::max(kLeastFacing, std::abs(normal.dot(to_camera.normalized())));
    const float area_mm2 = to_camera.squaredNorm() * pixel_sr / facing;
    Vector6d row;
    row.head<3>() = normal.cast<double>();
    row.tail<3>() = ((at - center_) / reach_mm_).cross(normal).cast<double>();
    moments_ += static_cast<double>(area_mm2) * row * row.transpose();
    area_mm2_ += static_cast<double>(area_mm2);
  }

  [[nodiscard]] double area_mm2() const { return area_mm2_; }
  [[nodiscard]] double firmness() const {
    if (!(area_mm2_ > 0.0)) return 0.0;
    const Eigen::SelfAdjointEigenSolver<Matrix6d> axes(moments_ / area_mm2_,
                                                       Eigen::EigenvaluesOnly);
    return std::max(0.0, axes.eigenvalues()[0]);
  }

 private:
  const TriangleMesh& mesh_;
  Eigen::Vector3f center_;
  float reach_mm_;
  Matrix6d moments_ = Matrix6d::Zero();
  double area_mm2_ = 0.0;
};

}  // namespace

SkinAgreement pooled(const std::vector<SkinAgreement>& looks) {
  SkinAgreement all;
  double num_patches = 0.0;
  double sum_uneven_mm2 = 0.0;
  for (const auto& look : looks) {
    all.noise_mm = std::max(all.noise_mm, look.noise_mm);
    all.noise_share = std::min(all.noise_share, look.noise_share);
    all.num_seen += look.num_seen;
    all.num_agree += look.num_agree;
    all.num_floating += look.num_floating;
    all.num_hidden += look.num_hidden;
    num_patches += look.num_patches;
    sum_uneven_mm2 += look.num_patches * look.uneven_mm * look.uneven_mm;
    all.num_patches = std::max(all.num_patches, look.num_patches);
    if (look.area_share * look.firmness > all.area_share * all.firmness) {
      all.area_share = look.area_share;
      all.firmness = look.firmness;
    }
  }
  if (num_patches > 0.0) all.uneven_mm = std::sqrt(sum_uneven_mm2 / num_patches);
  return all;
}

StartVerifier::StartVerifier(std::shared_ptr<const FixedSurface> fixed, float body_extent_mm)
    : fixed_(std::move(fixed)), glance_(fixed_->mesh, kSpacing * body_extent_mm) {
  for (const auto& triangle : fixed_->mesh.triangles) {
    skin_area_mm2_ += area_mm2(fixed_->mesh, triangle);
  }
}

SkinAgreement StartVerifier::glance(const StartPicture& picture,
                                    const Eigen::Isometry3d& ct_from_depth,
                                    float tolerance_mm) const {
  return glance_.at(picture, ct_from_depth, tolerance_mm);
}

SkinAgreement StartVerifier::look(const StartPicture& picture,
                                  const std::vector<StartPlane>& planes,
                                  const Eigen::Isometry3d& ct_from_depth,
                                  float tolerance_mm) const {
  SkinAgreement agreement;
  const DepthRaster raster = rasterize_depth(fixed_->mesh, picture.camera, ct_from_depth.inverse());
  const Eigen::Isometry3f pose = ct_from_depth.cast<float>();
  const auto pixel_sr =
      static_cast<float>(1.0 / (picture.camera.focal_x_px * picture.camera.focal_y_px));
  HoldingSkin holding(fixed_->mesh);
  constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
  Image<float> on_skin_mm(raster.depth_mm.width(), raster.depth_mm.height(), kNothing);
  for (int y = 0; y < raster.depth_mm.height(); ++y) {
    for (int x = 0; x < raster.depth_mm.width(); ++x) {
      const float expected = raster.depth_mm(x, y);
      if (expected <= 0.0F) continue;
      const auto [reading, least] = readings_around(picture, x, y, expected);
      if (reading <= 0.0F) continue;
      const float noise_mm = kNoises * axial_noise_mm(expected);
      if (is_in_large_plane(planes, picture.point_at(x, y, expected), kInPlaneMm + noise_mm)) {
        continue;
      }
      // What looks past the skin beside something before it has strayed from there.
      const bool is_beside = reading > expected && least < expected - tolerance_mm - noise_mm;
      if (!is_beside && goes_on(raster.depth_mm, x, y)) {
        judge(reading, expected, tolerance_mm + noise_mm, agreement);
      }
      const float straight = picture.z_mm(x, y);
      if (straight <= 0.0F) continue;
      const float misfit = (straight - expected) / (tolerance_mm + noise_mm);
      // What lies nearly as near as the skin is told from it where there is less noise.
      if (std::abs(straight - expected) < tolerance_mm + picture.noise_share * noise_mm) {
        on_skin_mm(x, y) = straight - expected;
      }
      if (std::abs(misfit) < kWellMeasured) {
        holding.add(pose * picture.point_at(x, y, expected),
                    fixed_->mesh.triangles[raster.triangle_idx(x, y)],
                    pose.translation(),
                    pixel_sr);
      }
    }
  }
  agreement.area_share = holding.area_mm2() / skin_area_mm2_;
  agreement.firmness = holding.firmness();
  const Evenness evenness = judge_evenness(on_skin_mm);
  const Eigen::Vector3f middle =
      ct_from_depth.inverse().cast<float>() * fixed_->mesh.bounds().center();
  agreement.num_patches = evenness.num_patches;
  agreement.uneven_mm = evenness.uneven_mm;
  agreement.noise_mm = axial_noise_mm(middle.z());
  agreement.noise_share = picture.noise_share;
  return agreement;
}

}  // namespace mor::internal
