// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/self_calibration_evaluation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <iterator>
#include <numbers>
#include <random>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/simulated_camera.h"
#include "morgagni/core/statistics.h"
#include "morgagni/evaluation/recording_evaluation.h"
#include "morgagni/evaluation/summary.h"
#include "morgagni/evaluation/target_sampling.h"
#include "morgagni/registration/visible_place.h"

namespace mor {
namespace {

constexpr double kStartErrorMm = 5.0;
constexpr double kStartErrorRad = 2.0 * std::numbers::pi / 180.0;
constexpr int kTargetsOfAKind = 10;
constexpr std::size_t kLeastPoints = 200;
/// Frames looked through for views, and again for held ones.
constexpr int kMostShown = 1000;
/// The hand's swing is full by then.
constexpr std::uint64_t kFirstFrame = 300;

double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11U) * 0x1.0p-53 * 2.0 - 1.0;
}

double thread_cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

/// A smooth error over the picture: offset, tilt, bowl and saddle, as control points.
DepthCorrection make_bias(AddedBias kind, double rms_mm, std::uint64_t seed) {
  constexpr int kColumns = 25;
  constexpr int kRows = 19;
  constexpr double kReferenceMm = 800.0;
  std::mt19937_64 random(seed ^ 0x53454C46U);
  std::array<double, 6> shares{};
  for (double& share : shares) share = uniform(random);
  std::vector<double> shape;
  double squares = 0.0;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const double x = 2.0 * column / (kColumns - 1) - 1.0;
      const double y = 2.0 * row / (kRows - 1) - 1.0;
      shape.push_back(shares[0] + shares[1] * x + shares[2] * y +
                      shares[3] * (x * x + y * y - 2.0 / 3.0) + shares[4] * x * y +
                      shares[5] * std::sin(2.5 * x) * std::cos(2.0 * y));
      squares += shape.back() * shape.back();
    }
  }
  const double scale_mm = rms_mm / std::sqrt(squares / static_cast<double>(shape.size()));
  DepthCorrection bias{.columns = kColumns, .rows = kRows, .control = {}, .curve = {}};
  for (const double value : shape) {
    const double amount_mm = scale_mm * value;
    bias.control.push_back(
        kind == AddedBias::kFixed
            ? DepthCorrection::Coefficients{amount_mm, 0.0, 0.0}
            : DepthCorrection::Coefficients{0.0, 0.0, amount_mm / (kReferenceMm * kReferenceMm)});
  }
  return bias;
}

/// The body as it is now: its skin moved along the normals by a sum of waves of 150 to 400 mm.
TriangleMesh changed_skin(TriangleMesh skin, double rms_mm, std::uint64_t seed) {
  struct Wave {
    Eigen::Vector3d per_mm;
    double phase;
  };
  std::mt19937_64 random(seed ^ 0x534B494EU);
  std::vector<Wave> waves;
  while (waves.size() < 12) {
    const Eigen::Vector3d direction(uniform(random), uniform(random), uniform(random));
    if (direction.norm() > 1.0 || direction.norm() < 0.1) continue;
    const double length_mm = 275.0 + 125.0 * uniform(random);
    waves.push_back({2.0 * std::numbers::pi / length_mm * direction.normalized(),
                     std::numbers::pi * uniform(random)});
  }
  std::vector<double> moves;
  double squares = 0.0;
  for (const auto& vertex : skin.vertices) {
    double move = 0.0;
    for (const auto& wave : waves) {
      move += std::sin(wave.per_mm.dot(vertex.cast<double>()) + wave.phase);
    }
    moves.push_back(move);
    squares += move * move;
  }
  const double scale_mm = rms_mm / std::sqrt(squares / static_cast<double>(moves.size()));
  for (std::size_t i = 0; i < moves.size(); ++i) {
    skin.vertices[i] += static_cast<float>(scale_mm * moves[i]) * skin.normals[i];
  }
  return skin;
}

/// None where there is too little of the body for a pose, as tracking has it.
Result<std::optional<Eigen::Isometry3d>> registered(FineRegistration& registration,
                                                    const TriangleMesh& skin,
                                                    const Image<std::uint16_t>& depth_mm,
                                                    const PinholeCamera& camera,
                                                    const BodySurfaceOptions& depth,
                                                    const Eigen::Isometry3d& start) {
  MOR_TRY(auto extractor, BodySurfaceExtractor::create(camera, depth));
  MOR_TRY(const auto surface,
          extractor.extract(depth_mm.view(), places_facing_camera(skin, start)));
  if (surface.cloud.size() < kLeastPoints) return std::nullopt;
  MOR_TRY(const auto result, registration.align(surface.cloud, start, StartQuality::kTracked));
  const bool has_pose = result.status == RegistrationStatus::kConverged ||
                        result.status == RegistrationStatus::kMaxIterations;
  return has_pose ? std::optional(result.fixed_from_moving) : std::nullopt;
}

