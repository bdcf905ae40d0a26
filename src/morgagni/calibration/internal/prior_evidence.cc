// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/internal/prior_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

namespace mor::internal {
namespace {

/// How sensors' errors go with the distance: not at all as time of flight's, in proportion, by its
/// square as a wrong disparity's. h is so much of g, and this much besides.
constexpr std::array<double, 3> kSlopes = {-1.0, 0.0, 1.0};
constexpr double kBesideRatio = 0.2;
/// A body as in its CT is found changed by no more: what noise model and field leave.
constexpr double kAsInCtMm = 0.125;
/// A body has changed where this explains the views better. It says no more than that: bodies
/// change unevenly, and where one has changed most, its mean change as the prior lays the rest on
/// the sensor.
constexpr double kHasChangedMm = 0.5;

/// Half the logarithm of a determinant.
double half_log_determinant(const Eigen::LLT<Eigen::MatrixXd>& solver) {
  return solver.matrixLLT().diagonal().array().log().sum();
}

/// What the views say of the sensor alone, whatever skin and table are, and how probable they are
/// but for that: logarithm, but for a constant.
struct SensorAlone {
  ViewsSay views;
  double log_evidence = 0.0;
};

SensorAlone sensor_alone(const ViewsSay& views,
                         Eigen::Index num_sensor,
                         const Eigen::MatrixXd& skin_precision,
                         double skin_mm,
                         const Eigen::MatrixXd& table_precision) {
  const Eigen::Index skin = skin_precision.rows();
  const Eigen::Index table = table_precision.rows();
  const Eigen::Index rest = skin + table;
  Eigen::MatrixXd of_rest = views.precision.bottomRightCorner(rest, rest);
  of_rest.topLeftCorner(skin, skin) += skin_precision / (skin_mm * skin_mm);
  of_rest.bottomRightCorner(table, table) += table_precision;
  const Eigen::LLT<Eigen::MatrixXd> solver(of_rest);
  const Eigen::MatrixXd across =
      solver.matrixL().solve(views.precision.bottomLeftCorner(rest, num_sensor));
  const Eigen::VectorXd moved = solver.matrixL().solve(views.pull.tail(rest));
  return {{views.precision.topLeftCorner(num_sensor, num_sensor) - across.transpose() * across,
           views.pull.head(num_sensor) - across.transpose() * moved},
          0.5 * moved.squaredNorm() - half_log_determinant(solver) -
              static_cast<double>(skin) * std::log(skin_mm)};
}

/// Logarithm, but for a constant, of how probable the views are where the values have this prior.
double log_evidence(const ViewsSay& views, const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd root = covariance.llt().matrixL();
  Eigen::MatrixXd white = root.transpose() * views.precision * root;
  white.diagonal().array() += 1.0;
  const Eigen::LLT<Eigen::MatrixXd> solver(white);
  const Eigen::VectorXd moved = solver.matrixL().solve(root.transpose() * views.pull);
  return 0.5 * moved.squaredNorm() - half_log_determinant(solver);
}

}  // namespace

ValuePriors learn_priors(const SensorModel& sensor,
                         const Eigen::MatrixXd& skin_precision,
                         const Eigen::MatrixXd& table_precision,
                         const ViewsSay& views,
                         const ValuePriors& expected) {
  std::vector<DepthGrowth> ways = {expected.growth};  // Each place of the picture in its own.
  for (const double slope : kSlopes) {
    ways.push_back({.with_g = slope, .square = slope * slope + kBesideRatio * kBesideRatio});
  }
  struct Explained {
    double log_evidence;
    DepthGrowth growth;
    bool has_changed;
  };
  std::vector<Explained> all;
  for (const bool has_changed : {false, true}) {
    const auto alone = sensor_alone(views,
                                    static_cast<Eigen::Index>(sensor.size()),
                                    skin_precision,
                                    has_changed ? kHasChangedMm : kAsInCtMm,
                                    table_precision);
    for (const auto& way : ways) {
      const double of_sensor = log_evidence(alone.views, sensor.prior_covariance(way));
      all.push_back({alone.log_evidence + of_sensor, way, has_changed});
    }
  }
  const auto best = std::ranges::max_element(all, {}, &Explained::log_evidence);
  double sum = 0.0;
  DepthGrowth mean;
  for (const auto& one : all) {
    const double share = std::exp(one.log_evidence - best->log_evidence);
    sum += share;
    mean.with_g += share * one.growth.with_g;
    mean.square += share * one.growth.square;
  }
  return {{.with_g = mean.with_g / sum, .square = mean.square / sum},
          best->has_changed ? expected.skin_mm : kAsInCtMm};
}

}  // namespace mor::internal
