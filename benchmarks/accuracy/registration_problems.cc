// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// The Morgagni side of the comparison in peers/: writes the problems that every method gets, and
// answers with Morgagni's own methods.
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/tum_recording.h"
#include "morgagni/casefile/case.h"
#include "morgagni/depth/body_surface.h"
#include "morgagni/geometry/depth_levels.h"
#include "morgagni/registration/automatic_start.h"
#include "morgagni/registration/fine_registration.h"
#include "morgagni/registration/visible_place.h"

#include "peers/answering.h"
#include "peers/problem.h"
#include "problem_export.h"

namespace mor::peers {
namespace {

template <class T>
T value_or_throw(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

/// Fine registration by one of our methods.
class OwnMethod : public Method {
 public:
  OwnMethod(std::shared_ptr<const FixedSurface> fixed,
            RegistrationMethod method,
            StartQuality start_quality)
      : registration_(value_or_throw(make_fine_registration(std::move(fixed), {.method = method}))),
        start_quality_(start_quality) {}

  void set_moving(const TriangleMesh& moving) override { moving_ = to_point_cloud(moving); }

  std::optional<Eigen::Isometry3d> align(const Eigen::Isometry3d& fixed_from_moving_init) override {
    return value_or_throw(registration_->align(moving_, fixed_from_moving_init, start_quality_))
        .fixed_from_moving;
  }

 private:
  std::unique_ptr<FineRegistration> registration_;
  StartQuality start_quality_;
  PointCloud moving_;
};

/// The automatic start on the depth picture, then fine registration of what is cut out there.
class OwnAutomaticStart : public Method {
 public:
  OwnAutomaticStart(std::shared_ptr<const FixedSurface> fixed,
                    const std::filesystem::path& recording)
      : recording_(value_or_throw(TumRecording::open(recording))),
        fixed_(std::move(fixed)),
        start_(value_or_throw(
            AutomaticStart::create(fixed_, recording_.calibration()->depth, {.num_threads = 1}))),
        extractor_(
            value_or_throw(BodySurfaceExtractor::create(recording_.calibration()->depth, {}))),
        registration_(value_or_throw(make_fine_registration(fixed_, {}))) {}

  void set_frame(const ProblemFrame& frame) override {
    picture_ = depth_corrected(value_or_throw(recording_.read(frame.recording_frame)), levels_);
  }
  void set_moving(const TriangleMesh& /*cut out at the truth*/) override {}

  std::optional<Eigen::Isometry3d> align(const Eigen::Isometry3d& /*none*/) override {
    const auto found = value_or_throw(start_.find(picture_->depth_mm.view()));
    if (found.status != AutomaticStartStatus::kFound) return std::nullopt;
    const auto body = value_or_throw(extractor_.extract(
        picture_->depth_mm.view(), places_facing_camera(fixed_->mesh, found.ct_from_depth)));
    return value_or_throw(
               registration_->align(body.cloud, found.ct_from_depth, StartQuality::kRough))
        .fixed_from_moving;
  }

 private:
  TumRecording recording_;
  std::shared_ptr<const FixedSurface> fixed_;
  AutomaticStart start_;
  BodySurfaceExtractor extractor_;
  std::unique_ptr<FineRegistration> registration_;
  DepthLevels levels_;
  std::shared_ptr<const RgbdFrame> picture_;
};

struct Arguments {
  std::filesystem::path folder;
  std::filesystem::path problems;
  std::filesystem::path recording;
  ExportOptions options;
};

int answer(const Arguments& arguments) {
  const Case body = value_or_throw(load_case(arguments.folder));
  const ProblemSet problems = value_or_throw(read_problems(arguments.problems));
  const auto start_quality = problems.is_tracked ? StartQuality::kTracked : StartQuality::kRough;
  MethodMakers makers;
  for (const auto method :
       {RegistrationMethod::kField, RegistrationMethod::kIcp, RegistrationMethod::kTrimmedIcp}) {
    makers.emplace(to_string(method), [&body, method, start_quality] {
      return std::make_unique<OwnMethod>(body.skin, method, start_quality);
    });
  }
  makers.emplace("automatic-start", [&] {
    return std::make_unique<OwnAutomaticStart>(body.skin, problems.recording);
  });
  return answer_requests(problems, makers);
}

void add_export_options(CLI::App& command, ExportOptions& options) {
  static const std::map<std::string, StartKind> kStarts = {
      {"rough", StartKind::kRough}, {"tracked", StartKind::kTracked}, {"none", StartKind::kNone}};
  command.add_option("--start", options.start, "rough, tracked or none")
      ->transform(CLI::CheckedTransformer(kStarts))
      ->default_str("rough");
  command.add_option("--frames", options.num_frames)->check(CLI::Range(1, 1000));
  command.add_option("--starts", options.num_starts)->check(CLI::Range(1, 1000));
  command.add_option("--start-error-mm", options.start_error_mm);
  command.add_option("--start-error-deg", options.start_error_deg);
  command.add_option("--seed", options.seed);
}

int run(int argc, char** argv) {
  CLI::App app("Problems for the comparison with other libraries");
  app.require_subcommand(1);
  Arguments arguments;
  auto* write = app.add_subcommand("export", "Write the problems of a recording");
  auto* write_exact = app.add_subcommand(
      "export-exact", "Write problems whose moving clouds are parts of the skin");
  auto* serve = app.add_subcommand("answer", "Register on request, see peers/answering.h");
  for (auto* command : {write, write_exact, serve}) {
    command->add_option("PROBLEMS", arguments.problems, "Their folder")->required();
    command->add_option("--case", arguments.folder, "Folder that `morgagni prepare` made")
        ->required();
  }
  write->add_option("--recording", arguments.recording, "With groundtruth.txt and targets.csv")
      ->required();
  add_export_options(*write, arguments.options);
  CLI11_PARSE(app, argc, argv);
  if (serve->parsed()) return answer(arguments);
  const Case body = value_or_throw(load_case(arguments.folder));
  value_or_throw(
      write->parsed()
          ? export_problems(arguments.problems, body, arguments.recording, arguments.options)
          : export_exact_problems(arguments.problems, body));
  return 0;
}

}  // namespace
}  // namespace mor::peers

int main(int argc, char** argv) {
  try {
    return mor::peers::run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "registration_problems: {}\n", error.what());
    return 1;
  }
}
