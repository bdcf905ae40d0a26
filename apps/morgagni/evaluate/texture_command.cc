// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/casefile/case.h"
#include "morgagni/core/files.h"
#include "morgagni/core/image_png.h"
#include "morgagni/core/progress.h"
#include "morgagni/documentation/skin_texture_io.h"
#include "morgagni/documentation/texture_view.h"
#include "morgagni/evaluation/texture_evaluation.h"

#include "evaluate/commands.h"
#include "exit.h"
#include "options.h"

namespace mor {
namespace {

struct Arguments {
  std::filesystem::path folder;
  std::filesystem::path out;
  bool holds_poses = false;
  TextureStudyOptions options;
};

void evaluate(const Arguments& arguments) {
  if (!arguments.out.empty()) make_folder_or_exit(arguments.out);
  const auto body = value_or_exit(load_case(arguments.folder));
  auto options = arguments.options;
  options.fusion.aligns_frames = !arguments.holds_poses;
  const auto study = value_or_exit(run_texture_study(body.skin, options, console_progress()));
  fmt::print("{}", to_markdown(study));
  if (arguments.out.empty()) return;
  constexpr int kSideWidthPx = 480;
  constexpr int kSideHeightPx = 520;
  value_or_exit(write_file(arguments.out / "texture.md", to_markdown(study)));
  value_or_exit(write_skin_texture(arguments.out / "texture", study.texture));
  value_or_exit(write_file(arguments.out / "truth.png", encode_png(study.truth.view())));
  value_or_exit(
      write_file(arguments.out / "sides.png",
                 encode_png(draw_four_sides(study.texture, kSideWidthPx, kSideHeightPx).view())));
  auto truth = study.texture;
  truth.color = study.truth;
  value_or_exit(write_file(arguments.out / "truth_sides.png",
                           encode_png(draw_four_sides(truth, kSideWidthPx, kSideHeightPx).view())));
}

}  // namespace

void add_evaluate_texture_command(CLI::App& evaluate_app) {
  auto arguments = std::make_shared<Arguments>();
  auto& options = arguments->options;
  auto* command = evaluate_app.add_subcommand(
      "texture", "The fused texture against the simulated skin's own paint");
  command->add_option("--case", arguments->folder, "A folder that `morgagni prepare` made")
      ->required();
  command->add_option("--camera", options.camera, "Keys of the simulated camera")
      ->capture_default_str();
  command->add_option("--seed", options.seed, "Of the camera")->capture_default_str();
  command->add_option("--frames", options.num_frames, "That the camera sends")
      ->capture_default_str();
  command->add_option("--fuse-every", options.fuse_every, "One of so many frames is melted")
      ->capture_default_str();
  command
      ->add_option("--clutter-period",
                   options.clutter_period,
                   "The clutter is there in the second half of so many frames; 0: always")
      ->capture_default_str();
  command->add_option("--px-per-mm", options.atlas.px_per_mm, "Of the atlas")
      ->capture_default_str();
  command->add_flag("--hold-poses",
                    arguments->holds_poses,
                    "Melt frames where the tracker puts them, without aligning them");
  command->add_option("--out", arguments->out, "Write the texture, the truth and pictures there")
      ->type_name("DIR");
  command->footer(
      "Example:\n"
      "  morgagni evaluate texture --case cases/head --out texture-head");
  command->callback([arguments] { evaluate(*arguments); });
}

}  // namespace mor
