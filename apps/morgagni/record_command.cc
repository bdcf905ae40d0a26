// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/simulated_camera.h"
#include "morgagni/camera/tum_recorder.h"
#include "morgagni/casefile/case.h"
#include "morgagni/core/progress.h"
#include "morgagni/evaluation/target_sampling.h"

#include "commands.h"
#include "exit.h"
#include "options.h"

namespace mor {
namespace {

struct Arguments {
  std::filesystem::path folder;
  std::filesystem::path out;
  std::string camera = "simulated:";
  int num_frames = 150;
  int num_targets = 0;
  std::uint64_t targets_seed = 1;
};

constexpr int kMaxFrames = 100000;
constexpr int kMaxTargets = 1000;

/// As many on the upper skin as inside, so that `evaluate recording` can measure.
void add_targets(const Arguments& arguments, const TriangleMesh& skin, TumRecorder& recorder) {
  auto targets =
      value_or_exit(sample_skin_targets(skin, arguments.num_targets, arguments.targets_seed));
  for (const auto& target : value_or_exit(
           sample_internal_targets(skin, arguments.num_targets, arguments.targets_seed))) {
    targets.push_back(target);
  }
  value_or_exit(recorder.add_file("targets.csv", targets_csv(targets)));
}

/// The simulated camera is recorded frame by frame, not in real time: none is missed, and the truth
/// is known.
void record(const Arguments& arguments) {
  const auto body = value_or_exit(load_case(arguments.folder));
  const auto skin = std::shared_ptr<const TriangleMesh>(body.skin, &body.skin->mesh);
  const auto options = value_or_exit(simulated_camera_option(arguments.camera));
  const auto camera = value_or_exit(SimulatedCamera::create(skin, options));
  auto recorder = value_or_exit(TumRecorder::create(arguments.out));
  if (arguments.num_targets > 0) add_targets(arguments, *skin, recorder);
  const auto progress = console_progress();
  for (int i = 0; i < arguments.num_frames; ++i) {
    const auto frame_id = static_cast<std::uint64_t>(i);
    const double timestamp_s = i / options.frames_per_s;
    value_or_exit(
        recorder.add(*camera->frame_at(frame_id), timestamp_s, camera->ct_from_camera(frame_id)));
    progress("record", static_cast<double>(i + 1) / arguments.num_frames);
  }
  value_or_exit(recorder.finish());
  fmt::print("{}: {} frames with their true poses\n", arguments.out.string(), arguments.num_frames);
}

}  // namespace

void add_record_command(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  auto* command = app.add_subcommand(
      "record", "Write a simulated camera's frames and true poses as a TUM recording");
  command->add_option("--case", arguments->folder, "Folder that `morgagni prepare` made")
      ->required();
  command->add_option("--out", arguments->out, "New folder of the recording")->required();
  command->add_option("--camera", arguments->camera, "simulated:[key=value,...]")
      ->capture_default_str();
  command->add_option("--frames", arguments->num_frames, "How many")
      ->capture_default_str()
      ->check(CLI::Range(1, kMaxFrames));
  command
      ->add_option("--targets",
                   arguments->num_targets,
                   "Write targets.csv too: so many places on the skin and as many inside the body")
      ->capture_default_str()
      ->check(CLI::Range(0, kMaxTargets));
  command->add_option("--targets-seed", arguments->targets_seed, "Of those places")
      ->capture_default_str();
  command->footer(
      "Keys of the simulated camera:\n"
      "  seed=1  width=640  height=480  fps=30  noise=0|1  distance=MM\n"
      "  path=orbit|sway|still  a hand or a tripod before the body\n"
      "  path=views             every frame from a random place of its own above the table\n"
      "  clutter=none|hand|towel|parts|all  what the CT does not have, in depth and colour\n"
      "  bias=MM                smooth systematic depth error, root mean square at 800 mm\n"
      "  focal=PERCENT          the calibration's focal length is so much too long\n"
      "\n"
      "Examples:\n"
      "  morgagni record --case cases/head --camera simulated:seed=7 --frames 300 --out "
      "recordings/head-7\n"
      "  morgagni record --case cases/head --camera simulated:path=views,clutter=hand,bias=3\n"
      "      --frames 100 --targets 16 --out recordings/head-views");
  command->callback([arguments] { record(*arguments); });
}

}  // namespace mor
