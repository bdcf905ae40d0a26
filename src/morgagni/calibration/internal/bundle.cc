// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/internal/bundle.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

namespace mor::internal {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Of Tukey's kernel: wide enough for a sensor's error at first.
constexpr std::array<double, 4> kScalesMm = {6.0, 5.0, 4.0, 3.0};
constexpr double kLastScaleMm = 2.5;
constexpr int kMaxSteps = 14;
constexpr double kEnoughMm = 0.01;  ///< A step that moves no value by more is the last.
/// A tracked pose is right to about so much: keeps what the shape leaves open.
constexpr double kPoseShiftMm = 20.0;
constexpr double kPoseTurnRad = 0.1;

constexpr std::size_t kMaxTouched = SensorModel::kNumTouched + 8;

double tukey_weight(double distance_mm, double scale_mm) {
  const double ratio = distance_mm / scale_mm;
  const double rest = std::max(0.0, 1.0 - ratio * ratio);
  return rest * rest;
}

/// Twice Tukey's loss: distance squared near 0, a third of scale squared far away.
double tukey_loss_mm2(double distance_mm, double scale_mm) {
  const double ratio = distance_mm / scale_mm;
  const double rest = std::max(0.0, 1.0 - ratio * ratio);
  return scale_mm * scale_mm / 3.0 * (1.0 - rest * rest * rest);
}

void add_step(const Vector6d& step, const Eigen::Vector3d& pivot, Eigen::Isometry3d& pose) {
  const Eigen::Vector3d turn = step.head<3>();
  const double angle = turn.norm();
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.translate(pivot + step.tail<3>());
  if (angle > 0.0) motion.rotate(Eigen::AngleAxisd(angle, turn / angle));
  motion.translate(-pivot);
  pose = motion * pose;
}

Matrix6d pose_prior() {
  Matrix6d prior = Matrix6d::Zero();
  prior.diagonal().head<3>().setConstant(1.0 / (kPoseTurnRad * kPoseTurnRad));
  prior.diagonal().tail<3>().setConstant(1.0 / (kPoseShiftMm * kPoseShiftMm));
  return prior;
}

/// Which of the values a model frees.
std::vector<Eigen::Index> free_values(BundleModel model, std::size_t sensor, std::size_t skin) {
  std::vector<Eigen::Index> free;
  const bool has_sensor = model == BundleModel::kSensor || model == BundleModel::kSensorAndSkin;
  const bool has_skin = model == BundleModel::kSkin || model == BundleModel::kSensorAndSkin;
  for (std::size_t i = 0; has_sensor && i < sensor; ++i) {
    free.push_back(static_cast<Eigen::Index>(i));
  }
  for (std::size_t i = 0; has_skin && i < skin; ++i) {
    free.push_back(static_cast<Eigen::Index>(sensor + i));
  }
  return free;
}

}  // namespace

/// Of one view; `values` and `values_gradient` are summed over views.
struct Bundle::Equations {
  explicit Equations(std::size_t size)
      : values(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(size),
                                     static_cast<Eigen::Index>(size))),
        values_gradient(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(size))) {}

  void start_view(std::size_t size) {
    pose.setZero();
    pose_gradient.setZero();
    pose_by_values =
        Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, static_cast<Eigen::Index>(size));
  }

  Eigen::MatrixXd values;  ///< The upper triangle.
  Eigen::VectorXd values_gradient;
  Matrix6d pose = Matrix6d::Zero();
  Vector6d pose_gradient = Vector6d::Zero();
  Eigen::Matrix<double, 6, Eigen::Dynamic> pose_by_values;
};

Bundle::Bundle(const SensorModel& sensor,
               std::size_t skin_size,
               const std::vector<View>& views,
               const Eigen::MatrixXd& prior_precision,
               const Eigen::Vector3d& pivot_mm)
    : sensor_(sensor),
      skin_size_(skin_size),
      views_(views),
      prior_precision_(prior_precision),
      pivot_mm_(pivot_mm) {}

