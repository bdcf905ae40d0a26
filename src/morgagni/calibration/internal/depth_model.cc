// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/internal/depth_model.h"

#include <algorithm>
#include <cmath>

namespace mor::internal {
namespace {

constexpr double kKnotStepMm = 120.0;
/// What is believed before anything is read, standard deviations in mm at the reference distance:
/// the amount itself, and how far it bends from control point to control point.
constexpr double kAmountSdMm = 25.0;
constexpr double kBendSdMm = 1.5;
constexpr double kCurveBendSdMm = 4.0;

LinearRow bend(int i, int step, double sd_mm) {
  return {{{i - step, 1.0}, {i, -2.0}, {i + step, 1.0}}, 0.0, sd_mm};
}

}  // namespace

DepthModel::DepthModel(const DepthFitOptions& options,
                       DepthForm form,
                       int width_px,
                       int height_px,
                       double near_mm,
                       double far_mm)
    : columns_(options.columns),
      rows_(options.rows),
      form_(form),
      width_px_(width_px),
      height_px_(height_px),
      near_mm_(near_mm),
      far_mm_(far_mm) {
  if (form_ != DepthForm::kTimeOfFlight) return;
  const int steps = std::max(2, static_cast<int>(std::lround((far_mm - near_mm) / kKnotStepMm)));
  for (int i = 0; i <= steps; ++i) knots_mm_.push_back(near_mm + (far_mm - near_mm) * i / steps);
}

int DepthModel::num_unknowns() const {
  return num_points() * fields() + static_cast<int>(knots_mm_.size());
}

LinearRow DepthModel::row(const DepthReading& reading) const {
  LinearRow row;
  row.amount = reading.true_mm - reading.seen_mm;
  const double along = std::clamp(reading.seen_mm, near_mm_, far_mm_) / kReferenceMm;
  row.sd = form_ == DepthForm::kDisparity ? 0.5 + along * along : 0.5 + along;
  const double x = std::clamp(reading.px.x() / (width_px_ - 1), 0.0, 1.0) * (columns_ - 1);
  const double y = std::clamp(reading.px.y() / (height_px_ - 1), 0.0, 1.0) * (rows_ - 1);
  const int x0 = std::min(static_cast<int>(x), columns_ - 2);
  const int y0 = std::min(static_cast<int>(y), rows_ - 2);
  for (int k = 0; k < 4; ++k) {
    const int px = x0 + k % 2;
    const int py = y0 + k / 2;
    const double weight = (k % 2 == 0 ? x0 + 1 - x : x - x0) * (k / 2 == 0 ? y0 + 1 - y : y - y0);
    const int point = py * columns_ + px;
    if (form_ == DepthForm::kDisparity) {
      row.entries.emplace_back(point, weight * along);
      row.entries.emplace_back(num_points() + point, weight * along * along);
    } else {
      row.entries.emplace_back(point, weight);
    }
  }
  add_knots(reading.seen_mm, row);
  return row;
}

std::vector<LinearRow> DepthModel::prior() const {
  std::vector<LinearRow> rows;
  for (int i = 0; i < num_points() * fields(); ++i) rows.push_back({{{i, 1.0}}, 0.0, kAmountSdMm});
  for (int field = 0; field < fields(); ++field) {
    const int first = field * num_points();
    for (int y = 0; y < rows_; ++y) {
      for (int x = 0; x < columns_; ++x) {
        const int i = first + y * columns_ + x;
        if (x > 0 && x + 1 < columns_) rows.push_back(bend(i, 1, kBendSdMm));
        if (y > 0 && y + 1 < rows_) rows.push_back(bend(i, columns_, kBendSdMm));
      }
    }
  }
  const int first_knot = num_points() * fields();
  const int num_knots = static_cast<int>(knots_mm_.size());
  for (int i = 0; i < num_knots; ++i) {
    rows.push_back({{{first_knot + i, 1.0}}, 0.0, kAmountSdMm});
    if (i > 0 && i + 1 < num_knots) rows.push_back(bend(first_knot + i, 1, kCurveBendSdMm));
  }
  return rows;
}

DepthCorrection DepthModel::correction(const Eigen::VectorXd& unknowns) const {
  DepthCorrection correction{
      .columns = columns_, .rows = rows_, .near_mm = near_mm_, .far_mm = far_mm_};
  correction.control.clear();
  for (int i = 0; i < num_points(); ++i) {
    DepthCorrection::Coefficients c;
    if (form_ == DepthForm::kDisparity) {
      c.c1 = unknowns[i] / kReferenceMm;
      c.c2_per_mm = unknowns[num_points() + i] / (kReferenceMm * kReferenceMm);
    } else {
      c.c0_mm = unknowns[i];
    }
    correction.control.push_back(c);
  }
  for (std::size_t i = 0; i < knots_mm_.size(); ++i) {
    correction.curve.push_back(
        {knots_mm_[i], unknowns[num_points() * fields() + static_cast<int>(i)]});
  }
  return correction;
}

Eigen::VectorXd DepthModel::unknowns(const DepthCorrection& correction) const {
  Eigen::VectorXd unknowns(num_unknowns());
  for (int i = 0; i < num_points(); ++i) {
    const auto& c = correction.control[static_cast<std::size_t>(i)];
    if (form_ == DepthForm::kDisparity) {
      unknowns[i] = c.c1 * kReferenceMm;
      unknowns[num_points() + i] = c.c2_per_mm * kReferenceMm * kReferenceMm;
    } else {
      unknowns[i] = c.c0_mm;
    }
  }
  for (std::size_t i = 0; i < knots_mm_.size(); ++i) {
    unknowns[num_points() * fields() + static_cast<int>(i)] = correction.curve[i].add_mm;
  }
  return unknowns;
}

void DepthModel::add_knots(double z_mm, LinearRow& row) const {
  if (knots_mm_.empty()) return;
  const double step_mm = knots_mm_[1] - knots_mm_[0];
  const double at =
      std::clamp((z_mm - near_mm_) / step_mm, 0.0, static_cast<double>(knots_mm_.size()) - 1.0);
  const int i = std::min(static_cast<int>(at), static_cast<int>(knots_mm_.size()) - 2);
  const int first = num_points() * fields();
  row.entries.emplace_back(first + i, i + 1 - at);
  row.entries.emplace_back(first + i + 1, at - i);
}

}  // namespace mor::internal
