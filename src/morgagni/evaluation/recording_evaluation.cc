// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/recording_evaluation.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>
#include <numbers>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/statistics.h"
#include "morgagni/geometry/depth_levels.h"
#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/visible_place.h"

namespace mor {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
/// Shares of bare skin that the table tells apart; a recording's clutter most often leaves more
/// than the last.
constexpr std::array<double, 4> kBareShares = {0.0, 0.4, 0.6, 1.01};

double ms_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

double thread_cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

/// A direction drawn evenly from the sphere (Marsaglia 1972): the standard library's normal
/// distribution may differ between implementations, this does not.
Eigen::Vector3d random_direction(std::mt19937_64& random) {
  const auto uniform = [&random] {
    return static_cast<double>(random() >> 11U) * 0x1.0p-53 * 2.0 - 1.0;
  };
  while (true) {
    const double u = uniform();
    const double v = uniform();
    const double s = u * u + v * v;
    if (s >= 1.0) continue;
    const double factor = 2.0 * std::sqrt(1.0 - s);
    return {u * factor, v * factor, 1.0 - 2.0 * s};
  }
}

double random_up_to(double limit, std::mt19937_64& random) {
  return limit * static_cast<double>(random() >> 11U) * 0x1.0p-53;
}

Eigen::Vector3d centroid(const PointCloud& cloud) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& point : cloud.points) sum += point.cast<double>();
  return sum / static_cast<double>(cloud.size());
}

/// Registers the frames one after the other and keeps the runs.
class Evaluation {
 public:
  Evaluation(const FineRegistration& registration,
             BodySurfaceExtractor& extractor,
             const TriangleMesh& skin,
             const std::vector<Target>& targets,
             const EvaluationOptions& options)
      : registration_(registration),
        extractor_(extractor),
        skin_(skin),
        targets_(targets),
        options_(options),
        random_(options.seed) {}

  [[nodiscard]] Result<void> add_frame(const RgbdFrame& frame, const Eigen::Isometry3d& truth);
  [[nodiscard]] EvaluationReport report() const;

 private:
  /// What the camera sees of the body where `expected` puts it.
  [[nodiscard]] Result<PointCloud> surface_at(const RgbdFrame& frame,
                                              const Eigen::Isometry3d& expected);
  [[nodiscard]] Result<RegistrationResult> run(const RgbdFrame& frame,
                                               const Eigen::Isometry3d& start,
                                               StartQuality quality,
                                               const Eigen::Isometry3d& truth);

  const FineRegistration& registration_;
  BodySurfaceExtractor& extractor_;
  const TriangleMesh& skin_;
  const std::vector<Target>& targets_;
  const EvaluationOptions& options_;
  std::mt19937_64 random_;
  std::optional<Eigen::Isometry3d> last_pose_;
  int num_frames_ = 0;
  std::vector<EvaluationRun> runs_;
  std::vector<double> depth_ms_;
  std::vector<EvaluationFrame> frames_;
};

Result<PointCloud> Evaluation::surface_at(const RgbdFrame& frame,
                                          const Eigen::Isometry3d& expected) {
  MOR_TRY(auto surface,
          extractor_.extract(frame.depth_mm.view(), places_facing_camera(skin_, expected)));
  if (surface.cloud.empty()) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("frame {} shows nothing between {} and {} mm",
                                  frame.frame_id,
                                  options_.depth.near_mm,
                                  options_.depth.far_mm));
  }
  return std::move(surface.cloud);
}