/// One group and seed.
class SeedRun {
 public:
  SeedRun(const SelfCalibrationGroup& group, const SelfCalibrationStudyOptions& options)
      : group_(group), options_(options) {}

  [[nodiscard]] Result<SelfCalibrationRun> run(std::uint64_t seed) {
    MOR_CHECK(prepare(seed));
    SelfCalibrationRun run;
    run.seed = seed;
    const RgbdCalibration calibration = stated_calibration(seed);
    const PinholeCamera& stated = calibration.depth;
    if (group_.held && !(group_.held->depth == camera_->calibration().depth)) {
      return make_error(ErrorCode::kUnsupported,
                        "the recording has another pinhole than the simulated camera");
    }
    // As live: what cannot be registered is no view, and the next one takes its place.
    std::vector<SensedSkin> views;
    int shown = 0;
    for (; std::ssize(views) < options_.num_views && shown < kMostShown; ++shown) {
      const auto id = frame_id(shown);
      const auto depth_mm = picture(id);
      MOR_TRY(const auto pose, align(depth_mm, stated, start_near(id)));
      if (pose) views.push_back(read(depth_mm, stated, *pose));
    }
    const double started_s = thread_cpu_s();
    MOR_TRY(run.found,
            estimate_self_calibration(group_.body->mesh, calibration, views, options_.estimate));
    run.cpu_s = thread_cpu_s() - started_s;
    MOR_CHECK(measure(shown, stated, run));
    return run;
  }

 private:
  Result<void> prepare(std::uint64_t seed) {
    MOR_TRY(auto camera, SimulatedCameraOptions::parse(group_.camera));
    camera.seed = seed;
    camera.is_real_time = false;
    is_views_ = camera.path == SimulatedPath::kViews;
    const auto& mesh = group_.body->mesh;
    MOR_TRY(camera_,
            SimulatedCamera::create(std::make_shared<const TriangleMesh>(body_now(seed)), camera));
    if (group_.added != AddedBias::kNone) {
      bias_ = make_bias(group_.added, group_.added_mm, seed);
    }
    if (group_.recorded) bias_ = group_.recorded->adds;
    MOR_TRY(registration_, make_fine_registration(group_.body, {}));
    random_.seed(seed);
    if (group_.held) {
      targets_ = group_.held->targets;
    } else {
      MOR_TRY(targets_, sample_skin_targets(mesh, kTargetsOfAKind, 1));
      MOR_TRY(const auto inner, sample_internal_targets(mesh, kTargetsOfAKind, 1));
      targets_.insert(targets_.end(), inner.begin(), inner.end());
    }
    std::ranges::copy_if(targets_, std::back_inserter(inside_), [](const Target& target) {
      return !target.on_skin;
    });
    return {};
  }

  /// Both focal lengths are off by the same: so a depth that is off hides best.
  [[nodiscard]] RgbdCalibration stated_calibration(std::uint64_t seed) const {
    RgbdCalibration calibration = camera_->calibration();
    if (!group_.pinhole_sd) return calibration;
    calibration.depth_sd = group_.pinhole_sd;
    std::mt19937_64 random(seed ^ 0x50494E48U);
    std::normal_distribution<double> draw;
    const double focal = 1.0 + group_.pinhole_sd->focal_ratio * draw(random);
    calibration.depth.focal_x_px *= focal;
    calibration.depth.focal_y_px *= focal;
    calibration.depth.center_x_px += group_.pinhole_sd->center_px * draw(random);
    calibration.depth.center_y_px += group_.pinhole_sd->center_px * draw(random);
    return calibration;
  }

  /// The body before the camera, which is not quite as in the CT.
  [[nodiscard]] TriangleMesh body_now(std::uint64_t seed) const {
    TriangleMesh skin = group_.body->mesh;
    if (group_.recorded) skin = group_.recorded->body.applied_to(std::move(skin));
    if (group_.changed_skin_mm > 0.0) {
      skin = changed_skin(std::move(skin), group_.changed_skin_mm, seed);
    }
    return skin;
  }

