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
constexpr std::size_t kMaxSteps = 14;
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

}  // namespace

/// Which of all values a model frees, and where each of all stands among those.
struct Bundle::FreeValues {
  static constexpr Eigen::Index kHeld = -1;

  FreeValues(std::size_t sensor, const BundleSizes& sizes, BundleModel model) {
    const bool has_sensor = model == BundleModel::kSensor || model == BundleModel::kSensorAndSkin;
    const bool has_skin = model == BundleModel::kSkin || model == BundleModel::kSensorAndSkin;
    add(sensor, has_sensor);
    add(sizes.skin, has_skin);
    add(sizes.table, true);
  }

  void add(std::size_t count, bool is_free) {
    for (std::size_t i = 0; i < count; ++i) {
      if (is_free) values.push_back(static_cast<Eigen::Index>(place.size()));
      place.push_back(is_free ? static_cast<Eigen::Index>(values.size()) - 1 : kHeld);
    }
  }

  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(values.size()); }

  std::vector<Eigen::Index> values;
  std::vector<Eigen::Index> place;
};

/// Of one view; `values` and `values_gradient` are summed over views.
struct Bundle::Equations {
  explicit Equations(Eigen::Index size)
      : values(Eigen::MatrixXd::Zero(size, size)), values_gradient(Eigen::VectorXd::Zero(size)) {}

  void start_view() {
    pose = pose_prior();
    pose_gradient.setZero();
    pose_by_values = Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, values.cols());
  }

  Eigen::MatrixXd values;  ///< The upper triangle.
  Eigen::VectorXd values_gradient;
  Matrix6d pose = Matrix6d::Zero();
  Vector6d pose_gradient = Vector6d::Zero();
  Eigen::Matrix<double, 6, Eigen::Dynamic> pose_by_values;
};

Bundle::Bundle(const SensorModel& sensor,
               const BundleSizes& sizes,
               const std::vector<View>& views,
               const Eigen::MatrixXd& prior_precision,
               const Eigen::Vector3d& pivot_mm)
    : sensor_(sensor),
      sizes_(sizes),
      views_(views),
      prior_precision_(prior_precision),
      pivot_mm_(pivot_mm) {}

double Bundle::distance_mm(const SensorReading& reading,
                           const BundleState& state,
                           const Eigen::Vector3d& place_mm) const {
  double distance_mm = reading.normal.dot(place_mm - reading.place_mm);
  for (std::size_t i = 0; i < reading.num_surface; ++i) {
    const auto index = static_cast<Eigen::Index>(sensor_.size() + reading.surface_index[i]);
    distance_mm -= static_cast<double>(reading.surface_share[i]) * state.values[index];
  }
  return distance_mm;
}

