// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/surface_shape.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace mor::internal {
namespace {

Eigen::Vector3d centroid(std::span<const Eigen::Vector3f> points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& point : points) sum += point.cast<double>();
  return sum / static_cast<double>(points.size());
}

/// Root mean square distance from the sphere that fits best by x^2 + y^2 + z^2 = b^T (x, y, z, 1),
/// of points about their centroid: the linear fit of Kasa (IEEE Trans. Instrum. Meas. 25, 1976, of
/// circles).
double rms_from_sphere_mm(std::span<const Eigen::Vector3f> points, const Eigen::Vector3d& center) {
  Eigen::Matrix4d products = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right_side = Eigen::Vector4d::Zero();
  for (const auto& point : points) {
    const Eigen::Vector4d row = (point.cast<double>() - center).homogeneous();
    products += row * row.transpose();
    right_side += row * row.head<3>().squaredNorm();
  }
  const Eigen::Vector4d b = products.ldlt().solve(right_side);
  const Eigen::Vector3d sphere_center = 0.5 * b.head<3>();
  const double radius_mm = std::sqrt(std::max(0.0, b[3] + sphere_center.squaredNorm()));
  double sum_sq_mm2 = 0.0;
  for (const auto& point : points) {
    const double off_mm = (point.cast<double>() - center - sphere_center).norm() - radius_mm;
    sum_sq_mm2 += off_mm * off_mm;
  }
  return std::sqrt(sum_sq_mm2 / static_cast<double>(points.size()));
}

}  // namespace

std::optional<const char*> shape_without_pose(std::span<const Eigen::Vector3f> points,
                                              double noise_mm) {
  const Eigen::Vector3d center = centroid(points);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto& point : points) {
    const Eigen::Vector3d offset = point.cast<double>() - center;
    scatter += offset * offset.transpose();
  }
  scatter /= static_cast<double>(points.size());
  const Eigen::Vector3d spread_mm =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter, Eigen::EigenvaluesOnly)
          .eigenvalues()
          .cwiseMax(0.0)
          .cwiseSqrt();
  if (spread_mm[1] <= noise_mm) return "line";
  if (spread_mm[0] <= noise_mm) return "plane";
  if (rms_from_sphere_mm(points, center) <= noise_mm) return "sphere";
  return std::nullopt;
}

double weakest_constraint(std::span<const Eigen::Vector3f> points,
                          std::span<const Eigen::Vector3f> normals) {
  const Eigen::Vector3d center = centroid(points);
  double sum_sq_mm2 = 0.0;
  for (const auto& point : points) sum_sq_mm2 += (point.cast<double>() - center).squaredNorm();
  const auto count = static_cast<double>(points.size());
  const double radius_mm = std::max(1.0, std::sqrt(sum_sq_mm2 / count));
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d normal = normals[i].cast<double>();
    Eigen::Matrix<double, 6, 1> row;
    row << (points[i].cast<double>() - center).cross(normal) / radius_mm, normal;
    information += row * row.transpose();
  }
  using Solver = Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>>;
  return Solver(information / count, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

}  // namespace mor::internal
