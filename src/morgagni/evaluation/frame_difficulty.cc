// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/frame_difficulty.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Eigenvalues>

#include "morgagni/camera/kinect_noise_model.h"
#include "morgagni/geometry/depth_raster.h"

namespace mor {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Noise is far less, a towel's folds and a hand mostly more.
constexpr double kBareMm = 15.0;
/// Skin that is seen flatter has no reading.
constexpr double kLeastFacing = 0.05;
/// Rotations count as the shift that they give at this distance.
constexpr double kLeverMm = 100.0;
constexpr double kOpenSigmaMm = 1e3;

/// Adds what a pixel's depth says of the pose, as (rotation about `pivot`, shift).
class Information {
 public:
  Information(const PinholeCamera& camera,
              const Eigen::Isometry3d& ct_from_depth,
              const Eigen::Vector3d& pivot)
      : camera_(camera), ct_from_depth_(ct_from_depth), pivot_(pivot) {}

  /// @param ray  Through the pixel, of depth 1.
  void add(const Eigen::Vector3d& ray, double z_mm, const Eigen::Vector3d& normal_ct) {
    const Eigen::Vector3d normal = ct_from_depth_.linear().transpose() * normal_ct;
    const double along = normal.dot(ray);
    const double facing = -along / ray.norm();
    if (!(facing >= kLeastFacing)) return;
    // How much the depth changes a pixel further, where the lateral noise may have it from.
    const double step_x_mm = z_mm * normal.x() / (camera_.focal_x_px * along);
    const double step_y_mm = z_mm * normal.y() / (camera_.focal_y_px * along);
    const double angle_rad = std::acos(std::min(1.0, facing));
    const double axial_mm = kinect::axial_sd_mm(z_mm, angle_rad);
    const double lateral_px = kinect::lateral_sd_px(angle_rad);
    const double variance_mm2 =
        axial_mm * axial_mm +
        lateral_px * lateral_px * (step_x_mm * step_x_mm + step_y_mm * step_y_mm);
    const Eigen::Vector3d lever = ct_from_depth_ * (z_mm * ray) - pivot_;
    Vector6d row;
    row << lever.cross(normal_ct) / kLeverMm, normal_ct;
    row /= along;
    matrix_ += row * row.transpose() / variance_mm2;
  }

  [[nodiscard]] double least_tre_mm(const std::vector<Target>& targets) const {
    const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(matrix_);
    if (!(eigen.eigenvalues()[0] * kOpenSigmaMm * kOpenSigmaMm > 1.0)) {
      return std::numeric_limits<double>::infinity();
    }
    const Matrix6d covariance = eigen.eigenvectors() *
                                eigen.eigenvalues().cwiseInverse().asDiagonal() *
                                eigen.eigenvectors().transpose();
    double sum_mm2 = 0.0;
    for (const auto& target : targets) {
      const Eigen::Vector3d lever = (target.ct - pivot_) / kLeverMm;
      Eigen::Matrix<double, 3, 6> jacobian;
      // A rotation w moves the target by w x lever = -lever x w.
      jacobian << 0.0, lever.z(), -lever.y(), 1.0, 0.0, 0.0,  //
          -lever.z(), 0.0, lever.x(), 0.0, 1.0, 0.0,          //
          lever.y(), -lever.x(), 0.0, 0.0, 0.0, 1.0;
      sum_mm2 += (jacobian * covariance * jacobian.transpose()).trace();
    }
    return std::sqrt(sum_mm2 / static_cast<double>(targets.size()));
  }

 private:
  const PinholeCamera& camera_;
  const Eigen::Isometry3d& ct_from_depth_;
  Eigen::Vector3d pivot_;
  Matrix6d matrix_ = Matrix6d::Zero();
};

Eigen::Vector3d face_normal(const TriangleMesh& mesh, std::uint32_t triangle_idx) {
  const auto& [a, b, c] = mesh.triangles[triangle_idx];
  const Eigen::Vector3d corner = mesh.vertices[a].cast<double>();
  return (mesh.vertices[b].cast<double>() - corner)
      .cross(mesh.vertices[c].cast<double>() - corner)
      .normalized();
}

}  // namespace

FrameDifficulty frame_difficulty(const TriangleMesh& skin,
                                 ImageView<const std::uint16_t> depth_mm,
                                 const PinholeCamera& camera,
                                 const Eigen::Isometry3d& ct_from_depth_truth,
                                 const std::vector<Target>& targets) {
  const auto raster = rasterize_depth(skin, camera, ct_from_depth_truth.inverse());
  Information information(camera, ct_from_depth_truth, skin.bounds().center().cast<double>());
  int num_in_view = 0;
  int num_bare = 0;
  for (int y = 0; y < raster.depth_mm.height(); ++y) {
    for (int x = 0; x < raster.depth_mm.width(); ++x) {
      const double reading_mm = depth_mm(x, y);
      const double z_mm = raster.depth_mm(x, y);
      if (z_mm <= 0.0 || reading_mm <= 0.0) continue;
      const Eigen::Vector3d ray = camera.ray(Eigen::Vector2d(x, y)).homogeneous();
      const Eigen::Vector3d normal = face_normal(skin, raster.triangle_idx(x, y));
      if (normal.dot(ct_from_depth_truth.linear() * ray) >= 0.0) continue;
      ++num_in_view;
      if (std::abs(reading_mm - z_mm) >= kBareMm) continue;
      ++num_bare;
      information.add(ray, z_mm, normal);
    }
  }
  FrameDifficulty difficulty;
  if (num_in_view > 0) difficulty.bare_share = static_cast<double>(num_bare) / num_in_view;
  difficulty.least_tre_mm = information.least_tre_mm(targets);
  return difficulty;
}

}  // namespace mor