void Bundle::linearize(std::span<const SensorReading> readings,
                       const Eigen::Isometry3d& pose,
                       const BundleState& state,
                       double scale_mm,
                       const FreeValues* free,
                       Equations& equations) const {
  const Eigen::Matrix3d depth_from_ct = pose.linear().transpose();
  const std::span<const double> sensor_values(state.values.data(), sensor_.size());
  std::array<std::size_t, SensorModel::kNumTouched> sensor_index{};
  std::array<double, SensorModel::kNumTouched> sensor_value{};
  std::array<Eigen::Index, kMaxTouched> index{};
  std::array<double, kMaxTouched> value{};
  for (const auto& reading : readings) {
    if (!(reading.weight > 0.0F)) continue;
    const Eigen::Vector3d place = pose * sensor_.corrected(reading, sensor_values);
    const double distance = distance_mm(reading, state, place);
    const double weight = static_cast<double>(reading.weight) * tukey_weight(distance, scale_mm);
    if (!(weight > 0.0)) continue;
    Vector6d row;
    row << (place - pivot_mm_).cross(reading.normal), reading.normal;
    equations.pose.selfadjointView<Eigen::Upper>().rankUpdate(row, weight);
    equations.pose_gradient += weight * distance * row;
    if (free == nullptr) continue;
    std::size_t count = 0;
    const auto put = [&](std::size_t at, double slope) {
      index[count] = free->place[at];
      value[count] = slope;
      count += index[count] != FreeValues::kHeld ? 1 : 0;
    };
    sensor_.derivatives(reading, depth_from_ct * reading.normal, sensor_index, sensor_value);
    for (std::size_t i = 0; i < sensor_index.size(); ++i) put(sensor_index[i], sensor_value[i]);
    for (std::size_t i = 0; i < reading.num_surface; ++i) {
      put(sensor_.size() + reading.surface_index[i],
          -static_cast<double>(reading.surface_share[i]));
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
}

void Bundle::fit(std::span<const std::size_t> views,
                 BundleModel model,
                 BundleStart start,
                 BundleState& state) const {
  const FreeValues free(sensor_.size(), sizes_, model);
  if (free.size() == 0) {
    for (const std::size_t view : views) fit_pose(view, state);
    return;
  }
  const Eigen::MatrixXd prior = prior_precision_(free.values, free.values);
  const std::size_t first = start == BundleStart::kNear ? kScalesMm.size() : 0;
  for (std::size_t step = first; step < kMaxSteps; ++step) {
    const double scale_mm = step < kScalesMm.size() ? kScalesMm[step] : kLastScaleMm;
    const double most_mm = take_step(views, free, prior, scale_mm, state);
    if (step >= kScalesMm.size() && most_mm < kEnoughMm) break;
  }
}

/// @return The greatest change of a value.
double Bundle::take_step(std::span<const std::size_t> views,
                         const FreeValues& free,
                         const Eigen::MatrixXd& prior,
                         double scale_mm,
                         BundleState& state) const {
  const auto num_rows = 6 * static_cast<Eigen::Index>(views.size());
  Equations sums(free.size());
  std::vector<Eigen::LLT<Matrix6d>> poses;
  // Of each view: the root's inverse of its pose's block, times what couples it to the values and
  // times its gradient. What the elimination takes away is their square.
  Eigen::MatrixXd couplings(num_rows, free.size());
  Eigen::VectorXd gradients(num_rows);
  for (const std::size_t view : views) {
    sums.start_view();
    linearize(views_[view].readings, state.ct_from_depth[view], state, scale_mm, &free, sums);
    const auto row = 6 * static_cast<Eigen::Index>(poses.size());
    poses.emplace_back(sums.pose);
    couplings.middleRows<6>(row) = poses.back().matrixL().solve(sums.pose_by_values);
    gradients.segment<6>(row) = poses.back().matrixL().solve(sums.pose_gradient);
  }
  sums.values += prior;
  sums.values.selfadjointView<Eigen::Upper>().rankUpdate(couplings.transpose(), -1.0);
  const Eigen::VectorXd gradient =
      sums.values_gradient + prior * state.values(free.values) - couplings.transpose() * gradients;
  const Eigen::LLT<Eigen::MatrixXd, Eigen::Upper> solver(sums.values);
  const Eigen::VectorXd change = -solver.solve(gradient);
  state.values(free.values) += change;
  const Eigen::VectorXd moves = -(gradients + couplings * change);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Vector6d root = moves.segment<6>(6 * static_cast<Eigen::Index>(i));
    add_step(poses[i].matrixU().solve(root), pivot_mm_, state.ct_from_depth[views[i]]);
  }
  return change.cwiseAbs().maxCoeff();
}

void Bundle::fit_pose(std::size_t view, BundleState& state) const {
  for (std::size_t step = 0; step < kMaxSteps; ++step) {
    const double scale_mm = step < kScalesMm.size() ? kScalesMm[step] : kLastScaleMm;
    Equations equations(0);
    equations.start_view();
    linearize(
        views_[view].readings, state.ct_from_depth[view], state, scale_mm, nullptr, equations);
    const Vector6d move = -equations.pose.llt().solve(equations.pose_gradient);
    add_step(move, pivot_mm_, state.ct_from_depth[view]);
    if (step >= kScalesMm.size() && move.tail<3>().norm() < kEnoughMm) break;
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
  const FreeValues all_values(sensor_.size(), sizes_, BundleModel::kSensorAndSkin);
  BundleInformation result;
  result.pivot_mm = pivot_mm_;
  Equations sums(all_values.size());
  Eigen::MatrixXd eliminated = Eigen::MatrixXd::Zero(all_values.size(), all_values.size());
  for (const std::size_t view : views) {
    const Eigen::Isometry3d& pose = state.ct_from_depth[view];
    const std::span<const SensorReading> all(views_[view].readings);
    const auto on_skin = all.first(views_[view].num_on_skin);
    sums.start_view();
    linearize(on_skin, pose, state, kLastScaleMm, &all_values, sums);
    result.pose_from_values.emplace_back(-sums.pose.inverse() * sums.pose_by_values);
    linearize(all.subspan(on_skin.size()), pose, state, kLastScaleMm, &all_values, sums);
    const Eigen::MatrixXd coupling = sums.pose.llt().matrixL().solve(sums.pose_by_values);
    eliminated.selfadjointView<Eigen::Upper>().rankUpdate(coupling.transpose());
  }
  const Eigen::MatrixXd left = sums.values - eliminated;
  result.matrix = left.selfadjointView<Eigen::Upper>();
  return result;
}

}  // namespace mor::internal
