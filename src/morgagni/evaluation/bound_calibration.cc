// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/bound_calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/simulated_camera.h"
#include "morgagni/core/statistics.h"
#include "morgagni/evaluation/recording_evaluation.h"
#include "morgagni/geometry/rigid.h"

namespace mor {
namespace {

constexpr double kStartErrorMm = 5.0;
constexpr double kStartErrorRad = 2.0 * std::numbers::pi / 180.0;
constexpr int kPointsAnywhere = 3;
constexpr double kShare = 0.95;

/// A point of the box, drawn evenly.
Eigen::Vector3d point_in(const Eigen::AlignedBox3f& box, std::mt19937_64& random) {
  Eigen::Vector3d share;
  for (auto& value : share) value = static_cast<double>(random() >> 11U) * 0x1.0p-53;
  return box.min().cast<double>() + share.cwiseProduct(box.sizes().cast<double>());
}

/// Runs the frames of one group and one seed.
class SeedRun {
 public:
  SeedRun(const BoundGroup& group, std::size_t index, std::uint64_t seed, BoundRuns& runs)
      : group_(group), index_(index), seed_(seed), random_(seed), runs_(runs) {}

  [[nodiscard]] Result<void> run(int num_frames, const BodySurfaceOptions& depth) {
    MOR_TRY(auto options, SimulatedCameraOptions::parse(group_.camera));
    options.seed = seed_;
    options.is_real_time = false;
    const auto skin = std::shared_ptr<const TriangleMesh>(group_.body, &group_.body->mesh);
    MOR_TRY(const auto camera, SimulatedCamera::create(skin, options));
    for (int i = 0; i < num_frames; ++i) {
      MOR_CHECK(add_frame(*camera, static_cast<std::uint64_t>(i), depth));
    }
    return {};
  }

 private:
  Result<void> add_frame(const SimulatedCamera& camera,
                         std::uint64_t frame_id,
                         const BodySurfaceOptions& depth) {
    const auto frame = camera.frame_at(frame_id);
    const Eigen::Isometry3d truth = camera.ct_from_camera(frame_id);
    const Eigen::Vector3d center = group_.body->mesh.bounds().center().cast<double>();
    const auto start = perturbed_start(truth, center, kStartErrorMm, kStartErrorRad, random_);
    MOR_TRY(auto extractor, BodySurfaceExtractor::create(camera.calibration().depth, depth));
    MOR_TRY(auto registration, make_fine_registration(group_.body, {}));
    MOR_TRY(auto tracker,
            Tracker::create({}, group_.body, std::move(extractor), std::move(registration)));
    ++runs_.num_frames[index_];
    if (!tracker.start_at(frame, start)) {
      ++runs_.num_not_found[index_];
      return {};
    }
    MOR_TRY(const auto tracked, tracker.process(frame));
    if (!tracked.ct_from_depth || tracked.is_held || !tracked.registration->information) {
      ++runs_.num_not_found[index_];
      return {};
    }
    add_sample(tracked, truth, frame_id);
    return {};
  }

  void add_sample(const TrackedFrame& tracked,
                  const Eigen::Isometry3d& truth,
                  std::uint64_t frame_id) {
    const Eigen::AlignedBox3f box = group_.body->mesh.bounds();
    const Eigen::Isometry3d depth_from_ct_truth = truth.inverse();
    BoundSample sample{.group = index_,
                       .seed = seed_,
                       .frame_id = frame_id,
                       .distance_mm = (depth_from_ct_truth * tracked.skin->seen_center_mm).norm(),
                       .state = tracked.state,
                       .information = *tracked.registration->information,
                       .targets = {}};
    const auto add = [&](BoundTarget::Kind kind, const Eigen::Vector3d& ct_mm) {
      const double error_mm =
          (*tracked.ct_from_depth * (depth_from_ct_truth * ct_mm) - ct_mm).norm();
      sample.targets.push_back({kind, ct_mm, error_mm});
    };
    add(BoundTarget::Kind::kSeenSkin, tracked.skin->seen_center_mm);
    add(BoundTarget::Kind::kCenter, box.center().cast<double>());
    for (int i = 0; i < kPointsAnywhere; ++i) {
      add(BoundTarget::Kind::kAnywhere, point_in(box, random_));
    }
    runs_.samples.push_back(std::move(sample));
  }

