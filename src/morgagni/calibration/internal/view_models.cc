// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/internal/view_models.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include "morgagni/calibration/internal/readings_scatter.h"
#include "morgagni/core/statistics.h"

namespace mor::internal {
namespace {

constexpr double kSkinSpacingPerReach = 0.6;
/// Of any pattern of residuals on the table, as SelfCalibrationOptions::systematic_mm of the skin.
constexpr double kTableSystematicMm = 0.05;
/// What is farther from the table along the ray lies on it.
constexpr float kOnTableMm = 30.0F;

/// Where an ideal camera would read, and how much the reading counts.
void set_expected(const ExpectedReading& expected,
                  const PinholeCamera& camera,
                  const Eigen::Isometry3d& pose,
                  const SkinReading& read,
                  SensorReading& reading) {
  const Eigen::Vector2d ray = camera.ray(read.pixel.cast<double>());
  const Eigen::Vector3d direction(ray.x(), ray.y(), 1.0);
  const Eigen::Vector3d normal = expected.normal.cast<double>();
  const double cosine = -normal.dot(direction.normalized());
  reading.place_mm = pose * (static_cast<double>(expected.z_mm) * direction);
  reading.normal = pose.linear() * normal;
  reading.weight =
      static_cast<float>(SensorModel::weight(static_cast<double>(expected.z_mm), cosine));
}

}  // namespace

Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& covariance) {
  return covariance.llt().solve(Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols()));
}

ViewModels::ViewModels(const TriangleMesh& skin,
                       const PinholeCamera& depth,
                       const std::vector<SensedSkin>& views,
                       const SelfCalibrationOptions& options)
    : mesh_(skin),
      depth_(depth),
      views_(views),
      options_(options),
      sensor_(depth, options),
      skin_(skin.bounds().cast<double>(), kSkinSpacingPerReach * options.skin_reach_mm),
      pivot_mm_(skin.bounds().center().cast<double>()) {
  for (const auto& view : views) start_.ct_from_depth.push_back(view.ct_from_depth);
  start_.values = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(sensor_.size()));
  find_seen_skin();
  table_ = TableModel::find(views, depth, pivot_mm_);
  sizes_ = {skin_.size(), table_ ? table_->size() : 0};
  start_.values =
      Eigen::VectorXd::Zero(static_cast<Eigen::Index>(sensor_.size() + sizes_.skin + sizes_.table));
  priors_.growth.square = options.prior.not_growing_ratio * options.prior.not_growing_ratio;
  priors_.skin_mm = options.skin_mm;
  skin_precision_ = inverse_of(skin_.prior_covariance(options.skin_reach_mm));
  set_prior();
}

void ViewModels::find_seen_skin() {
  for (const auto& view : expected(start_)) {
    for (std::size_t i = 0; i < view.num_on_skin; ++i) {
      const auto& reading = view.readings[i];
      if (!(reading.weight > 0.0F)) continue;
      skin_.touch(reading.place_mm);
      seen_mm_.push_back(reading.place_mm);
    }
  }
  skin_.settle();
}

PinholeCamera ViewModels::camera_of(const BundleState& state) const {
  const double* pinhole = state.values.data() + 2 * sensor_.num_nodes();
  PinholeCamera camera = depth_;
  camera.focal_x_px *= 1.0 + pinhole[0];
  camera.focal_y_px *= 1.0 + pinhole[1];
  camera.center_x_px += pinhole[2] * depth_.focal_x_px;
  camera.center_y_px += pinhole[3] * depth_.focal_y_px;
  return camera;
}

std::vector<Bundle::View> ViewModels::expected(const BundleState& state) const {
  const PinholeCamera camera = camera_of(state);
  std::vector<Bundle::View> result(views_.size());
  for (std::size_t i = 0; i < views_.size(); ++i) {
    const Eigen::Isometry3d& pose = state.ct_from_depth[i];
    const auto picture = expected_depth(mesh_, camera, pose);
    result[i].readings.reserve(views_[i].readings.size() + views_[i].beside.size());
    for (const auto& read : views_[i].readings) {
      auto reading = sensor_.reading(read);
      const auto expected = expected_reading(read, picture, camera);
      if (expected.z_mm > 0.0F) {
        set_expected(expected, camera, pose, read, reading);
        reading.weight *= static_cast<float>(weight_factor_);
        if (skin_.weights(reading.place_mm, reading.surface_index, reading.surface_share)) {
          reading.num_surface = SkinModel::kNumTouched;
        }
      }
      result[i].readings.push_back(reading);
    }
    result[i].num_on_skin = result[i].readings.size();
    if (table_) add_table(camera, pose, views_[i].beside, result[i].readings);
  }
  return result;
}