  /// Registers the held frames as they are, with the sensor corrected, and as the verdict says.
  Result<void> measure(int shown, const PinholeCamera& stated, SelfCalibrationRun& run) {
    const auto& found = run.found;
    auto skin = group_.body;
    if (found.follows_skin) {
      MOR_TRY(skin, skin_as_found(found.skin.applied_to(skin->mesh), "as found"));
    }
    MOR_TRY(const auto on_skin, make_fine_registration(skin, {}));
    const int num_frames = group_.held ? static_cast<int>(group_.held->frames.size()) : kMostShown;
    const auto wanted = static_cast<std::size_t>(group_.held ? num_frames : options_.num_held);
    for (int i = 0; i < num_frames && run.before.all_mm.size() < wanted; ++i) {
      const auto held = held_frame(group_.held ? i : shown + i);
      levels_.learn(held.depth_mm.view());
      const auto corrected = found.correction.apply(held.depth_mm.view(), levels_);
      MOR_TRY(const auto before, align(held.depth_mm, stated, held.start));
      MOR_TRY(const auto sensor, align(corrected, found.depth, held.start));
      MOR_TRY(const auto followed,
              registered(*on_skin,
                         skin->mesh,
                         found.corrects_sensor() ? corrected : held.depth_mm,
                         found.corrects_sensor() ? found.depth : stated,
                         options_.depth,
                         held.start));
      if (!before || !sensor || !followed) continue;  // It has no pose some way, and shows none.
      add_errors(*before, held.truth, run.before);
      add_errors(*sensor, held.truth, run.sensor);
      add_errors(*followed, held.truth, run.followed);
    }
    return {};
  }

  void add_errors(const Eigen::Isometry3d& found,
                  const Eigen::Isometry3d& truth,
                  HeldErrors& errors) const {
    errors.all_mm.push_back(target_registration_error_mm(found, truth, targets_));
    errors.inside_mm.push_back(target_registration_error_mm(found, truth, inside_));
  }

  struct HeldFrame {
    Image<std::uint16_t> depth_mm;
    Eigen::Isometry3d truth;
    Eigen::Isometry3d start;
  };

  [[nodiscard]] HeldFrame held_frame(int i) {
    if (group_.held) {
      const auto& frame = group_.held->frames[static_cast<std::size_t>(i)];
      return {frame.depth_mm, frame.ct_from_depth, start_from(frame.ct_from_depth)};
    }
    const auto id = frame_id(i) + 7;
    return {picture(id), camera_->ct_from_camera(id), start_near(id)};
  }

  [[nodiscard]] std::uint64_t frame_id(int i) const {
    const auto at = static_cast<std::uint64_t>(i);
    return is_views_ ? at : kFirstFrame + at * static_cast<std::uint64_t>(options_.frames_apart);
  }

  [[nodiscard]] Image<std::uint16_t> picture(std::uint64_t id) {
    auto frame = camera_->frame_at(id);
    if (!bias_) return frame->depth_mm;
    // The error lies in what the sensor measures, so its rounding must not come before.
    unbiased_levels_.learn(frame->depth_mm.view());
    return bias_->apply(frame->depth_mm.view(), unbiased_levels_);
  }

  [[nodiscard]] SensedSkin read(const Image<std::uint16_t>& depth_mm,
                                const PinholeCamera& camera,
                                const Eigen::Isometry3d& ct_from_depth) {
    levels_.learn(depth_mm.view());
    return read_skin(group_.body->mesh, camera, depth_mm.view(), levels_, ct_from_depth);
  }

  [[nodiscard]] Eigen::Isometry3d start_near(std::uint64_t id) {
    return start_from(camera_->ct_from_camera(id));
  }

  [[nodiscard]] Eigen::Isometry3d start_from(const Eigen::Isometry3d& truth) {
    const Eigen::Vector3d center = group_.body->mesh.bounds().center().cast<double>();
    return perturbed_start(truth, center, kStartErrorMm, kStartErrorRad, random_);
  }

  [[nodiscard]] Result<std::optional<Eigen::Isometry3d>> align(
      const Image<std::uint16_t>& depth_mm,
      const PinholeCamera& camera,
      const Eigen::Isometry3d& start) const {
    return registered(*registration_, group_.body->mesh, depth_mm, camera, options_.depth, start);
  }

  const SelfCalibrationGroup& group_;
  const SelfCalibrationStudyOptions& options_;
  std::unique_ptr<SimulatedCamera> camera_;
  std::optional<DepthCorrection> bias_;
  DepthLevels unbiased_levels_;
  DepthLevels levels_;  ///< Of the pictures as tracking gets them.
  std::unique_ptr<FineRegistration> registration_;
  std::vector<Target> targets_;
  std::vector<Target> inside_;  ///< Of them.
  std::mt19937_64 random_;
  bool is_views_ = false;
};

