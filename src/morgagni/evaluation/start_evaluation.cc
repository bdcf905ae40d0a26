// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/start_evaluation.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <numbers>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/evaluation/frame_difficulty.h"
#include "morgagni/evaluation/recording_evaluation.h"
#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/fine_registration.h"
#include "morgagni/registration/visible_place.h"

namespace mor {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr std::size_t kSkinTargets = 100;

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

std::vector<Target> targets_of(const TriangleMesh& skin) {
  const Eigen::Vector3d center = skin.bounds().center().cast<double>();
  std::vector<Target> targets;
  const std::size_t step = std::max<std::size_t>(1, skin.vertices.size() / kSkinTargets);
  for (std::size_t i = 0; i < skin.vertices.size(); i += step) {
    const Eigen::Vector3d on_skin = skin.vertices[i].cast<double>();
    targets.push_back({"", true, on_skin});
    targets.push_back({"", false, 0.5 * (on_skin + center)});
  }
  return targets;
}

/// Starts on one view after the other and keeps the runs.
class StartEvaluation {
 public:
  StartEvaluation(std::shared_ptr<const FixedSurface> fixed,
                  const StartEvaluationOptions& options,
                  std::unique_ptr<FineRegistration> registration)
      : fixed_(std::move(fixed)),
        options_(options),
        registration_(std::move(registration)),
        skin_center_(fixed_->mesh.bounds().center().cast<double>()),
        targets_(targets_of(fixed_->mesh)) {}

  [[nodiscard]] Result<void> add(std::size_t index, const StartViews& views);
  [[nodiscard]] StartReport report() const;

 private:
  [[nodiscard]] Result<const AutomaticStart*> start_for(const StartView& view);
  [[nodiscard]] Result<void> search(const StartView& view, StartMemory& memory, StartRun& run);
  [[nodiscard]] Result<void> hold_against(const Eigen::Isometry3d& truth,
                                          const RgbdFrame& frame,
                                          StartRun& run) const;
  [[nodiscard]] Result<double> fine_tre_mm(const RgbdFrame& frame,
                                           const Eigen::Isometry3d& truth,
                                           const Eigen::Isometry3d& ct_from_depth) const;
  [[nodiscard]] bool fits(const StartRun& run) const {
    return !run.is_other_body && run.shift_mm < options_.right_mm &&
           run.rotation_deg < options_.right_deg;
  }
  [[nodiscard]] bool is_wrong(const StartRun& run) const {
    return run.is_other_body || run.tre_mm > options_.wrong_tre_mm;
  }