void ViewModels::add_table(const PinholeCamera& camera,
                           const Eigen::Isometry3d& pose,
                           const std::vector<SkinReading>& beside,
                           std::vector<SensorReading>& readings) const {
  std::array<std::uint16_t, TableModel::kNumTouched> index{};
  std::array<float, TableModel::kNumTouched> share{};
  for (const auto& read : beside) {
    auto reading = sensor_.reading(read);
    const auto expected = table_->expected(read, camera, pose);
    if (!(expected.z_mm > 0.0F) || std::abs(expected.z_mm - read.z_mm) > kOnTableMm) continue;
    set_expected(expected, camera, pose, read, reading);
    if (!table_->weights(reading.place_mm, index, share)) continue;
    reading.weight *= static_cast<float>(table_weight_factor_);
    reading.num_surface = index.size();
    for (std::size_t i = 0; i < index.size(); ++i) {
      reading.surface_index[i] = static_cast<std::uint16_t>(sizes_.skin + index[i]);
      reading.surface_share[i] = share[i];
    }
    readings.push_back(reading);
  }
}

void ViewModels::set_prior() {
  const auto sensor = static_cast<Eigen::Index>(sensor_.size());
  const auto skin = static_cast<Eigen::Index>(skin_.size());
  sensor_prior_ = sensor_.prior_covariance(priors_.growth);
  const auto table = static_cast<Eigen::Index>(sizes_.table);
  prior_precision_ = Eigen::MatrixXd::Zero(sensor + skin + table, sensor + skin + table);
  prior_precision_.topLeftCorner(sensor, sensor) = inverse_of(sensor_prior_);
  prior_precision_.block(sensor, sensor, skin, skin) =
      skin_precision_ / (priors_.skin_mm * priors_.skin_mm);
  if (table_) {
    prior_precision_.bottomRightCorner(table, table) = inverse_of(table_->prior_covariance());
  }
}

void ViewModels::learn_priors(const BundleInformation& information, const BundleState& state) {
  const auto table = static_cast<Eigen::Index>(sizes_.table);
  const ViewsSay views{information.matrix, (information.matrix + prior_precision_) * state.values};
  priors_ = internal::learn_priors(
      sensor_, skin_precision_, prior_precision_.bottomRightCorner(table, table), views, priors_);
  set_prior();
}

Bundle ViewModels::bundle(const std::vector<Bundle::View>& expected) const {
  return Bundle(sensor_, sizes_, expected, prior_precision_, pivot_mm_);
}

ReadingsScatter ViewModels::scatter_of(const std::vector<Bundle::View>& expected,
                                       const BundleState& state) const {
  const Bundle fitted = bundle(expected);
  const int columns = depth_.width_px / SkinReading::kBlockPx + 1;
  const int rows = depth_.height_px / SkinReading::kBlockPx + 1;
  std::vector<Image<float>> pictures;
  std::vector<double> sizes;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    Image<float> picture(columns, rows, kNoResidual);
    const auto residuals = fitted.residuals(i, state);
    for (std::size_t k = 0; k < expected[i].num_on_skin; ++k) {
      if (!(expected[i].readings[k].weight > 0.0F)) continue;
      picture(views_[i].readings[k].column, views_[i].readings[k].row) = residuals[k];
      sizes.push_back(std::abs(static_cast<double>(residuals[k])));
    }
    pictures.push_back(std::move(picture));
  }
  ReadingsScatter scatter;
  if (sizes.size() < 1000) return scatter;
  constexpr double kSdPerMedian = 1.4826;
  scatter.ratio = kSdPerMedian * quantile(std::move(sizes), 0.5);
  scatter.correlated = correlated_readings(pictures, static_cast<float>(3.0 * scatter.ratio));
  return scatter;
}

void ViewModels::weigh_by(const ReadingsScatter& scatter,
                          const std::vector<Bundle::View>& expected) {
  double on_skin = 0.0;
  double on_table = 0.0;
  for (const auto& view : expected) {
    for (std::size_t i = 0; i < view.readings.size(); ++i) {
      (i < view.num_on_skin ? on_skin : on_table) += static_cast<double>(view.readings[i].weight);
    }
  }
  const double by_scatter = scatter.ratio * scatter.ratio * scatter.correlated;
  const auto squared = [](double mm) { return mm * mm; };
  weight_factor_ = 1.0 / (by_scatter + squared(options_.systematic_mm) * on_skin);
  table_weight_factor_ = 1.0 / (by_scatter + squared(kTableSystematicMm) * on_table);
}

}  // namespace mor::internal
