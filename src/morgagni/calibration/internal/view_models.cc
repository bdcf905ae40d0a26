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

constexpr double kSkinSpacingPerReach = 0.9;
/// Of any pattern of residuals on the table, as SelfCalibrationOptions::systematic_mm of the skin.
constexpr double kTableSystematicMm = 0.05;
/// What is farther from the table along the ray lies on it.
constexpr float kOnTableMm = 30.0F;
/// How sensors' errors go with the distance: not at all as time of flight's, in proportion, by its
/// square as a wrong disparity's. h is so much of g, and this much besides.
constexpr std::array<double, 3> kSlopes = {-1.0, 0.0, 1.0};
constexpr double kBesideRatio = 0.2;

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

/// Logarithm, but for a constant, of how probable the views are where the sensor's values have this
/// prior. The views are a Gaussian in these values (Laplace): `precision`, and `pull` = precision
/// times what suits them best.
double log_evidence(const Eigen::MatrixXd& precision,
                    const Eigen::VectorXd& pull,
                    const Eigen::MatrixXd& prior) {
  const Eigen::MatrixXd root = prior.llt().matrixL();
  Eigen::MatrixXd white = root.transpose() * precision * root;
  white.diagonal().array() += 1.0;
  const Eigen::LLT<Eigen::MatrixXd> solver(white);
  const Eigen::VectorXd moved = solver.matrixL().solve(root.transpose() * pull);
  return 0.5 * moved.squaredNorm() - solver.matrixLLT().diagonal().array().log().sum();
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
  growth_.square = options.prior.not_growing_ratio * options.prior.not_growing_ratio;
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
  sensor_prior_ = sensor_.prior_covariance(growth_);
  const auto table = static_cast<Eigen::Index>(sizes_.table);
  prior_precision_ = Eigen::MatrixXd::Zero(sensor + skin + table, sensor + skin + table);
  prior_precision_.topLeftCorner(sensor, sensor) = inverse_of(sensor_prior_);
  prior_precision_.block(sensor, sensor, skin, skin) =
      inverse_of(skin_.prior_covariance(options_.skin_mm, options_.skin_reach_mm));
  if (table_) {
    prior_precision_.bottomRightCorner(table, table) = inverse_of(table_->prior_covariance());
  }
}

void ViewModels::learn_growth(const BundleInformation& information, const BundleState& state) {
  const auto sensor = static_cast<Eigen::Index>(sensor_.size());
  const Eigen::MatrixXd all = information.matrix + prior_precision_;
  const Eigen::VectorXd pull = all * state.values;
  // Of the sensor alone, whatever skin and table are.
  const Eigen::Index rest = all.rows() - sensor;
  const Eigen::MatrixXd across = all.topRightCorner(sensor, rest);
  const Eigen::LLT<Eigen::MatrixXd> of_rest(all.bottomRightCorner(rest, rest));
  const Eigen::MatrixXd precision =
      information.matrix.topLeftCorner(sensor, sensor) - across * of_rest.solve(across.transpose());
  const Eigen::VectorXd pull_alone = pull.head(sensor) - across * of_rest.solve(pull.tail(rest));
  std::vector<DepthGrowth> ways = {growth_};  // Each place of the picture in its own.
  for (const double slope : kSlopes) {
    ways.push_back({.with_g = slope, .square = slope * slope + kBesideRatio * kBesideRatio});
  }
  std::vector<double> logs;
  for (const auto& way : ways) {
    logs.push_back(log_evidence(precision, pull_alone, sensor_.prior_covariance(way)));
  }
  const double most = std::ranges::max(logs);
  double sum = 0.0;
  DepthGrowth mean;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const double share = std::exp(logs[i] - most);
    sum += share;
    mean.with_g += share * ways[i].with_g;
    mean.square += share * ways[i].square;
  }
  growth_ = {.with_g = mean.with_g / sum, .square = mean.square / sum};
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