  const BoundGroup& group_;
  std::size_t index_;
  std::uint64_t seed_;
  std::mt19937_64 random_;
  BoundRuns& runs_;
};

/// Error over bound at every target of the samples that `keeps` takes. A sample without a bound has
/// none.
template <class Keeps>
std::vector<double> ratios(const BoundRuns& runs,
                           const BoundCalibration& calibration,
                           const Keeps& keeps) {
  std::vector<double> result;
  for (const auto& sample : runs.samples) {
    if (!keeps(sample)) continue;
    const auto pose = pose_covariance(sample.information, calibration);
    if (!pose) continue;
    for (const auto& target : sample.targets) {
      result.push_back(target.error_mm / error_bound_mm(*pose, target.ct_mm));
    }
  }
  return result;
}

bool is_good(const BoundSample& sample) {
  return sample.state == TrackingState::kTracking;
}

/// Squared logarithms of the 95 % quantiles of error / bound over the groups, about their mean: how
/// unevenly the bound holds, whatever its scale.
struct Unevenness {
  double spread = 0.0;
  double mean_log = 0.0;
};

Unevenness unevenness(const BoundRuns& runs, const BoundCalibration& calibration) {
  std::vector<double> logs;
  for (std::size_t group = 0; group < runs.groups.size(); ++group) {
    if (runs.groups[group].bias_mm > 0.0) continue;
    const auto in_group = ratios(runs, calibration, [&](const BoundSample& sample) {
      return sample.group == group && is_good(sample);
    });
    if (!in_group.empty()) logs.push_back(std::log(quantile(in_group, kShare)));
  }
  Unevenness result;
  for (const double value : logs) result.mean_log += value / static_cast<double>(logs.size());
  for (const double value : logs) {
    result.spread += (value - result.mean_log) * (value - result.mean_log);
  }
  return result;
}

/// All its standard deviations times `factor`.
BoundCalibration scaled(const BoundCalibration& calibration, double factor) {
  return {.correlated_readings = calibration.correlated_readings * factor * factor,
          .least_residual_scale = calibration.least_residual_scale,
          .clutter_growth = calibration.clutter_growth,
          .systematic_mm = calibration.systematic_mm * factor,
          .floor_mm = calibration.floor_mm * factor};
}

}  // namespace

Result<void> BoundStudyOptions::check() const {
  if (num_seeds < 1 || num_frames < 1) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("seeds and frames must be at least 1, got {} and {}", num_seeds, num_frames));
  }
  return depth.check();
}

Result<BoundRuns> run_bound_study(const std::vector<BoundGroup>& groups,
                                  const BoundStudyOptions& options,
                                  const Progress& progress) {
  MOR_CHECK(options.check());
  BoundRuns runs;
  runs.groups = groups;
  runs.num_frames.assign(groups.size(), 0);
  runs.num_not_found.assign(groups.size(), 0);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    for (int k = 0; k < options.num_seeds; ++k) {
      const auto seed = options.first_seed + static_cast<std::uint64_t>(k);
      MOR_CHECK(SeedRun(groups[i], i, seed, runs).run(options.num_frames, options.depth));
      progress(groups[i].name, static_cast<double>(k + 1) / options.num_seeds);
    }
  }
  return runs;
}

BoundCalibration fit_bound_calibration(const BoundRuns& runs) {
  // The readings' share is the unit; how much clutter adds, and how much systematic error and floor
  // there is beside it, decides how evenly the bound holds, and the scale follows. Steps of a
  // quarter are finer than the data.
  BoundCalibration best{.correlated_readings = 1.0,
                        .least_residual_scale = default_bound_calibration().least_residual_scale};
  double best_spread = unevenness(runs, best).spread;
  const auto try_out = [&](const BoundCalibration& tried) {
    const double spread = unevenness(runs, tried).spread;
    if (spread >= best_spread) return;
    best_spread = spread;
    best = tried;
  };
  for (double growth = 0.25; growth <= 2.0; growth += 0.25) {
    auto tried = best;
    tried.clutter_growth = growth;
    try_out(tried);
  }
  const BoundCalibration without_systematic = best;
  for (double systematic_mm = 0.005; systematic_mm < 1.0; systematic_mm *= 1.25) {
    for (const double floor_share : {0.0, 0.25, 0.5, 1.0, 2.0}) {
      auto tried = without_systematic;
      tried.systematic_mm = systematic_mm;
      tried.floor_mm = floor_share * systematic_mm;
      try_out(tried);
    }
  }
  const auto all = ratios(runs, best, [&](const BoundSample& sample) {
    return is_good(sample) && runs.groups[sample.group].bias_mm == 0.0;
  });
  return scaled(best, quantile(all, kShare));
}

}  // namespace mor
