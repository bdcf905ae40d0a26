// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/internal/table_model.h"

#include <algorithm>
#include <array>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

namespace mor::internal {
namespace {

const PinholeCamera kCamera{640, 480, 525.0, 525.0, 319.5, 239.5, {}};
const Eigen::Vector3d kBodyMm(0.0, 0.0, 0.0);

/// A block that is read at `z_mm`, all of it.
SkinReading block(int column, int row, double z_mm) {
  SkinReading reading;
  reading.column = static_cast<std::uint16_t>(column);
  reading.row = static_cast<std::uint16_t>(row);
  reading.used = 0xFFFF;
  reading.pixel = {4.0F * static_cast<float>(column) + 1.5F, 4.0F * static_cast<float>(row) + 1.5F};
  reading.z_mm = static_cast<float>(z_mm);
  return reading;
}

/// Straight down from 700 mm above the body's middle, a table 100 mm below that; in the picture's
/// right part a floor 600 mm deeper.
SensedSkin view_from_above(int first_floor_column) {
  SensedSkin view;
  view.ct_from_depth.translation().z() = -700.0;
  for (int row = 0; row < 120; row += 4) {
    for (int column = 0; column < 160; column += 4) {
      view.beside.push_back(block(column, row, column < first_floor_column ? 800.0 : 1400.0));
    }
  }
  return view;
}

TEST(TableModel, IsTheLargestPlaneUnderTheBody) {
  const auto table = TableModel::find({view_from_above(120)}, kCamera, kBodyMm);
  ASSERT_TRUE(table);
  EXPECT_NEAR(table->normal().z(), -1.0, 1e-3) << "to the body";
  EXPECT_GT(table->size(), 10U);
  const auto expected =
      table->expected(block(20, 30, 0.0), kCamera, view_from_above(0).ct_from_depth);
  EXPECT_NEAR(expected.z_mm, 800.0F, 1.0F);
  EXPECT_NEAR(expected.normal.z(), -1.0F, 1e-3F) << "frame depth";
}

TEST(TableModel, IsNotLedAstrayByPlacesThatAreTheSame) {
  auto view = view_from_above(120);
  for (int i = 0; i < 600; ++i) view.beside.push_back(view.beside.front());
  const auto table = TableModel::find({view}, kCamera, kBodyMm);
  ASSERT_TRUE(table);
  EXPECT_NEAR(table->normal().z(), -1.0, 1e-3);
}

TEST(TableModel, IsNoneWhereWhatIsSeenIsNoPlaneUnderTheBody) {
  auto bumpy = view_from_above(160);
  for (std::size_t i = 0; i < bumpy.beside.size(); ++i) {
    bumpy.beside[i].z_mm += static_cast<float>(i * 37 % 211);
  }
  EXPECT_FALSE(TableModel::find({bumpy}, kCamera, kBodyMm));
  EXPECT_FALSE(TableModel::find({view_from_above(160)}, kCamera, {0.0, 0.0, 95.0}))
      << "through the body, not under it";
  EXPECT_FALSE(TableModel::find({}, kCamera, kBodyMm));
}

TEST(TableModel, WeighsControlPointsOnlyWhereItWasRead) {
  const auto table = TableModel::find({view_from_above(160)}, kCamera, kBodyMm);
  ASSERT_TRUE(table);
  std::array<std::uint16_t, TableModel::kNumTouched> index{};
  std::array<float, TableModel::kNumTouched> share{};
  ASSERT_TRUE(table->weights({10.0, 20.0, 100.0}, index, share));
  EXPECT_NEAR(share[0] + share[1] + share[2] + share[3], 1.0F, 1e-5F);
  EXPECT_TRUE(std::ranges::is_sorted(index));
  EXPECT_FALSE(table->weights({5000.0, 0.0, 100.0}, index, share));
  // A height of all of it, or a tilt, is nothing unusual; an unevenness of as much is.
  const Eigen::MatrixXd prior = table->prior_covariance();
  const Eigen::VectorXd height = Eigen::VectorXd::Constant(prior.rows(), 5.0);
  Eigen::VectorXd uneven = height;
  for (Eigen::Index i = 0; i < uneven.size(); i += 2) uneven[i] = -5.0;
  const Eigen::LLT<Eigen::MatrixXd> solver(prior);
  EXPECT_LT(height.dot(solver.solve(height)), 1.0);
  EXPECT_GT(uneven.dot(solver.solve(uneven)), 50.0);
}

}  // namespace
}  // namespace mor::internal