  std::shared_ptr<const FixedSurface> fixed_;
  const StartEvaluationOptions& options_;
  std::unique_ptr<FineRegistration> registration_;
  Eigen::Vector3d skin_center_;
  std::vector<Target> targets_;
  std::optional<AutomaticStart> start_;
  std::vector<StartRun> runs_;
};

/// One starter serves all views, unless each comes with its own gravity.
Result<const AutomaticStart*> StartEvaluation::start_for(const StartView& view) {
  if (!start_ || options_.knows_gravity) {
    AutomaticStartOptions options = options_.start;
    if (options_.knows_gravity && view.ct_from_depth) {
      options.gravity = view.ct_from_depth->linear().transpose() * Eigen::Vector3d::UnitY();
    }
    MOR_TRY(start_, AutomaticStart::create(fixed_, view.frame->calibration->depth, options));
  }
  return &*start_;
}

Result<double> StartEvaluation::fine_tre_mm(const RgbdFrame& frame,
                                            const Eigen::Isometry3d& truth,
                                            const Eigen::Isometry3d& ct_from_depth) const {
  const PinholeCamera& camera = frame.calibration->depth;
  MOR_TRY(auto extractor, BodySurfaceExtractor::create(camera, options_.depth));
  // As the live path does: grown from where the pose shows the body.
  const auto expected = places_facing_camera(fixed_->mesh, ct_from_depth);
  MOR_TRY(const BodySurface surface, extractor.extract(frame.depth_mm.view(), expected));
  if (surface.cloud.empty()) return target_registration_error_mm(ct_from_depth, truth, targets_);
  MOR_TRY(const auto fine,
          registration_->align(surface.cloud, ct_from_depth, StartQuality::kTracked));
  return target_registration_error_mm(fine.fixed_from_moving, truth, targets_);
}

Result<void> StartEvaluation::hold_against(const Eigen::Isometry3d& truth,
                                           const RgbdFrame& frame,
                                           StartRun& run) const {
  const Eigen::Isometry3d& found = run.result.ct_from_depth;
  const Eigen::Isometry3d depth_from_ct = truth.inverse();
  run.shift_mm = displacement_mm(found, truth, depth_from_ct * skin_center_);
  run.rotation_deg = kDegPerRad * rotation_angle_rad(found * depth_from_ct);
  run.tre_mm = target_registration_error_mm(found, truth, targets_);
  run.bare_share =
      frame_difficulty(
          fixed_->mesh, frame.depth_mm.view(), frame.calibration->depth, truth, targets_)
          .bare_share;
  if (run.result.status == AutomaticStartStatus::kFound) {
    MOR_TRY(run.fine_tre_mm, fine_tre_mm(frame, truth, found));
  }
  return {};
}

/// One search in a picture, and what it took.
Result<void> StartEvaluation::search(const StartView& view, StartMemory& memory, StartRun& run) {
  MOR_TRY(const AutomaticStart* start, start_for(view));
  const double cpu_before_ms = cpu_ms();
  const auto started = std::chrono::steady_clock::now();
  const auto depth_mm = view.frame->depth_mm.view();
  MOR_TRY(run.result,
          options_.frames_a_view == 1 ? start->find(depth_mm) : start->find_next(depth_mm, memory));
  const double wall_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - started).count();
  run.cpu_ms += cpu_ms() - cpu_before_ms;
  run.wall_ms += wall_ms;
  const double came_ms = options_.frame_period_ms * static_cast<double>(run.num_frames);
  run.until_ms = std::max(run.until_ms, came_ms) + wall_ms;
  ++run.num_frames;
  return {};
}

Result<void> StartEvaluation::add(std::size_t index, const StartViews& views) {
  StartRun run;
  run.view = index;
  StartMemory memory;
  StartView view;
  while (run.num_frames < options_.frames_a_view &&
         run.result.status != AutomaticStartStatus::kFound) {
    MOR_TRY(view, views(index, run.num_frames));
    MOR_CHECK(search(view, memory, run));
  }
  run.is_other_body = !view.ct_from_depth;
  if (view.ct_from_depth) MOR_CHECK(hold_against(*view.ct_from_depth, *view.frame, run));
  run.is_right = run.result.status == AutomaticStartStatus::kFound && fits(run);
  runs_.push_back(std::move(run));
  return {};
}

StartReport StartEvaluation::report() const {
  StartReport report;
  report.num_views = static_cast<int>(runs_.size());
  report.num_threads = options_.start.num_threads;
  std::vector<double> shift_mm;
  std::vector<double> rotation_deg;
  std::vector<double> fine_mm;
  std::vector<double> wall_ms;
  std::vector<double> cpu_ms;
  std::vector<double> until_ms;
  report.num_right_by_frame.resize(options_.frames_a_view);
  for (const auto& run : runs_) {
    wall_ms.push_back(run.wall_ms);
    cpu_ms.push_back(run.cpu_ms);
    if (run.result.status != AutomaticStartStatus::kFound) {
      ++(run.result.status == AutomaticStartStatus::kAmbiguous ? report.num_ambiguous
                                                               : report.num_not_found);
      continue;
    }
    ++(run.is_right ? report.num_right : is_wrong(run) ? report.num_wrong : report.num_near);
    until_ms.push_back(run.until_ms);
    for (std::size_t i = run.num_frames; run.is_right && i <= options_.frames_a_view; ++i) {
      ++report.num_right_by_frame[i - 1];
    }
    if (run.is_other_body) continue;
    shift_mm.push_back(run.shift_mm);
    rotation_deg.push_back(run.rotation_deg);
    fine_mm.push_back(*run.fine_tre_mm);
  }
  report.shift_mm = summarize(shift_mm);
  report.rotation_deg = summarize(rotation_deg);
  report.fine_tre_mm = summarize(fine_mm);
  report.wall_ms = summarize(wall_ms);
  report.cpu_ms = summarize(cpu_ms);
  report.until_ms = summarize(until_ms);
  report.runs = runs_;
  return report;
}

