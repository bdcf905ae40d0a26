// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/depth_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/statistics.h"

namespace mor {
namespace {

constexpr double kReferenceMm = 800.0;
constexpr int kRounds = 5;          ///< Of weights.
constexpr double kTukeyMads = 5.0;  ///< Beyond so many a reading has no weight.
constexpr double kKnotStepMm = 120.0;
/// What is believed before anything is read, standard deviations in mm at the reference distance:
/// the amount itself, and how far it bends from control point to control point.
constexpr double kAmountSdMm = 25.0;
constexpr double kBendSdMm = 1.5;
constexpr double kCurveBendSdMm = 4.0;
/// Readings of one view share its pose's error: together they weigh as so many.
constexpr double kEffectiveReadings = 60.0;
constexpr double kSameDistance = 0.06;
constexpr int kTilesX = 8;
constexpr int kTilesY = 6;

tl::unexpected<Error> refuse(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, std::move(message));
}

/// One reading's share in the unknowns.
struct Row {
  std::vector<std::pair<int, double>> entries;
  double amount_mm = 0.0;
  double sd_mm = 1.0;
};

/// Where the unknowns of a form stand, and what they mean.
class Model {
 public:
  Model(const DepthFitOptions& options,
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

  [[nodiscard]] int num_unknowns() const {
    return num_points() * fields() + static_cast<int>(knots_mm_.size());
  }

  [[nodiscard]] Row row(const DepthReading& reading) const {
    Row row;
    row.amount_mm = reading.true_mm - reading.seen_mm;
    const double along = reading.seen_mm / kReferenceMm;
    row.sd_mm = form_ == DepthForm::kDisparity ? 0.5 + along * along : 0.5 + along;
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

  /// What is believed beforehand, as further rows.
  [[nodiscard]] std::vector<Row> prior() const {
    std::vector<Row> rows;
    for (int i = 0; i < num_points() * fields(); ++i) {
      rows.push_back({{{i, 1.0}}, 0.0, kAmountSdMm});
    }
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

  [[nodiscard]] DepthCorrection correction(const Eigen::VectorXd& unknowns) const {
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

 private:
  [[nodiscard]] int num_points() const { return columns_ * rows_; }
  [[nodiscard]] int fields() const { return form_ == DepthForm::kDisparity ? 2 : 1; }

  static Row bend(int i, int step, double sd_mm) {
    return {{{i - step, 1.0}, {i, -2.0}, {i + step, 1.0}}, 0.0, sd_mm};
  }

  void add_knots(double z_mm, Row& row) const {
    if (knots_mm_.empty()) return;
    const double step_mm = knots_mm_[1] - knots_mm_[0];
    const double at =
        std::clamp((z_mm - near_mm_) / step_mm, 0.0, static_cast<double>(knots_mm_.size()) - 1.0);
    const int i = std::min(static_cast<int>(at), static_cast<int>(knots_mm_.size()) - 2);
    const int first = num_points() * fields();
    row.entries.emplace_back(first + i, i + 1 - at);
    row.entries.emplace_back(first + i + 1, at - i);
  }

  int columns_;
  int rows_;
  DepthForm form_;
  int width_px_;
  int height_px_;
  double near_mm_;
  double far_mm_;
  std::vector<double> knots_mm_;
};

void add(const Row& row, double weight, Eigen::MatrixXd& normal, Eigen::VectorXd& right) {
  const double scale = weight / (row.sd_mm * row.sd_mm);
  for (const auto& [i, a] : row.entries) {
    right[i] += scale * a * row.amount_mm;
    for (const auto& [k, b] : row.entries) normal(i, k) += scale * a * b;
  }
}

double residual_sd(const Row& row, const Eigen::VectorXd& unknowns) {
  double value = -row.amount_mm;
  for (const auto& [i, a] : row.entries) value += a * unknowns[i];
  return value / row.sd_mm;
}

DepthCorrection solve(const Model& model, const std::vector<DepthReading>& readings) {
  std::map<int, double> readings_of_view;
  std::vector<Row> rows;
  for (const auto& reading : readings) {
    rows.push_back(model.row(reading));
    readings_of_view[reading.view] += 1.0;
  }
  const auto prior = model.prior();
  Eigen::VectorXd unknowns = Eigen::VectorXd::Zero(model.num_unknowns());
  std::vector<double> weights(rows.size(), 1.0);
  for (int round = 0; round < kRounds; ++round) {
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(model.num_unknowns(), model.num_unknowns());
    Eigen::VectorXd right = Eigen::VectorXd::Zero(model.num_unknowns());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double of_view = readings_of_view[readings[i].view];
      add(rows[i], weights[i] * std::min(1.0, kEffectiveReadings / of_view), normal, right);
    }
    for (const auto& row : prior) add(row, 1.0, normal, right);
    unknowns = normal.ldlt().solve(right);
    std::vector<double> sizes;
    for (const auto& row : rows) sizes.push_back(std::abs(residual_sd(row, unknowns)));
    const double limit = kTukeyMads * 1.4826 * std::max(0.2, quantile(sizes, 0.5));
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double share = std::min(1.0, sizes[i] / limit);
      weights[i] = (1.0 - share * share) * (1.0 - share * share);
    }
  }
  return model.correction(unknowns);
}

/// Of readings, at the reference distance: far ones count less, as they are worse.
struct HeldOut {
  double before_mm = 0.0;
  double after_mm = 0.0;
};

HeldOut measure(const DepthCorrection& correction,
                const std::vector<DepthReading>& readings,
                int width_px,
                int height_px) {
  double before = 0.0;
  double after = 0.0;
  for (const auto& reading : readings) {
    const double wrong_mm = reading.seen_mm - reading.true_mm;
    const double left_mm =
        wrong_mm + correction.add_mm(reading.px, width_px, height_px, reading.seen_mm);
    before += wrong_mm * wrong_mm;
    after += left_mm * left_mm;
  }
  const auto count = static_cast<double>(std::max<std::size_t>(1, readings.size()));
  return {std::sqrt(before / count), std::sqrt(after / count)};
}

double median_distance(const std::vector<DepthReading>& readings, int view) {
  std::vector<double> distances;
  for (const auto& reading : readings) {
    if (reading.view == view) distances.push_back(reading.true_mm);
  }
  return quantile(std::move(distances), 0.5);
}

int count_distances(const std::vector<DepthReading>& readings, const std::set<int>& views) {
  std::vector<double> distances;
  for (const int view : views) distances.push_back(median_distance(readings, view));
  std::ranges::sort(distances);
  int count = 0;
  double last_mm = 0.0;
  for (const double distance_mm : distances) {
    if (distance_mm < last_mm * (1.0 + kSameDistance)) continue;
    last_mm = distance_mm;
    ++count;
  }
  return count;
}

/// Share of the picture's tiles that were read at two distances or more.
double covered_share(const std::vector<DepthReading>& readings, int width_px, int height_px) {
  struct Range {
    double least = 1e9;
    double most = 0.0;
  };
  std::map<int, Range> tiles;
  for (const auto& reading : readings) {
    const int x = std::min(kTilesX - 1, static_cast<int>(reading.px.x() * kTilesX / width_px));
    const int y = std::min(kTilesY - 1, static_cast<int>(reading.px.y() * kTilesY / height_px));
    auto& range = tiles[y * kTilesX + x];
    range.least = std::min(range.least, reading.true_mm);
    range.most = std::max(range.most, reading.true_mm);
  }
  const auto good = std::ranges::count_if(tiles, [](const auto& tile) {
    return tile.second.most > tile.second.least * (1.0 + kSameDistance);
  });
  return static_cast<double>(good) / (kTilesX * kTilesY);
}

}  // namespace

std::string_view to_string(DepthForm form) {
  switch (form) {
    case DepthForm::kAuto:
      return "auto";
    case DepthForm::kDisparity:
      return "disparity";
    case DepthForm::kTimeOfFlight:
      return "time-of-flight";
  }
  return "";
}

Result<DepthFit> fit_depth(const std::vector<DepthReading>& readings,
                           int width_px,
                           int height_px,
                           const DepthFitOptions& options) {
  DepthFit fit;
  fit.num_readings = static_cast<int>(readings.size());
  std::set<int> views;
  std::vector<double> distances;
  for (const auto& reading : readings) {
    views.insert(reading.view);
    distances.push_back(reading.seen_mm);
  }
  fit.num_distances = count_distances(readings, views);
  const double near_mm = quantile(distances, 0.01);
  const double far_mm = quantile(distances, 0.99);
  if (fit.num_distances < options.min_distances || far_mm < options.min_far_to_near * near_mm) {
    return refuse(fmt::format(
        "the depth was seen at {} distances from {:.0f} to {:.0f} mm: at least {} are needed, the "
        "farthest {:.2f} times the nearest",
        fit.num_distances,
        near_mm,
        far_mm,
        options.min_distances,
        options.min_far_to_near));
  }
  fit.coverage = covered_share(readings, width_px, height_px);
  if (fit.coverage < options.min_coverage) {
    return refuse(fmt::format(
        "the board covered {:.0f} % of the depth picture at two distances, at least {:.0f} % are "
        "needed: hang it on a flat wall, or hold it in more places, near and far",
        100.0 * fit.coverage,
        100.0 * options.min_coverage));
  }
  // Every third view is held out for the judgement; the fit itself then takes all.
  std::vector<DepthReading> seen;
  std::vector<DepthReading> held_out;
  std::map<int, int> rank;
  for (const int view : views) rank.emplace(view, static_cast<int>(rank.size()));
  for (const auto& reading : readings) {
    (rank[reading.view] % 3 == 1 ? held_out : seen).push_back(reading);
  }
  bool is_first = true;
  for (const auto form : {DepthForm::kDisparity, DepthForm::kTimeOfFlight}) {
    if (options.form != DepthForm::kAuto && options.form != form) continue;
    const Model model(options, form, width_px, height_px, near_mm, far_mm);
    const auto judged = measure(solve(model, seen), held_out, width_px, height_px);
    if (is_first || judged.after_mm < fit.rms_after_mm) {
      fit.form = form;
      fit.rms_before_mm = judged.before_mm;
      fit.rms_after_mm = judged.after_mm;
    }
    is_first = false;
  }
  fit.correction = solve(Model(options, fit.form, width_px, height_px, near_mm, far_mm), readings);
  MOR_CHECK(fit.correction.check());
  return fit;
}

}  // namespace mor
