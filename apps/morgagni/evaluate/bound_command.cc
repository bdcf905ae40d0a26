// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/casefile/case.h"
#include "morgagni/core/files.h"
#include "morgagni/core/progress.h"
#include "morgagni/evaluation/bound_calibration.h"

#include "evaluate/commands.h"
#include "exit.h"
#include "options.h"

namespace mor {
namespace {

struct Arguments {
  std::vector<std::filesystem::path> folders;
  std::filesystem::path out;
  bool fits = false;
  BoundStudyOptions options;
};

/// What each body is shown with, after its name.
struct Shown {
  const char* name;
  const char* camera;
  double bias_mm = 0.0;
};
constexpr Shown kShown[] = {
    {"", "path=views"},
    {" + clutter", "path=views,clutter=all"},
    {", on a path", "path=orbit"},
    {" + clutter, on a path", "path=orbit,clutter=all"},
    {", bias 1 mm", "path=views,bias=1", 1.0},
    {", bias 3 mm", "path=views,bias=3", 3.0},
};

void evaluate(const Arguments& arguments) {
  if (!arguments.out.empty()) make_folder_or_exit(arguments.out);
  std::vector<BoundGroup> groups;
  for (const auto& folder : arguments.folders) {
    const auto body = value_or_exit(load_case(folder));
    for (const auto& [name, camera, bias_mm] : kShown) {
      groups.push_back({body.name + name, body.skin, camera, bias_mm});
    }
  }
  const auto runs = value_or_exit(run_bound_study(groups, arguments.options, console_progress()));
  const auto calibration =
      arguments.fits ? fit_bound_calibration(runs) : default_bound_calibration();
  const auto lines = bound_coverage(runs, calibration);
  fmt::print(
      "calibration: correlated_readings {:.4g}, clutter_growth {:.4g}, systematic_mm {:.4g}, "
      "floor_mm {:.4g}{}\n\n",
      calibration.correlated_readings,
      calibration.clutter_growth,
      calibration.systematic_mm,
      calibration.floor_mm,
      arguments.fits ? " (fitted to this run)" : "");
  fmt::print("{}\n", to_markdown(lines));
  for (std::size_t i = 0; i < groups.size(); ++i) {
    fmt::print(
        "{}: {} of {} frames refused\n", groups[i].name, runs.num_not_found[i], runs.num_frames[i]);
  }
  if (arguments.out.empty()) return;
  value_or_exit(write_file(arguments.out / "bound.md", to_markdown(lines)));
  value_or_exit(write_file(arguments.out / "bound.json",
                           to_json(lines, runs, arguments.options, calibration) + "\n"));
  value_or_exit(write_file(arguments.out / "bound.csv", to_csv(runs, calibration)));
}

}  // namespace

void add_evaluate_bound_command(CLI::App& evaluate_app) {
  auto arguments = std::make_shared<Arguments>();
  auto& options = arguments->options;
  auto* command = evaluate_app.add_subcommand(
      "bound", "How often the error bound holds, over the simulated camera's frames");
  command->add_option("--case", arguments->folders, "Folders that `morgagni prepare` made")
      ->required();
  command->add_option("--first-seed", options.first_seed, "2000 to 2059: what it was fitted on")
      ->capture_default_str();
  command->add_option("--seeds", options.num_seeds, "A body and kind of scene")
      ->capture_default_str();
  command->add_option("--frames", options.num_frames, "A seed")->capture_default_str();
  command->add_flag("--fit", arguments->fits, "Fit the calibration to these frames first");
  command->add_option("--out", arguments->out, "Write bound.md, bound.json and bound.csv there")
      ->type_name("DIR");
  add_depth_options(*command, options.depth);
  command->footer(
      "Examples:\n"
      "  morgagni evaluate bound --case cases/head cases/torso --out bound\n"
      "  morgagni evaluate bound --case cases/head cases/torso --first-seed 2000 --seeds 60 --fit");
  command->callback([arguments] { evaluate(*arguments); });
}

}  // namespace mor
