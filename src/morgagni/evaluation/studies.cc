// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/studies.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>

#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/tum_recording.h"
#include "morgagni/depth/body_surface.h"
#include "morgagni/evaluation/recording_evaluation.h"
#include "morgagni/evaluation/target_sampling.h"
#include "morgagni/registration/visible_place.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

constexpr int kPhantomMarkers = 10;
constexpr int kPostMortemMarkers = 22;
constexpr int kInternalTargets = 16;
constexpr int kStartsPerRecordedFrame = 4;
/// What the paper recommends, and what the live path uses.
constexpr double kLiveDownSampling = 2.5;

double thread_cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

/// Each of the paper's methods on every device, then ours.
std::vector<StudyMethod> with_devices(const std::vector<RegistrationMethod>& papers,
                                      double down_sampling,
                                      double field_down_sampling,
                                      bool runs_opencl) {
  std::vector<StudyMethod> methods;
  for (const auto method : papers) {
    methods.push_back({method, "cpu", down_sampling});
    if (runs_opencl) methods.push_back({method, "opencl", down_sampling});
  }
  methods.push_back({RegistrationMethod::kField, "cpu", field_down_sampling});
  return methods;
}

std::string camera_text(const SimulatedCameraOptions& options) {
  constexpr std::array<const char*, 5> kClutter = {"none", "hand", "towel", "parts", "all"};
  std::string text = fmt::format("simulated:path=views,seed={},clutter={}",
                                 options.seed,
                                 kClutter[static_cast<std::size_t>(options.clutter)]);
  if (options.bias_mm > 0.0) text += fmt::format(",bias={}", options.bias_mm);
  if (options.focal_error_percent != 0.0) {
    text += fmt::format(",focal={}", options.focal_error_percent);
  }
  return text;
}

double tagged_error_mm(const Eigen::Isometry3d& ct_from_depth,
                       const std::vector<TaggedMarker>& markers) {
  double squares = 0.0;
  for (const auto& marker : markers) {
    squares += (ct_from_depth * marker.tagged_depth - marker.tagged_ct).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(markers.size()));
}

/// What a study is made of before any method runs.
struct Setting {
  std::string name;
  SimulatedCameraOptions camera;
  int num_markers;
  int num_poses;
};

struct Prepared {
  Study study;
  std::vector<StudyPose> poses;
  std::vector<Target> internal;
};

/// Runs methods over poses of one body.
class Studies {
 public:
  Studies(const Case& body, const StudiesOptions& options, const Progress& progress)
      : body_(body), options_(options), progress_(progress) {}

  [[nodiscard]] Result<Prepared> prepare(const Setting& setting) const {
    const auto& skin = body_.skin->mesh;
    const std::shared_ptr<const TriangleMesh> shared(body_.skin, &skin);
    auto camera_options = setting.camera;
    camera_options.path = SimulatedPath::kViews;
    camera_options.seed = options_.seed;
    MOR_TRY(const auto camera, SimulatedCamera::create(shared, camera_options));
    MOR_TRY(const auto markers, sample_skin_targets(skin, setting.num_markers, options_.seed));
    Prepared prepared;
    prepared.study.name = setting.name;
    prepared.study.camera = camera_text(camera_options);
    prepared.study.num_markers = setting.num_markers;
    MOR_TRY(prepared.internal, sample_internal_targets(skin, kInternalTargets, options_.seed));
    MOR_TRY(prepared.poses,
            draw_study_poses(
                skin, *camera, camera_options, markers, options_.tagging, setting.num_poses));
    return prepared;
  }

  /// A device that is not there leaves an empty column and its reason.
  [[nodiscard]] Result<void> add_column(Prepared& prepared, const StudyMethod& method) const {
    StudyColumn column{method, {}, {}};
    RegistrationOptions registration_options;
    registration_options.method = method.method;
    registration_options.device = method.device;
    const auto registration = make_fine_registration(body_.skin, registration_options);
    // Where a device is missing or fails the CPU takes over: that is not what was asked.
    const auto is_on_cpu_instead = [&] {
      return method.device != "cpu" && (*registration)->device_name() == "cpu";
    };
    if (!registration) {
      column.not_run = registration.error().message;
    } else if (is_on_cpu_instead()) {
      column.not_run = "there is no OpenCL device that works";
    } else {
      MOR_TRY(
          auto extractor,
          BodySurfaceExtractor::create(prepared.poses.front().frame->calibration->depth,
                                       {.down_sampling = method.down_sampling,
                                        .averages = method.method == RegistrationMethod::kField}));
      for (const auto& pose : prepared.poses) {
        MOR_TRY(const auto run, this->run(pose, prepared.internal, extractor, **registration));
        column.runs.push_back(run);
      }
      if (is_on_cpu_instead()) {
        column.runs.clear();
        column.not_run = "the OpenCL device failed, the CPU took over";
      }
    }
    prepared.study.columns.push_back(std::move(column));
    return {};
  }

