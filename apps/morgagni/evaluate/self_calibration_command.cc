// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/casefile/case.h"
#include "morgagni/core/files.h"
#include "morgagni/core/progress.h"
#include "morgagni/evaluation/self_calibration_evaluation.h"
#include "morgagni/evaluation/summary.h"

#include "evaluate/commands.h"
#include "exit.h"
#include "options.h"

namespace mor {
namespace {

struct Arguments {
  std::vector<std::filesystem::path> folders;
  std::filesystem::path recording;
  std::filesystem::path out;
  std::string only;
  SelfCalibrationStudyOptions options;
};

/// What each body is shown with, after its name.
struct Shown {
  const char* name;
  const char* camera;
  AddedBias added = AddedBias::kNone;
  double added_mm = 0.0;
  double changed_skin_mm = 0.0;
  std::optional<PinholeSd> pinhole_sd = std::nullopt;
};
/// As `morgagni calibrate` says at best that it knows a pinhole.
constexpr PinholeSd kCalibrated{.focal_ratio = 0.001, .center_px = 0.2};
constexpr Shown kShown[] = {
    {", no bias, bare", "table=1,path=sweep"},
    {", no bias, hand", "table=1,path=sweep,clutter=hand"},
    {", no bias, all clutter", "table=1,path=sweep,clutter=all"},
    {", no bias, small motion", "table=1,path=orbit"},
    {", no bias, skin changed 1 mm", "table=1,path=sweep", AddedBias::kNone, 0.0, 1.0},
    {", bias 3 mm, bare", "table=1,path=sweep,bias=3"},
    {", bias 5 mm", "table=1,path=sweep,bias=5"},
    {", bias 3 mm, views all around", "table=1,path=views,bias=3"},
    {", bias 3 mm, small motion", "table=1,path=orbit,bias=3"},
    {", bias 3 mm, hand", "table=1,path=sweep,bias=3,clutter=hand"},
    {", fixed bias 3 mm", "table=1,path=sweep", AddedBias::kFixed, 3.0},
    {", square bias 3 mm", "table=1,path=sweep", AddedBias::kSquare, 3.0},
    {", bias 3 mm, focal 1 %", "table=1,path=sweep,bias=3,focal=1"},
    {", bias 3 mm, skin changed 1 mm", "table=1,path=sweep,bias=3", AddedBias::kNone, 0.0, 1.0},
    {", calibrated, no bias", "table=1,path=sweep", AddedBias::kNone, 0.0, 0.0, kCalibrated},
    {", calibrated, bias 3 mm",
     "table=1,path=sweep,bias=3",
     AddedBias::kNone,
     0.0,
     0.0,
     kCalibrated},
    {", calibrated, bias 3 mm, small motion",
     "table=1,path=orbit,bias=3",
     AddedBias::kNone,
     0.0,
     0.0,
     kCalibrated},
    {", calibrated, fixed bias 3 mm",
     "table=1,path=sweep",
     AddedBias::kFixed,
     3.0,
     0.0,
     kCalibrated},
    {", calibrated, square bias 3 mm",
     "table=1,path=sweep",
     AddedBias::kSquare,
     3.0,
     0.0,
     kCalibrated},
};

/// The recorded sensor over the same body in motion; the error at simulated frames and at the
/// recording's own.
void add_recorded(const Case& body,
                  const std::filesystem::path& folder,
                  const BodySurfaceOptions& depth,
                  std::vector<SelfCalibrationGroup>& groups) {
  const auto recorded =
      std::make_shared<const RecordedFrames>(value_or_exit(load_recorded_frames(folder, body)));
  const auto bias =
      std::make_shared<const RecordedBias>(value_or_exit(measure_bias(body.skin->mesh, *recorded)));
  fmt::print(
      "{}: {} blocks of readings in {} frames lie {:.2f} mm off the skin at the true poses; less a "
      "smooth error of the sensor that {}, {:.2f} mm; less a change of the body since its CT "
      "({:.2f} "
      "mm, root mean square) as well, {:.2f} mm\n",
      folder.string(),
      bias->num_readings,
      recorded->frames.size(),
      bias->before_mm,
      bias->is_growing ? "grows with the distance" : "is the same at each distance",
      bias->without_adds_mm,
      bias->body_mm,
      bias->after_mm);
  const auto limit = value_or_exit(recorded_limit(body.skin, *recorded, *bias, depth));
  fmt::print(
      "mean TRE at its frames: {:.2f} mm, {:.2f} mm less the sensor's error as they show it by the "
      "truth, {:.2f} mm against the changed body as well\n",
      summarize(limit.as_it_is_mm).mean,
      summarize(limit.without_error_mm).mean,
      summarize(limit.with_body_mm).mean);
  for (const bool is_calibrated : {false, true}) {
    SelfCalibrationGroup group{
        body.name + (is_calibrated ? ", calibrated" : "") + ", recorded bias",
        body.skin,
        "table=1,path=sweep"};
    if (is_calibrated) group.pinhole_sd = kCalibrated;
    group.recorded = bias;
    groups.push_back(group);
    group.name += ", at the recorded frames";
    group.held = recorded;
    groups.push_back(group);
  }
}

void evaluate(const Arguments& arguments) {
  if (!arguments.out.empty()) make_folder_or_exit(arguments.out);
  std::vector<SelfCalibrationGroup> groups;
  for (const auto& folder : arguments.folders) {
    const auto body = value_or_exit(load_case(folder));
    if (!arguments.recording.empty()) {
      add_recorded(body, arguments.recording, arguments.options.depth, groups);
      continue;
    }
    for (const auto& shown : kShown) {
      groups.push_back({body.name + shown.name,
                        body.skin,
                        shown.camera,
                        shown.added,
                        shown.added_mm,
                        shown.changed_skin_mm,
                        shown.pinhole_sd});
    }
  }
  std::erase_if(groups, [&arguments](const SelfCalibrationGroup& group) {
    return group.name.find(arguments.only) == std::string::npos;
  });
  const auto runs =
      value_or_exit(run_self_calibration_study(groups, arguments.options, console_progress()));
  fmt::print("{}\n", to_markdown(groups, runs));
  if (arguments.out.empty()) return;
  value_or_exit(write_file(arguments.out / "self-calibration.md", to_markdown(groups, runs)));
  value_or_exit(write_file(arguments.out / "self-calibration.json",
                           to_json(groups, runs, arguments.options) + "\n"));
}

}  // namespace

void add_evaluate_self_calibration_command(CLI::App& evaluate_app) {
  auto arguments = std::make_shared<Arguments>();
  auto& options = arguments->options;
  auto* command = evaluate_app.add_subcommand(
      "self-calibration",
      "How much nearer the body's points come when the sensor's error is found on the CT skin");
  command->add_option("--case", arguments->folders, "Folders that `morgagni prepare` made")
      ->required();
  command->add_option("--first-seed", options.first_seed, "Below 1000: what it was set on")
      ->capture_default_str();
  command->add_option("--seeds", options.num_seeds, "A body and kind of scene")
      ->capture_default_str();
  command->add_option("--views", options.num_views, "That the estimate sees")
      ->capture_default_str();
  command->add_option("--held", options.num_held, "Frames at which the error is measured")
      ->capture_default_str();
  command
      ->add_option(
          "--only", arguments->only, "Scenes with these words in their name, \"fixed bias\"")
      ->type_name("WORDS");
  command
      ->add_option(
          "--recording",
          arguments->recording,
          "In place of the scenes: a TUM folder with groundtruth.txt and targets.csv of the "
          "same body by a sensor that errs; its error is measured at the true poses, given "
          "to the simulated camera, found without the truth, and removed from the "
          "recording's frames")
      ->type_name("DIR");
  command->add_option("--out", arguments->out, "Write self-calibration.md and .json there")
      ->type_name("DIR");
  add_depth_options(*command, options.depth);
  command->footer(
      "Example:\n"
      "  morgagni evaluate self-calibration --case cases/head cases/torso --seeds 5 --out found\n"
      "  morgagni evaluate self-calibration --case cases/head --recording "
      "recordings/head_clutter_real");
  command->callback([arguments] { evaluate(*arguments); });
}

}  // namespace mor