bool is_found_and_good(const StartRun& run) {
  return !run.is_other_body && run.result.status == AutomaticStartStatus::kFound &&
         run.tre_mm < 5.0;
}

}  // namespace

Result<void> StartEvaluationOptions::check() const {
  MOR_CHECK(start.check());
  MOR_CHECK(depth.check());
  if (frames_a_view < 1 || frames_a_view > 100) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("frames_a_view must be in [1, 100], got {}", frames_a_view));
  }
  for (const auto& [name, value] : {std::pair{"right_mm", right_mm},
                                    {"right_deg", right_deg},
                                    {"wrong_tre_mm", wrong_tre_mm},
                                    {"frame_period_ms", frame_period_ms}}) {
    if (value > 0.0 && std::isfinite(value)) continue;
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{} must be > 0, got {}", name, value));
  }
  return {};
}

Result<StartReport> evaluate_starts(const StartViews& views,
                                    std::size_t num_views,
                                    const std::shared_ptr<const FixedSurface>& fixed,
                                    const StartEvaluationOptions& options,
                                    const Progress& progress) {
  MOR_CHECK(options.check());
  if (num_views == 0) {
    return make_error(ErrorCode::kInvalidArgument, "an evaluation needs at least one view");
  }
  MOR_TRY(auto registration, make_fine_registration(fixed, {}));
  StartEvaluation evaluation(fixed, options, std::move(registration));
  for (std::size_t i = 0; i < num_views; ++i) {
    MOR_CHECK(evaluation.add(i, views));
    if (progress) progress("start", static_cast<double>(i + 1) / static_cast<double>(num_views));
  }
  return evaluation.report();
}

std::string to_json(const StartReport& report) {
  const auto all = [](const Summary& s) {
    return nlohmann::ordered_json{
        {"mean", s.mean}, {"sd", s.sd}, {"median", s.median}, {"p95", s.p95}, {"max", s.max}};
  };
  auto runs = nlohmann::ordered_json::array();
  for (const auto& run : report.runs) {
    nlohmann::ordered_json item = {{"view", run.view},
                                   {"status", to_string(run.result.status)},
                                   {"score", run.result.score},
                                   {"runner_up_score", run.result.runner_up_score},
                                   {"shift_mm", run.shift_mm},
                                   {"rotation_deg", run.rotation_deg},
                                   {"tre_mm", run.tre_mm},
                                   {"bare_share", run.bare_share},
                                   {"frames", run.num_frames},
                                   {"wall_ms", run.wall_ms},
                                   {"cpu_ms", run.cpu_ms},
                                   {"until_ms", run.until_ms}};
    if (run.fine_tre_mm) item["fine_tre_mm"] = *run.fine_tre_mm;
    if (!run.result.reason.empty()) item["reason"] = run.result.reason;
    runs.push_back(std::move(item));
  }
  const nlohmann::ordered_json json = {
      {"views", report.num_views},
      {"right", report.num_right},
      {"near", report.num_near},
      {"wrong", report.num_wrong},
      {"refused", {{"ambiguous", report.num_ambiguous}, {"not_found", report.num_not_found}}},
      {"threads", report.num_threads},
      {"shift_mm", all(report.shift_mm)},
      {"rotation_deg", all(report.rotation_deg)},
      {"fine_tre_mm", all(report.fine_tre_mm)},
      {"wall_ms", all(report.wall_ms)},
      {"cpu_ms", all(report.cpu_ms)},
      {"until_found_ms", all(report.until_ms)},
      {"right_by_frame", report.num_right_by_frame},
      {"runs", std::move(runs)}};
  return json.dump(2);
}