  [[nodiscard]] Result<Study> study(const Setting& setting,
                                    const std::vector<StudyMethod>& methods) const {
    const auto tell = [&](std::size_t done) {
      progress_(setting.name, static_cast<double>(done) / static_cast<double>(methods.size()));
    };
    tell(0);
    MOR_TRY(auto prepared, prepare(setting));
    for (std::size_t i = 0; i < methods.size(); ++i) {
      MOR_CHECK(add_column(prepared, methods[i]));
      tell(i + 1);
    }
    return std::move(prepared.study);
  }

 private:
  [[nodiscard]] Result<StudyRun> run(const StudyPose& pose,
                                     const std::vector<Target>& internal,
                                     BodySurfaceExtractor& extractor,
                                     const FineRegistration& registration) const {
    MOR_TRY(const auto surface,
            extractor.extract(pose.frame->depth_mm.view(),
                              places_facing_camera(body_.skin->mesh, pose.start)));
    if (surface.cloud.size() < 3) {
      return make_error(ErrorCode::kInvalidArgument, "a pose of a study shows no surface");
    }
    const auto started = std::chrono::steady_clock::now();
    const double cpu_started_ms = thread_cpu_ms();
    MOR_TRY(const auto result, registration.align(surface.cloud, pose.start, StartQuality::kRough));
    StudyRun run;
    run.cpu_ms = thread_cpu_ms() - cpu_started_ms;
    run.registration_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - started)
            .count();
    run.fre_mm = pose.fre_mm;
    run.tagged_tre_mm = tagged_error_mm(result.fixed_from_moving, pose.markers);
    run.internal_tre_mm =
        target_registration_error_mm(result.fixed_from_moving, pose.ct_from_depth, internal);
    run.start_tre_mm = target_registration_error_mm(pose.start, pose.ct_from_depth, internal);
    run.num_points = static_cast<int>(surface.cloud.size());
    run.num_iterations = result.num_iterations;
    return run;
  }

  const Case& body_;
  const StudiesOptions& options_;
  const Progress& progress_;
};

/// Table 3 over the poses of table 2: prepared once, each factor a study.
Result<std::vector<Study>> down_sampling_studies(const Studies& studies,
                                                 const Setting& setting,
                                                 const StudiesOptions& options,
                                                 const Progress& progress) {
  MOR_TRY(auto prepared, studies.prepare(setting));
  std::vector<Study> result;
  for (const double factor : options.down_samplings) {
    progress(
        setting.name,
        static_cast<double>(result.size()) / static_cast<double>(options.down_samplings.size()));
    prepared.study.columns.clear();
    for (const auto& method :
         with_devices({RegistrationMethod::kTrimmedIcp}, factor, factor, options.runs_opencl)) {
      MOR_CHECK(studies.add_column(prepared, method));
    }
    result.push_back(prepared.study);
  }
  progress(setting.name, 1.0);
  return result;
}

std::vector<StudyMethod> live_methods() {
  return {{RegistrationMethod::kIcp, "cpu", kLiveDownSampling},
          {RegistrationMethod::kTrimmedIcp, "cpu", kLiveDownSampling},
          {RegistrationMethod::kField, "cpu", kLiveDownSampling}};
}

Result<AlignedTruth> truth_on(const Case& body, const fs::path& recording) {
  MOR_TRY(auto poses, read_ground_truth(recording / "groundtruth.txt"));
  MOR_TRY(auto targets, read_targets(recording / "targets.csv"));
  return align_truth_to_case(std::move(poses),
                             std::move(targets),
                             TruthFrame::kAuto,
                             body.skin->field,
                             body.ct_center_mm,
                             body.ct_half_voxel_mm);
}

/// One recording by every live method.
Result<void> add_recording(const fs::path& folder,
                           const Case& body,
                           const AlignedTruth& truth,
                           const StudiesOptions& options,
                           StudiesReport& report) {
  MOR_TRY(const auto recording, TumRecording::open(folder));
  for (const auto& method : live_methods()) {
    EvaluationOptions evaluation;
    evaluation.registration.method = method.method;
    evaluation.registration.device = method.device;
    evaluation.depth.down_sampling = method.down_sampling;
    evaluation.num_starts = kStartsPerRecordedFrame;
    evaluation.seed = options.seed;
    evaluation.success_mm = options.success_mm;
    const auto silent = [](std::string_view, double) {};
    MOR_TRY(
        const auto result,
        evaluate_recording(recording, body.skin, truth.poses, truth.targets, evaluation, silent));
    report.recorded.push_back({folder.filename().string(),
                               method,
                               result.success_rate,
                               result.tre_mm,
                               result.tre_success_mm});
  }
  return {};
}

/// By the first of the bodies on whose skin the recording's targets lie.
Result<void> add_recording_of(const fs::path& folder,
                              const std::vector<const Case*>& bodies,
                              const StudiesOptions& options,
                              StudiesReport& report) {
  std::string reason;
  for (const Case* body : bodies) {
    const auto truth = truth_on(*body, folder);
    if (truth) return add_recording(folder, *body, *truth, options, report);
    if (truth.error().code != ErrorCode::kInvalidArgument) return tl::unexpected(truth.error());
    reason = truth.error().message;
  }
  report.notes.push_back(fmt::format("{}: {}", folder.filename().string(), reason));
  return {};
}

