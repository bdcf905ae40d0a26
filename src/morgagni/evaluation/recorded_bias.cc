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
#include "morgagni/geometry/depth_levels.h"

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

/// The body's change: its standard deviation, how smooth it is, and how far its control points lie
/// apart.
constexpr double kChangeMm = 1.5;
constexpr double kChangeReachMm = 40.0;
constexpr double kNodesApartMm = 28.0;
/// Scatter of a reading: those of neighbours err together, so they count less than one each.
constexpr double kReadingMm = 2.2;
/// Steeper skin is read less well.
constexpr double kLeastCosine = 0.35;

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
  Eigen::Vector3d place_mm;
  double per_change = 0.0;  ///< Of the skin outward: what it adds to the distance read.
  double true_mm = 0.0;
  double off_mm = 0.0;
};

std::vector<Reading> readings_of(const TriangleMesh& skin, const RecordedFrames& recorded) {
  std::vector<Reading> readings;
  const auto& camera = recorded.depth;
  DepthLevels levels;
  for (const auto& frame : recorded.frames) {
    levels.learn(frame.depth_mm.view());
    const auto drawn = expected_depth(skin, camera, frame.ct_from_depth);
    const auto view = read_skin(skin, camera, frame.depth_mm.view(), levels, frame.ct_from_depth);
    for (const auto& read : view.readings) {
      const auto expected = expected_reading(read, drawn, camera);
      if (!(expected.z_mm > 0.0F)) continue;
      const auto true_mm = static_cast<double>(expected.z_mm);
      const Eigen::Vector2d ray = camera.ray(read.pixel.cast<double>());
      const Eigen::Vector3d direction(ray.x(), ray.y(), 1.0);
      const double along_ray = expected.normal.cast<double>().dot(direction);
      if (-along_ray < kLeastCosine * direction.norm()) continue;
      const double u = 2.0 * static_cast<double>(read.pixel.x()) / (camera.width_px - 1) - 1.0;
      const double v = 2.0 * static_cast<double>(read.pixel.y()) / (camera.height_px - 1) - 1.0;
      readings.push_back({terms_at(u, v),
                          frame.ct_from_depth * (true_mm * direction),
                          1.0 / along_ray,
                          true_mm,
                          static_cast<double>(read.z_mm) - true_mm});
    }
  }
  return readings;
}

/// Control points of the body's change, spread over what was read.
std::vector<Eigen::Vector3d> nodes_among(const std::vector<Reading>& readings) {
  std::vector<Eigen::Vector3d> nodes;
  for (const auto& reading : readings) {
    const bool is_apart = std::ranges::none_of(nodes, [&](const Eigen::Vector3d& node) {
      return (node - reading.place_mm).norm() < kNodesApartMm;
    });
    if (is_apart) nodes.push_back(reading.place_mm);
  }
  return nodes;
}

/// The sensor's terms, then the weights of the bumps around the nodes.
struct Fit {
  Eigen::VectorXd values;
  double left_mm = 0.0;
};

class JointFit {
 public:
  explicit JointFit(const std::vector<Reading>& readings)
      : readings_(readings), nodes_(nodes_among(readings)) {
    const auto size = static_cast<Eigen::Index>(nodes_.size());
    prior_ = Eigen::MatrixXd::Zero(kTermsIndex + size, kTermsIndex + size);
    prior_.diagonal().head(kTermsIndex).setConstant(1.0 / (kPriorMm * kPriorMm));
    // Weights w of bumps K make a Gaussian process of covariance sd^2 K where w ~ sd^2 K^-1.
    for (Eigen::Index i = 0; i < size; ++i) {
      prior_.block(kTermsIndex + i, kTermsIndex, 1, size) =
          bumps_at(nodes_[static_cast<std::size_t>(i)]).transpose() / (kChangeMm * kChangeMm);
    }
    prior_.diagonal().tail(size).array() += 1e-3;
    for (const auto& reading : readings) bumps_.push_back(bumps_at(reading.place_mm));
  }

