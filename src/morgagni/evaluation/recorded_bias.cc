// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/recorded_bias.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>
#include <spdlog/fmt/fmt.h>

#include "morgagni/calibration/skin_readings.h"
#include "morgagni/camera/tum_recording.h"
#include "morgagni/core/statistics.h"

namespace mor {
namespace {

constexpr int kDegree = 3;
constexpr std::size_t kTerms = (kDegree + 1) * (kDegree + 2) / 2;
constexpr double kReferenceMm = 800.0;
constexpr std::size_t kLeastReadings = 2000;
/// Readings farther off than this are another thing's: of Tukey's weights.
constexpr double kScaleMm = 5.0;
constexpr int kRounds = 10;
/// Where there are no readings, terms stay small: a prior of so much each, mm.
constexpr double kPriorMm = 5.0;
constexpr double kReadingMm = 1.0;  ///< Scatter of a reading, for that prior.

using Terms = Eigen::Matrix<double, kTerms, 1>;

/// Legendre polynomials over the picture, of total degree up to the third.
Terms terms_at(double u, double v) {
  const auto legendre = [](double x) {
    return std::array{1.0, x, 0.5 * (3.0 * x * x - 1.0), 0.5 * x * (5.0 * x * x - 3.0)};
  };
  const auto along_u = legendre(u);
  const auto along_v = legendre(v);
  Terms terms;
  Eigen::Index at = 0;
  for (std::size_t i = 0; i <= kDegree; ++i) {
    for (std::size_t k = 0; i + k <= kDegree; ++k) terms[at++] = along_u[i] * along_v[k];
  }
  return terms;
}

struct Reading {
  Terms terms;
  double true_mm = 0.0;
  double off_mm = 0.0;
};

std::vector<Reading> readings_of(const TriangleMesh& skin, const RecordedFrames& recorded) {
  std::vector<Reading> readings;
  const auto& camera = recorded.depth;
  for (const auto& frame : recorded.frames) {
    const auto drawn = expected_depth(skin, camera, frame.ct_from_depth);
    const auto view = read_skin(skin, camera, frame.depth_mm.view(), frame.ct_from_depth);
    for (const auto& read : view.readings) {
      const auto expected = expected_reading(read, drawn, camera);
      if (!(expected.z_mm > 0.0F)) continue;
      const double u = 2.0 * static_cast<double>(read.pixel.x()) / (camera.width_px - 1) - 1.0;
      const double v = 2.0 * static_cast<double>(read.pixel.y()) / (camera.height_px - 1) - 1.0;
      readings.push_back({terms_at(u, v),
                          static_cast<double>(expected.z_mm),
                          static_cast<double>(read.z_mm) - static_cast<double>(expected.z_mm)});
    }
  }
  return readings;
}

struct Fit {
  Terms values = Terms::Zero();
  double left_mm = 0.0;
};

double robust_rms(const std::vector<Reading>& readings, const Terms& values, bool grows) {
  std::vector<double> sizes;
  for (const auto& reading : readings) {
    const double growth = grows ? reading.true_mm / kReferenceMm : 1.0;
    sizes.push_back(std::abs(reading.off_mm - growth * values.dot(reading.terms)));
  }
  constexpr double kSdPerMedian = 1.4826;
  return kSdPerMedian * quantile(std::move(sizes), 0.5);
}

Fit fit(const std::vector<Reading>& readings, bool grows) {
  Fit result;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix<double, kTerms, kTerms> matrix =
        Eigen::Matrix<double, kTerms, kTerms>::Identity() *
        (kReadingMm * kReadingMm / (kPriorMm * kPriorMm));
    Terms right = Terms::Zero();
    for (const auto& reading : readings) {
      const double growth = grows ? reading.true_mm / kReferenceMm : 1.0;
      const Terms terms = growth * reading.terms;
      const double off = (reading.off_mm - result.values.dot(terms)) / kScaleMm;
      const double rest = std::max(0.0, 1.0 - off * off);
      const double weight = round == 0 ? 1.0 : rest * rest;
      matrix += weight * terms * terms.transpose();
      right += weight * reading.off_mm * terms;
    }
    result.values = matrix.ldlt().solve(right);
  }
  result.left_mm = robust_rms(readings, result.values, grows);
  return result;
}

DepthCorrection as_correction(const Terms& values, bool grows) {
  constexpr int kColumns = 25;
  constexpr int kRows = 19;
  DepthCorrection adds{.columns = kColumns, .rows = kRows, .control = {}, .curve = {}};
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const double amount_mm =
          values.dot(terms_at(2.0 * column / (kColumns - 1) - 1.0, 2.0 * row / (kRows - 1) - 1.0));
      adds.control.push_back(grows
                                 ? DepthCorrection::Coefficients{0.0, amount_mm / kReferenceMm, 0.0}
                                 : DepthCorrection::Coefficients{amount_mm, 0.0, 0.0});
    }
  }
  return adds;
}

}  // namespace

Result<RecordedFrames> load_recorded_frames(const std::filesystem::path& folder, const Case& body) {
  MOR_TRY(const auto recording, TumRecording::open(folder));
  MOR_TRY(auto poses, read_ground_truth(folder / "groundtruth.txt"));
  MOR_TRY(auto targets, read_targets(folder / "targets.csv"));
  MOR_TRY(auto truth,
          align_truth_to_case(std::move(poses),
                              std::move(targets),
                              TruthFrame::kAuto,
                              body.skin->field,
                              body.ct_center_mm,
                              body.ct_half_voxel_mm));
  RecordedFrames recorded;
  recorded.depth = recording.calibration()->depth;
  recorded.targets = std::move(truth.targets);
  for (std::size_t i = 0; i < recording.size(); ++i) {
    const auto pose = truth_at(truth.poses, recording.timestamp_s(i));
    if (!pose) continue;
    MOR_TRY(const auto frame, recording.read(i));
    recorded.frames.push_back({frame->depth_mm, *pose});
  }
  return recorded;
}

Result<RecordedBias> measure_bias(const TriangleMesh& skin, const RecordedFrames& recorded) {
  const auto readings = readings_of(skin, recorded);
  if (readings.size() < kLeastReadings) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{} blocks of readings lie on the skin at the true poses, at "
                                  "least {} are needed",
                                  readings.size(),
                                  kLeastReadings));
  }
  const Fit growing = fit(readings, true);
  const Fit fixed = fit(readings, false);
  RecordedBias bias;
  bias.is_growing = growing.left_mm <= fixed.left_mm;
  const Fit& better = bias.is_growing ? growing : fixed;
  bias.adds = as_correction(better.values, bias.is_growing);
  bias.num_readings = static_cast<int>(readings.size());
  bias.before_mm = robust_rms(readings, Terms::Zero(), false);
  bias.after_mm = better.left_mm;
  return bias;
}

}  // namespace mor