Result<RegistrationResult> Evaluation::run(const RgbdFrame& frame,
                                           const Eigen::Isometry3d& start,
                                           StartQuality quality,
                                           const Eigen::Isometry3d& truth) {
  const auto depth_started = std::chrono::steady_clock::now();
  MOR_TRY(const PointCloud cloud, surface_at(frame, start));
  depth_ms_.push_back(ms_since(depth_started));
  const auto started = std::chrono::steady_clock::now();
  const double cpu_started_ms = thread_cpu_ms();
  MOR_TRY(auto result, registration_.align(cloud, start, quality));
  EvaluationRun run;
  run.registration_cpu_ms = thread_cpu_ms() - cpu_started_ms;
  run.registration_ms = ms_since(started);
  run.frame = frame.frame_id;
  run.num_points = cloud.size();
  run.tre_mm = target_registration_error_mm(result.fixed_from_moving, truth, targets_);
  run.start_tre_mm = target_registration_error_mm(start, truth, targets_);
  run.rms_distance_mm = result.rms_distance_mm;
  run.status = result.status;
  runs_.push_back(run);
  return result;
}

Result<void> Evaluation::add_frame(const RgbdFrame& frame, const Eigen::Isometry3d& truth) {
  ++num_frames_;
  frames_.push_back(
      {frame.frame_id,
       frame_difficulty(skin_, frame.depth_mm.view(), frame.calibration->depth, truth, targets_)});
  if (options_.num_starts == 0) {
    MOR_TRY(const auto result,
            run(frame, last_pose_.value_or(truth), StartQuality::kTracked, truth));
    last_pose_ = result.fixed_from_moving;
    return {};
  }
  MOR_TRY(const PointCloud seen, surface_at(frame, truth));
  const Eigen::Vector3d center = truth * centroid(seen);
  for (int i = 0; i < options_.num_starts; ++i) {
    const Eigen::Isometry3d start = perturbed_start(
        truth, center, options_.start_error_mm, options_.start_error_deg * kRadPerDeg, random_);
    MOR_CHECK(run(frame, start, options_.start_quality, truth));
  }
  return {};
}

EvaluationReport Evaluation::report() const {
  EvaluationReport report;
  report.method = options_.registration.method;
  report.device = registration_.device_name();
  report.num_frames = num_frames_;
  report.num_starts = options_.num_starts;
  report.success_mm = options_.success_mm;
  std::vector<double> tre_mm;
  std::vector<double> tre_success_mm;
  std::vector<double> registration_ms;
  std::vector<double> registration_cpu_ms;
  std::vector<double> points;
  for (const auto& run : runs_) {
    tre_mm.push_back(run.tre_mm);
    if (run.tre_mm < options_.success_mm) tre_success_mm.push_back(run.tre_mm);
    registration_ms.push_back(run.registration_ms);
    registration_cpu_ms.push_back(run.registration_cpu_ms);
    points.push_back(static_cast<double>(run.num_points));
  }
  report.success_rate =
      static_cast<double>(tre_success_mm.size()) / static_cast<double>(tre_mm.size());
  report.tre_mm = summarize(tre_mm);
  report.tre_success_mm = summarize(tre_success_mm);
  report.registration_ms = summarize(registration_ms);
  report.registration_cpu_ms = summarize(registration_cpu_ms);
  report.depth_ms = summarize(depth_ms_);
  report.median_points = quantile(std::move(points), 0.5);
  report.frames = frames_;
  report.runs = runs_;
  return report;
}

}  // namespace

Result<void> EvaluationOptions::check() const {
  MOR_CHECK(registration.check());
  MOR_CHECK(depth.check());
  const auto bad = [](const char* what, double value) {
    return make_error(ErrorCode::kInvalidArgument, fmt::format("{}, got {}", what, value));
  };
  if (num_starts < 0 || num_starts > 100000) {
    return bad("the number of starts must be in [0, 100000]", num_starts);
  }
  if (!(start_error_mm >= 0.0 && start_error_mm <= 1000.0)) {
    return bad("the start error must be in [0, 1000] mm", start_error_mm);
  }
  if (!(start_error_deg >= 0.0 && start_error_deg <= 180.0)) {
    return bad("the start error must be in [0, 180] degrees", start_error_deg);
  }
  if (!(success_mm > 0.0)) return bad("the limit of success must be above 0 mm", success_mm);
  return {};
}

