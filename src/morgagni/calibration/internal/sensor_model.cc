// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/internal/sensor_model.h"

#include <algorithm>
#include <cmath>

namespace mor::internal {
namespace {

/// Cosines between normal and ray: nothing below the first is used, all from the second on in full.
constexpr double kGrazingCosine = 0.25;  // 75 degrees
constexpr double kFrontalCosine = 0.50;  // 60 degrees

/// Of a Kinect's single readings: Nguyen, Izadi & Lovell, 3DIMPVT 2012. What the means of blocks
/// really scatter by is measured afterwards (SelfCalibration).
double noise_mm(double z_mm) {
  const double beyond_m = z_mm * 1e-3 - 0.4;
  return 1.2 + 1.9 * beyond_m * beyond_m;
}

/// Places a pixel coordinate in a row of control points that lie on the first and last pixel and
/// evenly between.
void place(double pixel, int size_px, int count, std::uint16_t& cell, float& in_cell) {
  const double at = std::clamp(pixel / (size_px - 1), 0.0, 1.0) * (count - 1);
  const double below = std::min(std::floor(at), static_cast<double>(count - 2));
  cell = static_cast<std::uint16_t>(below);
  in_cell = static_cast<float>(at - below);
}

}  // namespace

SensorModel::SensorModel(const PinholeCamera& camera, const SelfCalibrationOptions& options)
    : camera_(camera), options_(options), columns_(options.columns), rows_(options.rows) {}

SensorReading SensorModel::reading(const SkinReading& read) const {
  SensorReading reading;
  const Eigen::Vector2d pixel = read.pixel.cast<double>();
  reading.ray = camera_.ray(pixel).cast<float>();
  reading.z_mm = read.z_mm;
  place(pixel.x(), camera_.width_px, columns_, reading.cell_x, reading.in_cell_x);
  place(pixel.y(), camera_.height_px, rows_, reading.cell_y, reading.in_cell_y);
  return reading;
}

double SensorModel::weight(double z_mm, double cosine) {
  const double trust =
      std::clamp((cosine - kGrazingCosine) / (kFrontalCosine - kGrazingCosine), 0.0, 1.0);
  const double noise = noise_mm(z_mm);
  return trust / (noise * noise);
}

Eigen::MatrixXd SensorModel::prior_covariance(const DepthGrowth& growth) const {
  const auto nodes = static_cast<Eigen::Index>(num_nodes());
  Eigen::MatrixXd field(nodes, nodes);
  const double aspect = static_cast<double>(camera_.height_px) / camera_.width_px;
  const auto at = [&](Eigen::Index node) {
    const auto x = static_cast<double>(node % columns_) / (columns_ - 1);
    const auto y = static_cast<double>(node / columns_) / (rows_ - 1);
    return Eigen::Vector2d(2.0 * x - 1.0, aspect * (2.0 * y - 1.0));
  };
  const auto& prior = options_.prior;
  const auto squared = [](double value) { return value * value; };
  for (Eigen::Index i = 0; i < nodes; ++i) {
    for (Eigen::Index k = 0; k < nodes; ++k) {
      const Eigen::Vector2d a = at(i);
      const Eigen::Vector2d b = at(k);
      field(i, k) = squared(prior.offset_mm) + squared(prior.tilt_mm) * a.dot(b) +
                    squared(prior.shape_mm) *
                        std::exp(-0.5 * (a - b).squaredNorm() / squared(prior.shape_reach));
    }
  }
  field.diagonal().array() += squared(0.02 * prior.shape_mm);
  const auto size_of_all = static_cast<Eigen::Index>(size());
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(size_of_all, size_of_all);
  all.topLeftCorner(nodes, nodes) = field;
  all.block(nodes, nodes, nodes, nodes) = growth.square * field;
  all.block(0, nodes, nodes, nodes) = all.block(nodes, 0, nodes, nodes) = growth.with_g * field;
  const Eigen::Index pinhole = 2 * nodes;
  const double both = squared(prior.pinhole.focal_ratio);
  const double apart = squared(prior.focal_difference_ratio);
  all(pinhole, pinhole) = all(pinhole + 1, pinhole + 1) = both + apart;
  all(pinhole, pinhole + 1) = all(pinhole + 1, pinhole) = both - apart;
  all(pinhole + 2, pinhole + 2) = squared(prior.pinhole.center_px / camera_.focal_x_px);
  all(pinhole + 3, pinhole + 3) = squared(prior.pinhole.center_px / camera_.focal_y_px);
  return all;
}

std::array<double, 4> SensorModel::cell_weights(const SensorReading& reading) const {
  const double x = reading.in_cell_x;
  const double y = reading.in_cell_y;
  return {(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y};
}

std::array<std::size_t, 4> SensorModel::cell_nodes(const SensorReading& reading) const {
  const auto columns = static_cast<std::size_t>(columns_);
  const std::size_t first = reading.cell_y * columns + reading.cell_x;
  return {first, first + 1, first + columns, first + columns + 1};
}

Eigen::Vector3d SensorModel::corrected(const SensorReading& reading,
                                       std::span<const double> values) const {
  const auto nodes = cell_nodes(reading);
  const auto weights = cell_weights(reading);
  const double s = static_cast<double>(reading.z_mm) / kReferenceMm;
  double z_mm = reading.z_mm;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    z_mm += weights[i] * (values[nodes[i]] * s + values[num_nodes() + nodes[i]] * (s - 1.0));
  }
  const auto pinhole = values.subspan(2 * num_nodes(), kNumPinhole);
  return {z_mm * ((1.0 - pinhole[0]) * static_cast<double>(reading.ray.x()) - pinhole[2]),
          z_mm * ((1.0 - pinhole[1]) * static_cast<double>(reading.ray.y()) - pinhole[3]),
          z_mm};
}

void SensorModel::derivatives(const SensorReading& reading,
                              const Eigen::Vector3d& normal,
                              std::array<std::size_t, kNumTouched>& index,
                              std::array<double, kNumTouched>& value) const {
  const auto nodes = cell_nodes(reading);
  const auto weights = cell_weights(reading);
  const double z_mm = reading.z_mm;
  const double s = z_mm / kReferenceMm;
  const auto ray_x = static_cast<double>(reading.ray.x());
  const auto ray_y = static_cast<double>(reading.ray.y());
  const double along_ray = normal.x() * ray_x + normal.y() * ray_y + normal.z();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    index[i] = nodes[i];
    value[i] = along_ray * weights[i] * s;
    index[4 + i] = num_nodes() + nodes[i];
    value[4 + i] = along_ray * weights[i] * (s - 1.0);
  }
  index[8] = 2 * num_nodes();
  index[9] = 2 * num_nodes() + 1;
  value[8] = -normal.x() * z_mm * ray_x;
  value[9] = -normal.y() * z_mm * ray_y;
  index[10] = 2 * num_nodes() + 2;
  index[11] = 2 * num_nodes() + 3;
  value[10] = -normal.x() * z_mm;
  value[11] = -normal.y() * z_mm;
}

}  // namespace mor::internal
