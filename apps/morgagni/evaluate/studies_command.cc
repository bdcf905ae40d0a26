// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/casefile/case.h"
#include "morgagni/compute/compute_device.h"
#include "morgagni/core/files.h"
#include "morgagni/core/pending_folder.h"
#include "morgagni/core/progress.h"
#include "morgagni/evaluation/studies.h"
#include "morgagni/evaluation/studies_markdown.h"
#include "morgagni/evaluation/study_plots.h"

#include "evaluate/commands.h"
#include "exit.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  fs::path folder;
  fs::path out;
  fs::path data;
  std::vector<fs::path> more_folders;
  bool no_opencl = false;
  bool quick = false;
  StudiesOptions options;
};

/// The processor's name as the kernel has it and how many of it; the OpenCL device used.
std::string this_machine() {
  std::ifstream info("/proc/cpuinfo");
  std::string name = "an unknown processor";
  for (std::string line; std::getline(info, line);) {
    if (!line.starts_with("model name")) continue;
    name = line.substr(std::min(line.find(": ") + 2, line.size()));
    break;
  }
  std::string machine = fmt::format("{} x {}", std::thread::hardware_concurrency(), name);
  const auto devices = list_compute_devices();
  if (!devices.empty()) {
    machine += fmt::format(", OpenCL on {} ({})", devices.front().name, devices.front().platform);
  }
  return machine;
}

/// An older report there is replaced in one step; anything else is not touched.
Result<void> check_out(const fs::path& out) {
  std::error_code status;
  if (!fs::exists(out, status) || fs::is_empty(out, status)) return {};
  if (fs::exists(out / "studies.json", status)) return {};
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format("{}: exists and holds no studies, give another --out", out.string()));
}

Result<void> write_report(const fs::path& out, const StudiesReport& report) {
  MOR_TRY(auto pending, PendingFolder::create(out));
  MOR_CHECK(write_file(pending.path() / "studies.md", to_markdown(report, this_machine())));
  MOR_CHECK(write_file(pending.path() / "studies.json", to_json(report) + "\n"));
  for (const auto& plot : study_plots(report)) {
    MOR_CHECK(write_file(pending.path() / plot.file_name, plot.svg));
  }
  return pending.commit();
}

void evaluate(Arguments& arguments) {
  auto& options = arguments.options;
  options.runs_opencl = !arguments.no_opencl;
  if (arguments.quick) {
    options.num_poses = std::min(options.num_poses, 1);
    options.num_many_poses = std::min(options.num_many_poses, 2);
    options.down_samplings = {2.5, 4.0};
  }
  const auto body = value_or_exit(load_case(arguments.folder));
  value_or_exit(check_out(arguments.out));
  RecordedData data{arguments.data, {}};
  for (const auto& folder : arguments.more_folders) {
    data.bodies.push_back(value_or_exit(load_case(folder)));
  }
  const auto report = value_or_exit(run_studies(body, data, options, console_progress()));
  value_or_exit(write_report(arguments.out, report));
  fmt::print("{}\n", (arguments.out / "studies.md").string());
}

void add_error_options(CLI::App& command, StudiesOptions& options) {
  command
      .add_option("--tag-px",
                  options.tagging.marker_px,
                  "Simulated tagging of markers in the colour picture: SD each way; 0: exact")
      ->capture_default_str();
  command.add_option("--tag-ct-mm", options.tagging.marker_ct_mm, "The same in the CT")
      ->capture_default_str();
  command
      .add_option("--landmark-mm",
                  options.tagging.landmark_mm,
                  "Simulated picking of a start's four landmarks: SD each way")
      ->capture_default_str();
  command.add_option("--bias-mm", options.bias_mm, "Depth error of the study of a biased sensor")
      ->capture_default_str();
  command
      .add_option(
          "--focal-percent", options.focal_error_percent, "Error of the focal length in the same")
      ->capture_default_str();
}

}  // namespace

void add_evaluate_studies_command(CLI::App& evaluate_app) {
  auto arguments = std::make_shared<Arguments>();
  auto& options = arguments->options;
  auto* command = evaluate_app.add_subcommand(
      "studies", "The paper's studies over a simulated camera: tables, plots, beside its figures");
  command->add_option("--case", arguments->folder, "Folder that `morgagni prepare` made")
      ->required();
  command
      ->add_option("--out",
                   arguments->out,
                   "Folder of the report: studies.md, studies.json, *.svg; an older report there "
                   "is replaced")
      ->required();
  command->add_option(
      "--data", arguments->data, "Folder with recordings: those named *_real are evaluated too");
  command->add_option(
      "--more-cases", arguments->more_folders, "Further cases whose bodies those recordings show");
  command->add_option("--seed", options.seed, "Of poses, noise, clutter, markers and tagging")
      ->capture_default_str();
  command->add_option("--poses", options.num_poses, "Of tables 1 to 3; the paper's: 5")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  command->add_option("--many-poses", options.num_many_poses, "Of the studies with more poses")
      ->capture_default_str()
      ->check(CLI::Range(1, 10000));
  add_error_options(*command, options);
  command->add_flag("--no-opencl", arguments->no_opencl, "The paper's methods on the CPU only");
  command->add_flag("--quick",
                    arguments->quick,
                    "A trial run: one pose a table, two of the many, two rows of down-sampling");
  command->footer(
      "Examples:\n"
      "  morgagni evaluate studies --case cases/chest --out studies\n"
      "  morgagni evaluate studies --case cases/chest --data ../shared/data/synthetic_rgbd "
      "--more-cases cases/head\n"
      "      --out studies\n"
      "  morgagni evaluate studies --case cases/chest --quick --no-opencl --out trial");
  command->callback([arguments] { evaluate(*arguments); });
}

}  // namespace mor