Result<void> add_recordings(const Case& studied,
                            const RecordedData& data,
                            const StudiesOptions& options,
                            const Progress& progress,
                            StudiesReport& report) {
  std::vector<const Case*> bodies = {&studied};
  for (const auto& body : data.bodies) bodies.push_back(&body);
  std::error_code status;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(data.folder, status)) {
    if (entry.path().filename().string().ends_with("_real")) found.push_back(entry.path());
  }
  if (status) {
    return make_error(ErrorCode::kIo,
                      fmt::format("{}: {}", data.folder.string(), status.message()));
  }
  std::sort(found.begin(), found.end());
  for (std::size_t i = 0; i < found.size(); ++i) {
    progress("recordings", static_cast<double>(i) / static_cast<double>(found.size()));
    MOR_CHECK(add_recording_of(found[i], bodies, options, report));
  }
  progress("recordings", 1.0);
  return {};
}

tl::unexpected<Error> invalid(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, std::move(message));
}

}  // namespace

Result<void> StudiesOptions::check() const {
  if (num_poses < 1) return invalid(fmt::format("num_poses must be >= 1, got {}", num_poses));
  if (num_many_poses < 1) {
    return invalid(fmt::format("num_many_poses must be >= 1, got {}", num_many_poses));
  }
  for (const double sd : {tagging.marker_px, tagging.marker_ct_mm, tagging.landmark_mm}) {
    if (!(sd >= 0.0 && sd <= 100.0)) {
      return invalid(fmt::format("an error of tagging must be in [0, 100], got {}", sd));
    }
  }
  if (down_samplings.empty()) return invalid("down_samplings must not be empty");
  for (const double factor : down_samplings) {
    if (!(factor >= 1.0 && factor <= 4.0)) {
      return invalid(fmt::format("down-sampling must be in [1, 4], got {}", factor));
    }
  }
  if (!(success_mm > 0.0))
    return invalid(fmt::format("success_mm must be > 0, got {}", success_mm));
  SimulatedCameraOptions camera;
  camera.bias_mm = bias_mm;
  camera.focal_error_percent = focal_error_percent;
  return camera.check();
}

Result<StudiesReport> run_studies(const Case& body,
                                  const RecordedData& data,
                                  const StudiesOptions& options,
                                  const Progress& progress) {
  MOR_CHECK(options.check());
  using Method = RegistrationMethod;
  const Studies studies(body, options, progress);
  const SimulatedCameraOptions plain;
  SimulatedCameraOptions hand;
  hand.clutter = SimulatedClutter::kHand;
  SimulatedCameraOptions parts;
  parts.clutter = SimulatedClutter::kParts;
  SimulatedCameraOptions all;
  all.clutter = SimulatedClutter::kAll;
  SimulatedCameraOptions biased;
  biased.bias_mm = options.bias_mm;
  biased.focal_error_percent = options.focal_error_percent;
  const double first = options.down_samplings.front();
  const auto phantom_methods = with_devices(
      {Method::kIcp, Method::kTrimmedIcp, Method::kAnisotropicIcp, Method::kTrimmedAnisotropicIcp},
      first,
      kLiveDownSampling,
      options.runs_opencl);
  const auto post_mortem_methods =
      with_devices({Method::kTrimmedIcp, Method::kTrimmedAnisotropicIcp},
                   first,
                   kLiveDownSampling,
                   options.runs_opencl);
  const int few = options.num_poses;
  const int many = options.num_many_poses;
  StudiesReport report;
  report.options = options;
  report.case_name = body.name;
  MOR_TRY(report.phantom, studies.study({"phantom", plain, kPhantomMarkers, few}, phantom_methods));
  MOR_TRY(report.post_mortem,
          studies.study({"post-mortem", hand, kPostMortemMarkers, few}, post_mortem_methods));
  MOR_TRY(report.down_sampled,
          down_sampling_studies(
              studies, {"down-sampling", hand, kPostMortemMarkers, few}, options, progress));
  MOR_TRY(report.many_plain,
          studies.study({"many poses", plain, kPhantomMarkers, many}, live_methods()));
  MOR_TRY(report.many_hand,
          studies.study({"many poses, hand", hand, kPostMortemMarkers, many}, live_methods()));
  MOR_TRY(report.many_parts,
          studies.study({"many poses, parts", parts, kPostMortemMarkers, many}, live_methods()));
  MOR_TRY(report.many_cluttered,
          studies.study({"many poses, clutter", all, kPostMortemMarkers, many}, live_methods()));
  MOR_TRY(report.biased,
          studies.study({"biased sensor", biased, kPostMortemMarkers, many}, live_methods()));
  if (!data.folder.empty()) {
    MOR_CHECK(add_recordings(body, data, options, progress, report));
  }
  return report;
}

}  // namespace mor