/// How often the start is right where clutter leaves so much of the skin bare.
std::string rows_by_bare_skin(const StartReport& report) {
  std::string rows;
  for (const auto& [from, to] :
       {std::pair{0.0, 0.2}, {0.2, 0.4}, {0.4, 0.6}, {0.6, 0.8}, {0.8, 1.01}}) {
    int num_views = 0;
    int num_right = 0;
    for (const auto& run : report.runs) {
      if (run.is_other_body || run.bare_share < from || run.bare_share >= to) continue;
      ++num_views;
      if (run.is_right) ++num_right;
    }
    if (num_views == 0) continue;
    rows += fmt::format(
        "{:<34}{:>6}  {:5.1f} % of {}\n",
        fmt::format(
            "right with {:.0f}..{:.0f} % of skin bare", 100.0 * from, 100.0 * std::min(to, 1.0)),
        num_right,
        100.0 * num_right / num_views,
        num_views);
  }
  return rows;
}

std::string to_table(const StartReport& report) {
  std::string table;
  const auto count = [&](std::string_view what, int number) {
    table += fmt::format(
        "{:<34}{:>6}  {:5.1f} %\n", what, number, 100.0 * number / std::max(1, report.num_views));
  };
  count("found and right", report.num_right);
  count("found, neither right nor wrong", report.num_near);
  count("found and wrong", report.num_wrong);
  count("refused: ambiguous", report.num_ambiguous);
  count("refused: not found", report.num_not_found);
  const std::size_t num_frames = report.num_right_by_frame.size();
  for (std::size_t i = 0; num_frames > 1 && i < num_frames; ++i) {
    count(fmt::format("right within {} picture{}", i + 1, i == 0 ? "" : "s"),
          report.num_right_by_frame[i]);
  }
  table += rows_by_bare_skin(report);
  const auto row = [&](std::string_view what, const Summary& s) {
    table += fmt::format("{:<34}{:>8.2f}{:>8.2f}{:>8.2f}{:>8.2f}{:>8.2f}\n",
                         what,
                         s.mean,
                         s.sd,
                         s.median,
                         s.p95,
                         s.max);
  };
  table +=
      fmt::format("\n{:<34}{:>8}{:>8}{:>8}{:>8}{:>8}\n", "", "mean", "sd", "median", "p95", "max");
  row("shift of the found, mm", report.shift_mm);
  row("rotation of the found, deg", report.rotation_deg);
  row("TRE after fine registration, mm", report.fine_tre_mm);
  row(fmt::format("time on {} threads, ms", report.num_threads), report.wall_ms);
  row("processor time, ms", report.cpu_ms);
  if (num_frames > 1) row("first picture to found, ms", report.until_ms);
  for (const auto& run : report.runs) {
    if (is_found_and_good(run)) continue;
    if (run.is_other_body) {
      table += fmt::format(
          "\nview {}: {}. {}", run.view, to_string(run.result.status), run.result.reason);
      continue;
    }
    table += fmt::format("\nview {}: {}, {:.1f} mm and {:.1f} deg off, TRE {:.1f} mm. {}",
                         run.view,
                         to_string(run.result.status),
                         run.shift_mm,
                         run.rotation_deg,
                         run.tre_mm,
                         run.result.reason);
  }
  if (table.back() != '\n') table += '\n';
  return table;
}

}  // namespace mor