/// All frames of a group's runs.
struct GroupErrors {
  HeldErrors before, sensor, followed;
  std::vector<double> left_mm;      ///< Of the runs with a proposal: what they say stays,
  std::vector<double> proposed_mm;  ///< and their frames' errors once it is followed.
  int num_runs = 0;
  int num_sensor = 0;      ///< Runs that propose to correct the sensor,
  int num_skin = 0;        ///< and to follow the skin.
  int num_better = 0;      ///< Frames that gain, by 0.1 mm or more, when the verdict is followed.
  int num_worse = 0;       ///< And that lose.
  int num_runs_worse = 0;  ///< In the mean over their frames.
};

void append(const std::vector<double>& more, std::vector<double>& all) {
  all.insert(all.end(), more.begin(), more.end());
}

void append(const HeldErrors& more, HeldErrors& all) {
  append(more.all_mm, all.all_mm);
  append(more.inside_mm, all.inside_mm);
}

GroupErrors collect(const std::vector<SelfCalibrationRun>& runs, std::size_t group) {
  constexpr double kNoticeableMm = 0.1;
  GroupErrors errors;
  for (const auto& run : runs) {
    if (run.group != group) continue;
    ++errors.num_runs;
    if (run.found.corrects_sensor()) ++errors.num_sensor;
    if (run.found.follows_skin) ++errors.num_skin;
    append(run.before, errors.before);
    append(run.sensor, errors.sensor);
    append(run.followed, errors.followed);
    if (run.found.proposes()) {
      errors.left_mm.push_back(run.found.left_mm());
      append(run.followed.all_mm, errors.proposed_mm);
    }
    const auto& before_mm = run.before.all_mm;
    const auto& followed_mm = run.followed.all_mm;
    for (std::size_t i = 0; i < followed_mm.size(); ++i) {
      if (followed_mm[i] < before_mm[i] - kNoticeableMm) ++errors.num_better;
      if (followed_mm[i] > before_mm[i] + kNoticeableMm) ++errors.num_worse;
    }
    const double gain_mm = summarize(before_mm).mean - summarize(followed_mm).mean;
    if (gain_mm < -kNoticeableMm) ++errors.num_runs_worse;
  }
  return errors;
}

std::string summary_cells(const std::vector<double>& values_mm) {
  const auto summary = summarize(values_mm);
  return fmt::format("{:.2f} ± {:.2f} / {:.2f} / {:.2f} / {:.2f}",
                     summary.mean,
                     summary.sd,
                     summary.median,
                     summary.p95,
                     summary.max);
}

}  // namespace

Result<void> SelfCalibrationStudyOptions::check() const {
  const auto bad = [](const char* what, int value) {
    return make_error(ErrorCode::kInvalidArgument, fmt::format("{}, got {}", what, value));
  };
  if (num_seeds < 1) return bad("seeds must be at least 1", num_seeds);
  if (num_views < 20 || num_views > 500) return bad("views must be in [20, 500]", num_views);
  if (frames_apart < 1) return bad("views must be at least 1 frame apart", frames_apart);
  if (num_held < 1) return bad("held frames must be at least 1", num_held);
  MOR_CHECK(estimate.check());
  return depth.check();
}

Result<std::vector<SelfCalibrationRun>> run_self_calibration_study(
    const std::vector<SelfCalibrationGroup>& groups,
    const SelfCalibrationStudyOptions& options,
    const Progress& progress) {
  MOR_CHECK(options.check());
  std::vector<SelfCalibrationRun> runs;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    for (int k = 0; k < options.num_seeds; ++k) {
      const auto seed = options.first_seed + static_cast<std::uint64_t>(k);
      MOR_TRY(auto run, SeedRun(groups[i], options).run(seed));
      run.group = i;
      runs.push_back(std::move(run));
      progress(groups[i].name, static_cast<double>(k + 1) / options.num_seeds);
    }
  }
  return runs;
}

