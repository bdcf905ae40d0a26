// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/internal/prior_evidence.h"

#include <gtest/gtest.h>

namespace mor::internal {
namespace {

const PinholeCamera kCamera{640, 480, 525.0, 525.0, 319.5, 239.5, {}};
constexpr Eigen::Index kPlaces = 60;  ///< Of the skin, each changed on its own.
constexpr ValuePriors kExpected{.growth = {.with_g = 0.0, .square = 0.25}, .skin_mm = 2.0};

/// What is learned where the views tell each of these values to 0.1 mm; no table.
ValuePriors learned(const Eigen::VectorXd& sensor_values, const Eigen::VectorXd& skin_mm) {
  const SensorModel sensor(kCamera, {.columns = 3, .rows = 3});
  EXPECT_EQ(sensor_values.size(), static_cast<Eigen::Index>(sensor.size()));
  Eigen::VectorXd values(sensor_values.size() + skin_mm.size());
  values << sensor_values, skin_mm;
  const Eigen::MatrixXd precision = 100.0 * Eigen::MatrixXd::Identity(values.size(), values.size());
  return learn_priors(sensor,
                      Eigen::MatrixXd::Identity(skin_mm.size(), skin_mm.size()),
                      Eigen::MatrixXd(0, 0),
                      {precision, precision * values},
                      kExpected);
}

/// The first `num_changed` places, in and out.
Eigen::VectorXd changed_by(double mm, Eigen::Index num_changed) {
  Eigen::VectorXd skin_mm = Eigen::VectorXd::Zero(kPlaces);
  for (Eigen::Index i = 0; i < num_changed; ++i) skin_mm[i] = i % 2 == 0 ? mm : -mm;
  return skin_mm;
}

/// g and h at nine control points, and a pinhole as stated.
Eigen::VectorXd sensor_error(double g_mm, double h_mm) {
  Eigen::VectorXd values = Eigen::VectorXd::Zero(22);
  values.head<9>().setConstant(g_mm);
  values.segment<9>(9).setConstant(h_mm);
  return values;
}

TEST(LearnPriors, ABodyAsInItsCtGetsHardlyAnyChange) {
  EXPECT_LT(learned(sensor_error(0.0, 0.0), changed_by(0.05, kPlaces)).skin_mm, 0.2);
  EXPECT_LT(learned(sensor_error(4.0, 0.0), changed_by(0.05, kPlaces)).skin_mm, 0.2);
}

TEST(LearnPriors, ABodyThatHasChangedInPlacesMayHaveChangedByAllThatIsExpected) {
  EXPECT_EQ(learned(sensor_error(0.0, 0.0), changed_by(0.6, kPlaces)).skin_mm, kExpected.skin_mm);
  EXPECT_EQ(learned(sensor_error(4.0, 0.0), changed_by(1.5, kPlaces / 6)).skin_mm,
            kExpected.skin_mm);
}

TEST(LearnPriors, TheErrorGoesWithTheDistanceAsItDoesWhereItIsSeen) {
  for (const double slope : {-1.0, 0.0, 1.0}) {
    const auto growth = learned(sensor_error(4.0, 4.0 * slope), changed_by(0.0, 0)).growth;
    EXPECT_NEAR(growth.with_g, slope, 0.2);
    EXPECT_NEAR(growth.square, slope * slope, 0.2);
  }
}

}  // namespace
}  // namespace mor::internal
