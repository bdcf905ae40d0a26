// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/casefile/case.h"
#include "morgagni/core/files.h"
#include "morgagni/core/log.h"
#include "morgagni/core/progress.h"
#include "morgagni/evaluation/recording_evaluation.h"

#include "evaluate/commands.h"
#include "exit.h"
#include "options.h"

namespace mor {
namespace {

const std::map<std::string, TruthFrame> kTruthFrames = {
    {"auto", TruthFrame::kAuto}, {"ct", TruthFrame::kCt}, {"centred", TruthFrame::kCentred}};

struct Arguments {
  std::filesystem::path recording;
  std::filesystem::path folder;
  std::filesystem::path truth;
  std::filesystem::path targets;
  std::filesystem::path json;
  TruthFrame truth_frame = TruthFrame::kAuto;
  EvaluationOptions options;
};

void evaluate(const Arguments& arguments) {
  const auto& options = arguments.options;
  const auto body = value_or_exit(load_case(arguments.folder));
  const auto recording = value_or_exit(TumRecording::open(arguments.recording));
  const auto truth =
      value_or_exit(align_truth_to_case(value_or_exit(read_ground_truth(arguments.truth)),
                                        value_or_exit(read_targets(arguments.targets)),
                                        arguments.truth_frame,
                                        body.skin->field,
                                        body.ct_center_mm,
                                        body.ct_half_voxel_mm));
  if (!truth.warning.empty()) log::warn("{}", truth.warning);
  const auto report = value_or_exit(evaluate_recording(
      recording, body.skin, truth.poses, truth.targets, options, console_progress()));
  fmt::print("{}", to_table(report));
  if (!arguments.json.empty()) value_or_exit(write_file(arguments.json, to_json(report) + "\n"));
}

}  // namespace

void add_evaluate_recording_command(CLI::App& evaluate_app) {
  auto arguments = std::make_shared<Arguments>();
  auto& options = arguments->options;
  auto* command = evaluate_app.add_subcommand(
      "recording", "Target registration error and time over a recording with known truth");
  command->add_option("RECORDING", arguments->recording, "Folder in the TUM RGB-D layout")
      ->required();
  command->add_option("--case", arguments->folder, "Folder that `morgagni prepare` made")
      ->required();
  command
      ->add_option(
          "--truth", arguments->truth, "groundtruth.txt: camera in the CT's world, metres, RAS+")
      ->required();
  command
      ->add_option("--targets", arguments->targets, "targets.csv: name,kind,x_mm,y_mm,z_mm, RAS+")
      ->required();
  command
      ->add_option("--truth-frame",
                   arguments->truth_frame,
                   "World of truth and targets: the CT's own, one with its origin at the centre of "
                   "the CT's volume, or whichever puts the skin targets on the skin")
      ->transform(CLI::CheckedTransformer(kTruthFrames).description("auto, centred or ct"))
      ->default_str("auto");
  add_registration_options(*command, options.registration);
  command->add_option("--json", arguments->json, "Write the report there as well")
      ->type_name("FILE");
  command
      ->add_option("--starts",
                   options.num_starts,
                   "Perturbed starts a frame; 0: each frame from the last pose")
      ->capture_default_str();
  command
      ->add_option("--start-error-mm", options.start_error_mm, "Largest shift of a perturbed start")
      ->capture_default_str();
  command->add_option("--start-error-deg", options.start_error_deg, "Its largest rotation")
      ->capture_default_str();
  command->add_flag_callback(
      "--tracked",
      [arguments] { arguments->options.start_quality = StartQuality::kTracked; },
      "The perturbed starts are as near as a tracked frame's last pose");
  command->add_option("--seed", options.seed, "Of the perturbed starts")->capture_default_str();
  command->add_option("--max-iterations", options.registration.max_iterations, "Of the icp methods")
      ->capture_default_str();
  command->add_option("--overlap", options.registration.overlap, "trimmed: share of the pairs kept")
      ->capture_default_str();
  add_depth_options(*command, options.depth);
  command->footer(
      "Example:\n"
      "  morgagni evaluate recording recordings/head --case cases/head --truth "
      "recordings/head/groundtruth.txt\n"
      "      --targets recordings/head/targets.csv --method trimmed-icp --starts 20 --json "
      "head.json");
  command->callback([arguments] { evaluate(*arguments); });
}

}  // namespace mor