double Bundle::distance_mm(const SensorReading& reading,
                           const BundleState& state,
                           const Eigen::Vector3d& place_mm) const {
  double distance_mm = reading.normal.dot(place_mm - reading.place_mm);
  for (std::size_t i = 0; reading.on_skin_model && i < reading.skin_index.size(); ++i) {
    const auto index = static_cast<Eigen::Index>(sensor_.size() + reading.skin_index[i]);
    distance_mm -= static_cast<double>(reading.skin_share[i]) * state.values[index];
  }
  return distance_mm;
}

void Bundle::linearize(std::size_t view,
                       const BundleState& state,
                       double scale_mm,
                       bool has_values,
                       Equations& equations) const {
  const Eigen::Isometry3d& pose = state.ct_from_depth[view];
  const Eigen::Matrix3d depth_from_ct = pose.linear().transpose();
  const std::size_t sensor_size = sensor_.size();
  const std::span<const double> sensor_values(state.values.data(), sensor_size);
  std::array<std::size_t, SensorModel::kNumTouched> sensor_index{};
  std::array<double, SensorModel::kNumTouched> sensor_value{};
  std::array<Eigen::Index, kMaxTouched> index{};
  std::array<double, kMaxTouched> value{};
  for (const auto& reading : views_[view].readings) {
    if (!(reading.weight > 0.0F)) continue;
    const Eigen::Vector3d place = pose * sensor_.corrected(reading, sensor_values);
    const double distance = distance_mm(reading, state, place);
    const double weight = static_cast<double>(reading.weight) * tukey_weight(distance, scale_mm);
    if (!(weight > 0.0)) continue;
    Vector6d row;
    row << (place - pivot_mm_).cross(reading.normal), reading.normal;
    equations.pose.selfadjointView<Eigen::Upper>().rankUpdate(row, weight);
    equations.pose_gradient += weight * distance * row;
    if (!has_values) continue;
    sensor_.derivatives(reading, depth_from_ct * reading.normal, sensor_index, sensor_value);
    std::size_t count = 0;
    for (std::size_t i = 0; i < sensor_index.size(); ++i, ++count) {
      index[count] = static_cast<Eigen::Index>(sensor_index[i]);
      value[count] = sensor_value[i];
    }
    for (std::size_t i = 0; reading.on_skin_model && i < reading.skin_index.size(); ++i, ++count) {
      index[count] = static_cast<Eigen::Index>(sensor_size + reading.skin_index[i]);
      value[count] = -static_cast<double>(reading.skin_share[i]);
    }
    // Indices ascend, so this fills the upper triangle.
    for (std::size_t b = 0; b < count; ++b) {
      const double weighted = weight * value[b];
      for (std::size_t a = 0; a <= b; ++a) {
        equations.values(index[a], index[b]) += weighted * value[a];
      }
      equations.values_gradient[index[b]] += weighted * distance;
      equations.pose_by_values.col(index[b]) += weighted * row;
    }
  }
  equations.pose = equations.pose.selfadjointView<Eigen::Upper>();
  equations.pose += pose_prior();
}

