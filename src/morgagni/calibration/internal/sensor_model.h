// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "morgagni/calibration/self_calibration.h"
#include "morgagni/geometry/pinhole_camera.h"

namespace mor::internal {

/// A reading with all that the fit needs of it.
struct SensorReading {
  Eigen::Vector2f ray = Eigen::Vector2f::Zero();  ///< x/z and y/z as the calibration has it.
  float z_mm = 0.0F;
  float weight = 0.0F;       ///< 1 / variance along the normal, 1/mm^2. 0: not to be used.
  std::uint16_t cell_x = 0;  ///< Of the grid of control points, with the place in it, 0..1.
  std::uint16_t cell_y = 0;
  float in_cell_x = 0.0F;
  float in_cell_y = 0.0F;
  /// Where it would be if nothing erred, and the skin's normal there, frame ct.
  Eigen::Vector3d place_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  /// Control points, ascending, of how the surface there lies off where it is expected: the skin's
  /// change, or what the table is out of its plane. After the sensor's values.
  std::size_t num_surface = 0;
  std::array<std::uint16_t, 8> surface_index{};
  std::array<float, 8> surface_share{};
};

/// How h goes with g (SensorModel) before anything was seen, against the covariance of g.
struct DepthGrowth {
  double with_g = 0.0;  ///< Covariance of h and g.
  double square = 0.0;  ///< Variance of h.
};

/// The sensor's systematic error as a vector of parameters:
///
///   z' = z + g(u, v) s + h(u, v) (s - 1),   s = z / kReferenceMm
///   x'/z' = (1 - fx) x/z - cx,   the same for y
///
/// g and h are bilinear between control points: g is the correction at the reference distance if it
/// grows with the distance, h how far it does not. fx, fy: the focal lengths are so much larger
/// than the calibration says; cx, cy: the centre lies so much further, in x/z.
class SensorModel {
 public:
  static constexpr double kReferenceMm = 800.0;
  static constexpr std::size_t kNumPinhole = 4;
  /// Parameters that one reading depends on: g and h at four control points, and the pinhole.
  static constexpr std::size_t kNumTouched = 12;

  SensorModel(const PinholeCamera& camera, const SelfCalibrationOptions& options);

  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] std::size_t num_nodes() const {
    return static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  }
  [[nodiscard]] std::size_t size() const { return 2 * num_nodes() + kNumPinhole; }

  /// Places a reading on the grid; the rest comes with what is expected of it.
  [[nodiscard]] SensorReading reading(const SkinReading& read) const;
  /// 1 / variance of a single reading's distance along the skin's normal, 1/mm^2. 0: grazing.
  [[nodiscard]] static double weight(double z_mm, double cosine);

  /// Covariance of the parameters before anything was seen: what sensors are known to do.
  [[nodiscard]] Eigen::MatrixXd prior_covariance(const DepthGrowth& growth) const;

  /// Where the reading is when the parameters are `values`.
  [[nodiscard]] Eigen::Vector3d corrected(const SensorReading& reading,
                                          std::span<const double> values) const;

  /// How a distance along `normal` (frame depth) changes with the parameters: index and derivative.
  void derivatives(const SensorReading& reading,
                   const Eigen::Vector3d& normal,
                   std::array<std::size_t, kNumTouched>& index,
                   std::array<double, kNumTouched>& value) const;

 private:
  [[nodiscard]] std::array<double, 4> cell_weights(const SensorReading& reading) const;
  [[nodiscard]] std::array<std::size_t, 4> cell_nodes(const SensorReading& reading) const;

  PinholeCamera camera_;
  SelfCalibrationOptions options_;
  int columns_;
  int rows_;
};

}  // namespace mor::internal
