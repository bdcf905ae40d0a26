// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/simulated_camera.h"
#include "morgagni/camera/tum_recording.h"
#include "morgagni/casefile/case.h"
#include "morgagni/core/files.h"
#include "morgagni/core/progress.h"
#include "morgagni/evaluation/ground_truth.h"
#include "morgagni/evaluation/start_evaluation.h"
#include "morgagni/geometry/depth_levels.h"

#include "evaluate/commands.h"
#include "exit.h"
#include "options.h"

namespace mor {
namespace {

struct Arguments {
  std::filesystem::path folder;
  std::string camera;
  std::filesystem::path recording;
  std::filesystem::path other_folder;
  bool mirrors = false;
  std::filesystem::path targets;
  std::filesystem::path json;
  std::size_t num_views = 500;
  StartEvaluationOptions options;
};

constexpr std::size_t kMaxViews = 100000;
constexpr std::size_t kMaxFrames = 100;

/// As in a mirror: left is right.
std::shared_ptr<const TriangleMesh> mirrored(const TriangleMesh& mesh) {
  auto other = std::make_shared<TriangleMesh>(mesh);
  const float twice_middle = 2.0F * mesh.bounds().center().x();
  for (auto& vertex : other->vertices) vertex.x() = twice_middle - vertex.x();
  for (auto& normal : other->normals) normal.x() = -normal.x();
  for (auto& triangle : other->triangles) std::swap(triangle[1], triangle[2]);
  return other;
}

/// What the simulated camera looks at.
std::shared_ptr<const TriangleMesh> scene_of(const Arguments& arguments, const Case& body) {
  const Case other =
      arguments.other_folder.empty() ? body : value_or_exit(load_case(arguments.other_folder));
  if (arguments.mirrors) return mirrored(other.skin->mesh);
  return {other.skin, &other.skin->mesh};
}

StartReport evaluate_simulated(const Arguments& arguments, const Case& body) {
  const std::size_t num_frames = arguments.options.frames_a_view;
  auto options = value_or_exit(simulated_camera_option(arguments.camera));
  if (num_frames > 1) {
    options.frames_a_view = num_frames;
    options.frames_per_s = 1e3 / arguments.options.frame_period_ms;
  }
  const auto camera = value_or_exit(SimulatedCamera::create(scene_of(arguments, body), options));
  const bool is_other = arguments.mirrors || !arguments.other_folder.empty();
  const auto views = [&](std::size_t i, std::size_t frame) -> Result<StartView> {
    const std::size_t id = i * num_frames + frame;
    StartView view{camera->frame_at(id), std::nullopt};
    if (!is_other) view.ct_from_depth = camera->ct_from_camera(id);
    return view;
  };
  return value_or_exit(evaluate_starts(
      views, arguments.num_views, body.skin, arguments.options, console_progress()));
}

StartReport evaluate_recorded(const Arguments& arguments, const Case& body) {
  const auto recording = value_or_exit(TumRecording::open(arguments.recording));
  const auto truth = value_or_exit(
      align_truth_to_case(value_or_exit(read_ground_truth(arguments.recording / "groundtruth.txt")),
                          value_or_exit(read_targets(arguments.recording / "targets.csv")),
                          TruthFrame::kAuto,
                          body.skin->field,
                          body.ct_center_mm,
                          body.ct_half_voxel_mm));
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < recording.size() && known.size() < arguments.num_views; ++i) {
    if (truth_at(truth.poses, recording.timestamp_s(i))) known.push_back(i);
  }
  DepthLevels levels;
  const auto views = [&](std::size_t i, std::size_t /*frame*/) -> Result<StartView> {
    MOR_TRY(auto frame, recording.read(known[i]));
    return StartView{depth_corrected(std::move(frame), levels),
                     *truth_at(truth.poses, recording.timestamp_s(known[i]))};
  };
  return value_or_exit(
      evaluate_starts(views, known.size(), body.skin, arguments.options, console_progress()));
}

void evaluate(const Arguments& arguments) {
  const auto body = value_or_exit(load_case(arguments.folder));
  const StartReport report = arguments.recording.empty() ? evaluate_simulated(arguments, body)
                                                         : evaluate_recorded(arguments, body);
  fmt::print("{}", to_table(report));
  if (!arguments.json.empty()) value_or_exit(write_file(arguments.json, to_json(report) + "\n"));
}

}  // namespace

void add_evaluate_starts_command(CLI::App& evaluate_app) {
  auto arguments = std::make_shared<Arguments>();
  auto& options = arguments->options;
  auto* command = evaluate_app.add_subcommand(
      "starts", "How often the automatic start is right, wrong or refused, and how long it takes");
  command->add_option("--case", arguments->folder, "Folder that `morgagni prepare` made")
      ->required();
  auto* camera = command
                     ->add_option("--camera",
                                  arguments->camera,
                                  "simulated:[key=value,...]; path=views: every view for itself")
                     ->default_str("simulated:path=views,seed=1000");
  arguments->camera = "simulated:path=views,seed=1000";
  auto* recording =
      command
          ->add_option("--recording",
                       arguments->recording,
                       "In place of a camera: folder in the TUM RGB-D layout with groundtruth.txt "
                       "and targets.csv")
          ->excludes(camera);
  auto* other_body =
      command
          ->add_option(
              "--other-body",
              arguments->other_folder,
              "Case whose body the simulated camera sees in place of this one's: every start "
              "that is found is wrong")
          ->excludes(recording);
  auto* mirrored =
      command
          ->add_flag(
              "--mirrored",
              arguments->mirrors,
              "The simulated camera sees the body's mirror image: every start that is found is "
              "wrong")
          ->excludes(recording);
  command->add_option("--views", arguments->num_views, "How many, each a start of its own")
      ->capture_default_str()
      ->check(CLI::Range(std::size_t{1}, kMaxViews));
  command
      ->add_option("--frames",
                   options.frames_a_view,
                   "Pictures that each start may take, 0.2 s apart: a hand holds the simulated "
                   "camera at each view and drifts by 50 to 100 mm in 1.5 s")
      ->capture_default_str()
      ->check(CLI::Range(std::size_t{1}, kMaxFrames))
      ->excludes(recording);
  command->add_option("--threads", options.start.num_threads, "Of the automatic start")
      ->capture_default_str();
  // Down is told by the camera's true pose in this case's CT.
  command->add_flag("--gravity", options.knows_gravity, "The camera knows which way is down")
      ->excludes(other_body)
      ->excludes(mirrored);
  command->add_option("--json", arguments->json, "Write the report there as well")
      ->type_name("FILE");
  command->footer(
      "Example:\n"
      "  morgagni evaluate starts --case cases/head --camera "
      "simulated:path=views,clutter=all,seed=1000\n"
      "      --views 500 --json head.json");
  command->callback([arguments] { evaluate(*arguments); });
}

}  // namespace mor