Eigen::Isometry3d perturbed_start(const Eigen::Isometry3d& ct_from_depth_truth,
                                  const Eigen::Vector3d& ct_center,
                                  double max_shift_mm,
                                  double max_rotation_rad,
                                  std::mt19937_64& random) {
  const Eigen::Vector3d axis = random_direction(random);
  const double angle_rad = random_up_to(max_rotation_rad, random);
  const Eigen::Vector3d direction = random_direction(random);
  const double shift_mm = random_up_to(max_shift_mm, random);
  return Eigen::Translation3d(ct_center + shift_mm * direction) *
         Eigen::AngleAxisd(angle_rad, axis) * Eigen::Translation3d(-ct_center) *
         ct_from_depth_truth;
}

double target_registration_error_mm(const Eigen::Isometry3d& ct_from_depth,
                                    const Eigen::Isometry3d& ct_from_depth_truth,
                                    const std::vector<Target>& targets) {
  const Eigen::Isometry3d depth_from_ct_truth = ct_from_depth_truth.inverse();
  double sum_sq_mm2 = 0.0;
  for (const auto& target : targets) {
    sum_sq_mm2 += (ct_from_depth * (depth_from_ct_truth * target.ct) - target.ct).squaredNorm();
  }
  return std::sqrt(sum_sq_mm2 / static_cast<double>(targets.size()));
}

Result<EvaluationReport> evaluate_recording(const TumRecording& recording,
                                            const std::shared_ptr<const FixedSurface>& fixed,
                                            const std::vector<TimedPose>& truth,
                                            const std::vector<Target>& targets,
                                            const EvaluationOptions& options,
                                            const Progress& progress) {
  MOR_CHECK(options.check());
  if (targets.empty()) {
    return make_error(ErrorCode::kInvalidArgument, "an evaluation needs at least one target");
  }
  MOR_TRY(const auto registration, make_fine_registration(fixed, options.registration));
  MOR_TRY(auto extractor,
          BodySurfaceExtractor::create(recording.calibration()->depth, options.depth));
  Evaluation evaluation(*registration, extractor, fixed->mesh, targets, options);
  DepthLevels levels;
  int num_without_truth = 0;
  for (std::size_t i = 0; i < recording.size(); ++i) {
    if (const auto pose = truth_at(truth, recording.timestamp_s(i))) {
      MOR_TRY(auto frame, recording.read(i));
      MOR_CHECK(evaluation.add_frame(*depth_corrected(std::move(frame), levels), *pose));
    } else {
      ++num_without_truth;
    }
    progress("register", static_cast<double>(i + 1) / static_cast<double>(recording.size()));
  }
  if (num_without_truth == static_cast<int>(recording.size())) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("none of the recording's {} frames has a true pose within {} s",
                                  recording.size(),
                                  kMaxTruthLagS));
  }
  EvaluationReport report = evaluation.report();
  report.num_frames_without_truth = num_without_truth;
  return report;
}

namespace {

/// How often the runs succeed where clutter leaves so much of the body bare, beside what its
/// readings allow.
std::string rows_by_bare_share(const EvaluationReport& report) {
  std::string rows = fmt::format("\n{:<22}{:>8}{:>8}{:>11}{:>12}{:>14}\n",
                                 "body bare",
                                 "frames",
                                 "runs",
                                 "success",
                                 "TRE, mm",
                                 "least, mm");
  for (std::size_t i = 0; i + 1 < kBareShares.size(); ++i) {
    std::set<std::size_t> frames;
    std::vector<double> least_mm;
    for (const auto& [frame, difficulty] : report.frames) {
      if (difficulty.bare_share < kBareShares[i] || difficulty.bare_share >= kBareShares[i + 1]) {
        continue;
      }
      frames.insert(frame);
      least_mm.push_back(difficulty.least_tre_mm);
    }
    std::vector<double> tre_mm;
    for (const auto& run : report.runs) {
      if (frames.contains(run.frame)) tre_mm.push_back(run.tre_mm);
    }
    if (tre_mm.empty()) continue;
    const auto num_runs = static_cast<double>(tre_mm.size());
    const auto num_failed = static_cast<double>(
        std::erase_if(tre_mm, [&](double mm) { return !(mm < report.success_mm); }));
    rows += fmt::format("{:<22}{:>8}{:>8.0f}{:>9.1f} %{:>12.3f}{:>14.3f}\n",
                        fmt::format("{:.0f} to {:.0f} %",
                                    100.0 * kBareShares[i],
                                    100.0 * std::min(1.0, kBareShares[i + 1])),
                        frames.size(),
                        num_runs,
                        100.0 * (1.0 - num_failed / num_runs),
                        summarize(tre_mm).mean,
                        quantile(least_mm, 0.5));
  }
  return rows;
}

}  // namespace