  [[nodiscard]] Fit fit(bool grows) const {
    Fit result;
    result.values = Eigen::VectorXd::Zero(prior_.rows());
    for (int round = 0; round < kRounds; ++round) {
      Eigen::MatrixXd matrix = prior_;
      Eigen::VectorXd right = Eigen::VectorXd::Zero(prior_.rows());
      for (std::size_t i = 0; i < readings_.size(); ++i) {
        const Eigen::VectorXd row = row_of(i, grows);
        const double off = (readings_[i].off_mm - result.values.dot(row)) / kScaleMm;
        const double rest = std::max(0.0, 1.0 - off * off);
        const double weight = (round == 0 ? 1.0 : rest * rest) / (kReadingMm * kReadingMm);
        matrix.selfadjointView<Eigen::Lower>().rankUpdate(row, weight);
        right += weight * readings_[i].off_mm * row;
      }
      result.values = matrix.selfadjointView<Eigen::Lower>().ldlt().solve(right);
    }
    result.left_mm = left_mm(result.values, grows);
    return result;
  }

  /// Of the readings less what the values explain, robust root mean square.
  [[nodiscard]] double left_mm(const Eigen::VectorXd& values, bool grows) const {
    std::vector<double> sizes;
    for (std::size_t i = 0; i < readings_.size(); ++i) {
      sizes.push_back(std::abs(readings_[i].off_mm - values.dot(row_of(i, grows))));
    }
    constexpr double kSdPerMedian = 1.4826;
    return kSdPerMedian * quantile(std::move(sizes), 0.5);
  }

  [[nodiscard]] SkinChange body_of(const Fit& fit) const {
    const Eigen::VectorXd weights = fit.values.tail(static_cast<Eigen::Index>(nodes_.size()));
    return {nodes_, {weights.begin(), weights.end()}, kChangeReachMm};
  }

 private:
  static constexpr auto kTermsIndex = static_cast<Eigen::Index>(kTerms);

  [[nodiscard]] Eigen::VectorXd bumps_at(const Eigen::Vector3d& place_mm) const {
    Eigen::VectorXd bumps(static_cast<Eigen::Index>(nodes_.size()));
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const double apart_sq = (nodes_[i] - place_mm).squaredNorm();
      bumps[static_cast<Eigen::Index>(i)] =
          std::exp(-0.5 * apart_sq / (kChangeReachMm * kChangeReachMm));
    }
    return bumps;
  }

  [[nodiscard]] Eigen::VectorXd row_of(std::size_t i, bool grows) const {
    const auto& reading = readings_[i];
    Eigen::VectorXd row(prior_.rows());
    row << (grows ? reading.true_mm / kReferenceMm : 1.0) * reading.terms,
        reading.per_change * bumps_[i];
    return row;
  }

  const std::vector<Reading>& readings_;
  std::vector<Eigen::Vector3d> nodes_;
  std::vector<Eigen::VectorXd> bumps_;  ///< At each reading.
  Eigen::MatrixXd prior_;               ///< Precision.
};

DepthCorrection as_correction(const Eigen::VectorXd& values, bool grows) {
  constexpr int kColumns = 25;
  constexpr int kRows = 19;
  DepthCorrection adds{.columns = kColumns, .rows = kRows, .control = {}, .curve = {}};
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const double amount_mm = values.head<kTerms>().dot(
          terms_at(2.0 * column / (kColumns - 1) - 1.0, 2.0 * row / (kRows - 1) - 1.0));
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
  const JointFit joint(readings);
  const Fit growing = joint.fit(true);
  const Fit fixed = joint.fit(false);
  RecordedBias bias;
  bias.is_growing = growing.left_mm <= fixed.left_mm;
  const Fit& better = bias.is_growing ? growing : fixed;
  bias.adds = as_correction(better.values, bias.is_growing);
  bias.removes = bias.adds;
  for (auto& point : bias.removes.control) {
    point = {-point.c0_mm / (1.0 + point.c1), -point.c1 / (1.0 + point.c1), 0.0};
  }
  bias.body = joint.body_of(better);
  std::vector<double> changes_mm;
  for (const auto& reading : readings) changes_mm.push_back(bias.body.at_mm(reading.place_mm));
  bias.body_mm = root_mean_square(changes_mm);
  bias.num_readings = static_cast<int>(readings.size());
  Eigen::VectorXd sensor_alone = better.values;
  sensor_alone.tail(sensor_alone.size() - static_cast<Eigen::Index>(kTerms)).setZero();
  bias.before_mm = joint.left_mm(Eigen::VectorXd::Zero(better.values.size()), false);
  bias.without_adds_mm = joint.left_mm(sensor_alone, bias.is_growing);
  bias.after_mm = better.left_mm;
  return bias;
}

}  // namespace mor