void Bundle::fit(std::span<const std::size_t> views, BundleModel model, BundleState& state) const {
  const std::size_t size = sensor_.size() + skin_size_;
  const auto free = free_values(model, sensor_.size(), skin_size_);
  if (free.empty()) {
    for (const std::size_t view : views) fit_pose(view, state);
    return;
  }
  const Eigen::MatrixXd prior = prior_precision_(free, free);
  for (int step = 0; step < kMaxSteps; ++step) {
    const auto at = static_cast<std::size_t>(step);
    const double scale_mm = at < kScalesMm.size() ? kScalesMm[at] : kLastScaleMm;
    Equations sums(size);
    std::vector<Matrix6d> inverse(views.size());
    std::vector<Vector6d> gradients(views.size());
    std::vector<Eigen::Matrix<double, 6, Eigen::Dynamic>> couplings(views.size());
    for (std::size_t i = 0; i < views.size(); ++i) {
      sums.start_view(size);
      linearize(views[i], state, scale_mm, true, sums);
      inverse[i] = sums.pose.inverse();
      gradients[i] = sums.pose_gradient;
      couplings[i] = sums.pose_by_values(Eigen::all, free);
    }
    const Eigen::MatrixXd full = sums.values.selfadjointView<Eigen::Upper>();
    Eigen::MatrixXd matrix = full(free, free) + prior;
    Eigen::VectorXd gradient = sums.values_gradient(free) + prior * state.values(free);
    for (std::size_t i = 0; i < views.size(); ++i) {
      const Eigen::MatrixXd half = inverse[i] * couplings[i];
      matrix.noalias() -= couplings[i].transpose() * half;
      gradient.noalias() -= half.transpose() * gradients[i];
    }
    const Eigen::VectorXd change = -matrix.llt().solve(gradient);
    state.values(free) += change;
    for (std::size_t i = 0; i < views.size(); ++i) {
      const Vector6d move = -inverse[i] * (gradients[i] + couplings[i] * change);
      add_step(move, pivot_mm_, state.ct_from_depth[views[i]]);
    }
    if (at >= kScalesMm.size() && change.cwiseAbs().maxCoeff() < kEnoughMm) break;
  }
}

void Bundle::fit_pose(std::size_t view, BundleState& state) const {
  const std::size_t size = 0;
  for (int step = 0; step < kMaxSteps; ++step) {
    const auto at = static_cast<std::size_t>(step);
    const double scale_mm = at < kScalesMm.size() ? kScalesMm[at] : kLastScaleMm;
    Equations equations(size);
    equations.start_view(size);
    linearize(view, state, scale_mm, false, equations);
    const Vector6d move = -equations.pose.llt().solve(equations.pose_gradient);
    add_step(move, pivot_mm_, state.ct_from_depth[view]);
    if (at >= kScalesMm.size() && move.tail<3>().norm() < kEnoughMm) break;
  }
}

ViewFit Bundle::judge(std::size_t view, const BundleState& state) const {
  const Eigen::Isometry3d& pose = state.ct_from_depth[view];
  const std::span<const double> sensor_values(state.values.data(), sensor_.size());
  ViewFit fit;
  for (const auto& reading : views_[view].readings) {
    const auto weight = static_cast<double>(reading.weight);
    if (!(weight > 0.0)) continue;
    const Eigen::Vector3d place = pose * sensor_.corrected(reading, sensor_values);
    fit.sum_weights += weight;
    fit.sum_sq_mm2 += weight * tukey_loss_mm2(distance_mm(reading, state, place), kLastScaleMm);
  }
  return fit;
}

std::vector<float> Bundle::residuals(std::size_t view, const BundleState& state) const {
  const std::span<const double> sensor_values(state.values.data(), sensor_.size());
  std::vector<float> residuals;
  for (const auto& reading : views_[view].readings) {
    const Eigen::Vector3d place =
        state.ct_from_depth[view] * sensor_.corrected(reading, sensor_values);
    residuals.push_back(std::sqrt(reading.weight) *
                        static_cast<float>(distance_mm(reading, state, place)));
  }
  return residuals;
}

BundleInformation Bundle::information(std::span<const std::size_t> views,
                                      const BundleState& state) const {
  const std::size_t size = sensor_.size() + skin_size_;
  BundleInformation result;
  result.pivot_mm = pivot_mm_;
  Equations sums(size);
  Eigen::MatrixXd eliminated =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(size), static_cast<Eigen::Index>(size));
  for (const std::size_t view : views) {
    sums.start_view(size);
    linearize(view, state, kLastScaleMm, true, sums);
    const Eigen::MatrixXd follows = -sums.pose.inverse() * sums.pose_by_values;
    eliminated.noalias() += sums.pose_by_values.transpose() * follows;
    result.pose_from_values.push_back(follows);
  }
  result.matrix = sums.values.selfadjointView<Eigen::Upper>();
  result.matrix += eliminated;
  return result;
}

}  // namespace mor::internal
