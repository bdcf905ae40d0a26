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
};

constexpr int kMaxFrames = 100000;

/// The simulated camera is recorded frame by frame, not in real time: none is missed, and the truth
/// is known.
void record(const Arguments& arguments) {
  const auto body = value_or_exit(load_case(arguments.folder));
  const auto skin = std::shared_ptr<const TriangleMesh>(body.skin, &body.skin->mesh);
  const auto options = value_or_exit(simulated_camera_option(arguments.camera));
  const auto camera = value_or_exit(SimulatedCamera::create(skin, options));
  auto recorder = value_or_exit(TumRecorder::create(arguments.out));
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
  command->footer(
      "Example:\n"
      "  morgagni record --case cases/head --camera simulated:seed=7 --frames 300 --out "
      "recordings/head-7");
  command->callback([arguments] { record(*arguments); });
}

}  // namespace mor