std::string to_json(const EvaluationReport& report) {
  const auto all = [](const Summary& s) {
    return nlohmann::ordered_json{
        {"mean", s.mean}, {"sd", s.sd}, {"median", s.median}, {"p95", s.p95}, {"max", s.max}};
  };
  const auto times = [](const Summary& s) {
    return nlohmann::ordered_json{{"median", s.median}, {"p95", s.p95}};
  };
  nlohmann::ordered_json json = {
      {"method", to_string(report.method)},
      {"device", report.device},
      {"frames", report.num_frames},
      {"starts", report.num_starts},
      {"success_rate", report.success_rate},
      {"tre_mm", all(report.tre_mm)},
      {"tre_success_mm", all(report.tre_success_mm)},
      {"registration_ms", times(report.registration_ms)},
      {"registration_cpu_ms", times(report.registration_cpu_ms)},
      {"points", report.median_points},
  };
  // An infinity becomes null: JSON has none.
  for (const auto& [frame, difficulty] : report.frames) {
    json["difficulty"].push_back({{"frame", frame},
                                  {"bare_share", difficulty.bare_share},
                                  {"least_tre_mm", difficulty.least_tre_mm}});
  }
  for (const auto& run : report.runs) {
    json["runs"].push_back({{"frame", run.frame},
                            {"tre_mm", run.tre_mm},
                            {"start_tre_mm", run.start_tre_mm},
                            {"cpu_ms", run.registration_cpu_ms}});
  }
  return json.dump(2) + "\n";
}

std::string to_table(const EvaluationReport& report) {
  const auto row = [](const char* name, const Summary& s) {
    return fmt::format("{:<22}{:>9.3f}{:>9.3f}{:>9.3f}{:>9.3f}{:>9.3f}\n",
                       name,
                       s.mean,
                       s.sd,
                       s.median,
                       s.p95,
                       s.max);
  };
  std::string table =
      fmt::format("method {}, {} frames, {}, {:.0f} points (median)\n",
                  to_string(report.method),
                  report.num_frames,
                  report.num_starts == 0 ? std::string("each from the pose before")
                                         : fmt::format("{} starts each", report.num_starts),
                  report.median_points);
  if (report.num_frames_without_truth > 0) {
    table += fmt::format("{} frames have no true pose and were left out\n",
                         report.num_frames_without_truth);
  }
  table += fmt::format("success (TRE < limit)  {:.2f} % of {} runs\n\n",
                       100.0 * report.success_rate,
                       report.runs.size());
  table +=
      fmt::format("{:<22}{:>9}{:>9}{:>9}{:>9}{:>9}\n", "", "mean", "SD", "median", "p95", "max");
  table += row("TRE, mm", report.tre_mm);
  table += row("TRE of successes, mm", report.tre_success_mm);
  table += row("registration, ms", report.registration_ms);
  table += row("its processor time, ms", report.registration_cpu_ms);
  table += row("depth to surface, ms", report.depth_ms);
  return table + rows_by_bare_share(report);
}

}  // namespace mor