Result<RecordedLimit> recorded_limit(const std::shared_ptr<const FixedSurface>& body,
                                     const RecordedFrames& recorded,
                                     const RecordedBias& bias,
                                     const BodySurfaceOptions& depth) {
  MOR_TRY(const auto body_now, skin_as_found(bias.body.applied_to(body->mesh), "by the truth"));
  const auto errors = [&](const std::shared_ptr<const FixedSurface>& skin,
                          bool is_corrected) -> Result<std::vector<double>> {
    MOR_TRY(const auto registration, make_fine_registration(skin, {}));
    DepthLevels levels;
    std::vector<double> errors_mm;
    for (const auto& frame : recorded.frames) {
      levels.learn(frame.depth_mm.view());
      const auto depth_mm =
          is_corrected ? bias.removes.apply(frame.depth_mm.view(), levels) : frame.depth_mm;
      MOR_TRY(const auto pose,
              registered(
                  *registration, skin->mesh, depth_mm, recorded.depth, depth, frame.ct_from_depth));
      if (!pose) continue;
      errors_mm.push_back(
          target_registration_error_mm(*pose, frame.ct_from_depth, recorded.targets));
    }
    return errors_mm;
  };
  RecordedLimit limit;
  MOR_TRY(limit.as_it_is_mm, errors(body, false));
  MOR_TRY(limit.without_error_mm, errors(body, true));
  MOR_TRY(limit.with_body_mm, errors(body_now, true));
  return limit;
}

std::string to_markdown(const std::vector<SelfCalibrationGroup>& groups,
                        const std::vector<SelfCalibrationRun>& runs) {
  std::string text =
      "TRE at held frames in mm: mean ± SD / median / p95 / max.\n\n"
      "| case | proposed: sensor, skin | as it is | verdict followed | inside, mean | frames "
      "better "
      "/ worse | runs worse | sensor alone, always: mean | where proposed: root mean square, said "
      "to stay |\n|---|---|---|---|---|---|---|---|---|\n";
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const auto errors = collect(runs, i);
    const auto frames = static_cast<double>(std::max<std::size_t>(1, errors.before.all_mm.size()));
    const auto stays = errors.left_mm.empty() ? std::string("–")
                                              : fmt::format("{:.2f}, {:.2f}",
                                                            root_mean_square(errors.proposed_mm),
                                                            root_mean_square(errors.left_mm));
    text += fmt::format(
        "| {} | {}, {} of {} | {} | {} | {:.2f} to {:.2f} | {:.0f} / {:.0f} % | {} | {:.2f} | {} "
        "|\n",
        groups[i].name,
        errors.num_sensor,
        errors.num_skin,
        errors.num_runs,
        summary_cells(errors.before.all_mm),
        summary_cells(errors.followed.all_mm),
        summarize(errors.before.inside_mm).mean,
        summarize(errors.followed.inside_mm).mean,
        100.0 * errors.num_better / frames,
        100.0 * errors.num_worse / frames,
        errors.num_runs_worse,
        summarize(errors.sensor.all_mm).mean,
        stays);
  }
  return text;
}

static nlohmann::json gain_json(const HeldOutGain& gain) {
  return {{"share", gain.share}, {"significance", gain.significance}, {"better", gain.num_better}};
}

std::string to_json(const std::vector<SelfCalibrationGroup>& groups,
                    const std::vector<SelfCalibrationRun>& runs,
                    const SelfCalibrationStudyOptions& options) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& run : runs) {
    list.push_back({{"case", groups[run.group].name},
                    {"camera", groups[run.group].camera},
                    {"seed", run.seed},
                    {"verdict", to_string(run.found.verdict)},
                    {"shift_mm", run.found.shift_mm},
                    {"remaining_mm", run.found.remaining_mm},
                    {"size_ratio", run.found.size_ratio},
                    {"open", run.found.num_open},
                    {"skin_rms_mm", run.found.skin_rms_mm},
                    {"skin_shift_mm", run.found.skin_shift_mm},
                    {"skin_remaining_mm", run.found.skin_remaining_mm},
                    {"follows_skin", run.found.follows_skin},
                    {"focal_ratio", {run.found.focal_x_ratio, run.found.focal_y_ratio}},
                    {"open_share", run.found.open_share},
                    {"held_out_mm",
                     {run.found.held_out.as_it_is_mm,
                      run.found.held_out.skin_mm,
                      run.found.held_out.sensor_mm,
                      run.found.held_out.both_mm}},
                    {"gain_by_sensor", gain_json(run.found.held_out.sensor)},
                    {"gain_by_skin", gain_json(run.found.held_out.skin)},
                    {"gain_by_skin_and_sensor", gain_json(run.found.held_out.skin_and_sensor)},
                    {"tre_before_mm", run.before.all_mm},
                    {"tre_sensor_mm", run.sensor.all_mm},
                    {"tre_followed_mm", run.followed.all_mm},
                    {"sees_table", run.found.sees_table},
                    {"cpu_s", run.cpu_s}});
  }
  return nlohmann::json{{"first_seed", options.first_seed},
                        {"views", options.num_views},
                        {"frames_apart", options.frames_apart},
                        {"runs", list}}
      .dump(1);
}

}  // namespace mor
