// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "morgagni/calibration/calibration_store.h"
#include "morgagni/camera/matroska_recorder.h"
#include "morgagni/camera/open_camera.h"
#include "morgagni/camera/recording_thread.h"
#include "morgagni/camera/simulated_camera.h"
#include "morgagni/camera/tum_recorder.h"
#include "morgagni/casefile/case.h"
#include "morgagni/core/log.h"
#include "morgagni/core/progress.h"
#include "morgagni/core/version.h"
#include "morgagni/evaluation/target_sampling.h"

#include "commands.h"
#include "exit.h"
#include "options.h"
#include "stop_signals.h"

namespace mor {
namespace {

struct Arguments {
  std::filesystem::path folder;
  std::filesystem::path out;
  std::string camera = "simulated:";
  std::optional<int> num_frames;
  ColorCoding color = ColorCoding::kJpeg;
  int num_targets = 0;
  std::uint64_t targets_seed = 1;
};

constexpr int kMaxFrames = 1'000'000;
constexpr int kSimulatedFrames = 150;
constexpr int kMaxTargets = 1000;
constexpr int kMaxErrorsInARow = 10;
const std::map<std::string, ColorCoding> kColors = {{"jpeg", ColorCoding::kJpeg},
                                                    {"lossless", ColorCoding::kLossless}};

/// A frame, when it was, and where the camera truly was if that is known.
struct Shot {
  std::shared_ptr<const RgbdFrame> frame;
  double timestamp_s = 0.0;
  std::optional<Eigen::Isometry3d> ct_from_camera;
};

/// The next frame; none at the end.
using Source = std::function<Result<std::optional<Shot>>(std::stop_token)>;

/// The simulated camera is recorded frame by frame, not in real time: none is missed, and the truth
/// is known.
Source simulated_source(const std::string& name, const std::shared_ptr<const TriangleMesh>& skin) {
  const auto options = value_or_exit(simulated_camera_option(name));
  std::shared_ptr<SimulatedCamera> camera = value_or_exit(SimulatedCamera::create(skin, options));
  return [camera, options, next = std::uint64_t{0}](
             std::stop_token stop) mutable -> Result<std::optional<Shot>> {
    if (stop.stop_requested() || (options.num_frames > 0 && next >= options.num_frames)) {
      return std::nullopt;
    }
    const auto id = next++;
    return Shot{camera->frame_at(id),
                static_cast<double>(id) / options.frames_per_s,
                camera->ct_from_camera(id)};
  };
}

/// Any other as it gives its frames. One that fails is asked again, for a while.
Source camera_source(const std::string& name,
                     const std::shared_ptr<const TriangleMesh>& skin,
                     std::stop_token stopped) {
  using Clock = std::chrono::steady_clock;
  std::shared_ptr<RangeCamera> camera =
      value_or_exit(open_camera(name, skin, std::move(stopped), CalibrationStore().known()));
  return [camera, first = std::optional<Clock::time_point>()](
             std::stop_token stop) mutable -> Result<std::optional<Shot>> {
    for (int i = 1;; ++i) {
      auto frame = camera->next_frame(stop);
      if (!frame) {
        log::warn("{}", frame.error().message);
        if (i == kMaxErrorsInARow) return tl::unexpected<Error>(frame.error());
        continue;
      }
      if (!*frame) return std::nullopt;
      if (!first) first = (*frame)->captured_at;
      const std::chrono::duration<double> since_first = (*frame)->captured_at - *first;
      return Shot{*std::move(frame), since_first.count(), std::nullopt};
    }
  };
}

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

void exit_with(const std::optional<Error>& error) {
  if (error) value_or_exit(Result<void>(tl::unexpect, *error));
}

/// Adds what the source gives, and finishes. A camera that fails or a disk that is full ends a
/// recording, what it has so far is kept.
/// @param words  Behind the number of frames.
template <class Recorder>
void record_all(const Arguments& arguments,
                const Source& source,
                const StopSignals& signals,
                Recorder& recorder,
                const std::function<Result<void>(const Shot&)>& add,
                const std::function<std::string()>& words) {
  const auto progress = console_progress();
  int num_frames = 0;
  std::optional<Error> problem;
  while (!arguments.num_frames || num_frames < *arguments.num_frames) {
    const auto shot = source(signals.token());
    if (!shot) problem = shot.error();
    if (!shot || !*shot) break;
    const auto added = add(**shot);
    if (!added) problem = added.error();
    if (!added) break;
    ++num_frames;
    if (arguments.num_frames) {
      progress("record", static_cast<double>(num_frames) / *arguments.num_frames);
    }
  }
  if (num_frames == 0) exit_with(problem);
  value_or_exit(recorder.finish());
  fmt::print("{}: {} frames{}\n", arguments.out.string(), num_frames, words());
  std::fflush(stdout);
  exit_with(problem);
}

void record_tum(const Arguments& arguments,
                const Source& source,
                const TriangleMesh* skin,
                const StopSignals& signals) {
  auto recorder = value_or_exit(TumRecorder::create(arguments.out));
  if (arguments.num_targets > 0) add_targets(arguments, *skin, recorder);
  bool has_truth = false;
  record_all(
      arguments,
      source,
      signals,
      recorder,
      [&](const Shot& shot) {
        has_truth = shot.ct_from_camera.has_value();
        return recorder.add(*shot.frame, shot.timestamp_s, shot.ct_from_camera);
      },
      [&] { return std::string(has_truth ? " with their true poses" : ""); });
}

void record_matroska(const Arguments& arguments, const Source& source, const StopSignals& signals) {
  auto recorder = value_or_exit(MatroskaRecorder::create(arguments.out, arguments.color));
  record_all(
      arguments,
      source,
      signals,
      recorder,
      [&](const Shot& shot) { return recorder.add(*shot.frame); },
      [] { return std::string(); });
}

std::string to_text(const RecordingProgress& progress) {
  return fmt::format("{:.1f} s, {} frames, {:.1f} MB{}",
                     std::chrono::duration<double>(progress.duration).count(),
                     progress.num_frames,
                     static_cast<double>(progress.num_bytes) / 1e6,
                     progress.num_dropped == 0
                         ? ""
                         : fmt::format(", {} dropped: the disk is slow", progress.num_dropped));
}

void record_mcap(const Arguments& arguments, const Source& source, const StopSignals& signals) {
  McapRecorderOptions options{.color = arguments.color};
  options.about = {{"camera", shown_camera_name(arguments.camera)}, {"morgagni", kVersion}};
  if (!arguments.folder.empty()) {
    options.about.emplace_back("case", arguments.folder.filename().string());
  }
  RecordingThread thread(value_or_exit(McapRecorder::create(arguments.out, options)));
  const bool is_terminal = isatty(STDERR_FILENO) != 0;
  std::optional<Error> camera_error;
  for (int i = 0; !arguments.num_frames || i < *arguments.num_frames; ++i) {
    auto shot = source(signals.token());
    if (!shot) camera_error = shot.error();
    if (!shot || !*shot || thread.progress().error) break;
    thread.put((*shot)->frame);
    if (is_terminal && i % 10 == 0) {
      fmt::print(stderr, "\r{}  (Ctrl-C ends it) \033[K", to_text(thread.progress()));
    }
  }
  const auto progress = thread.finish();
  if (is_terminal) fmt::print(stderr, "\r\033[K");
  fmt::print("{}: {}\n", arguments.out.string(), to_text(progress));
  std::fflush(stdout);
  exit_with(progress.error);
  exit_with(camera_error);
}

void record(Arguments arguments) {
  const bool is_simulated = arguments.camera.starts_with("simulated:");
  const bool is_mcap = arguments.out.extension() == ".mcap";
  const bool is_matroska = arguments.out.extension() == ".mkv";
  if (arguments.folder.empty() && (is_simulated || arguments.num_targets > 0)) {
    value_or_exit(Result<void>(
        tl::unexpect,
        Error{ErrorCode::kInvalidArgument,
              "--case is needed: the simulated camera and --targets look at its skin"}));
  }
  if ((is_mcap || is_matroska) && arguments.num_targets > 0) {
    value_or_exit(Result<void>(tl::unexpect,
                               Error{ErrorCode::kInvalidArgument,
                                     "--targets go with a folder as --out, not with a file"}));
  }
  // Before the case: it is read by threads, which the signals would end the process through.
  const StopSignals signals;
  std::shared_ptr<const TriangleMesh> skin;
  if (!arguments.folder.empty()) {
    const auto body = value_or_exit(load_case(arguments.folder));
    skin = std::shared_ptr<const TriangleMesh>(body.skin, &body.skin->mesh);
  }
  if (is_simulated && !arguments.num_frames) arguments.num_frames = kSimulatedFrames;
  const auto source = is_simulated ? simulated_source(arguments.camera, skin)
                                   : camera_source(arguments.camera, skin, signals.token());
  if (is_mcap) {
    record_mcap(arguments, source, signals);
  } else if (is_matroska) {
    record_matroska(arguments, source, signals);
  } else {
    record_tum(arguments, source, skin.get(), signals);
  }
}

}  // namespace

void add_record_command(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  auto* command =
      app.add_subcommand("record", "Record any camera, or turn one kind of recording into another");
  command->add_option(
      "--case",
      arguments->folder,
      "Folder that `morgagni prepare` made; the simulated camera looks at its skin");
  command
      ->add_option(
          "--out,--output",
          arguments->out,
          "FILE.mcap, which Foxglove and ROS 2 open; FILE.mkv, which ffmpeg opens; any other name "
          "is "
          "a new folder in the TUM layout, which keeps the simulated camera's true poses too")
      ->required();
  command->add_option("--camera", arguments->camera, "As for `morgagni serve`")
      ->capture_default_str();
  command
      ->add_option("--frames",
                   arguments->num_frames,
                   "How many; by default 150 of the simulated camera, others until Ctrl-C or their "
                   "end")
      ->check(CLI::Range(1, kMaxFrames));
  command
      ->add_option(
          "--color",
          arguments->color,
          "Of a .mcap or .mkv: jpeg, or lossless (three to four times the size); depth keeps every "
          "bit in both")
      ->transform(CLI::CheckedTransformer(kColors).description("jpeg or lossless"))
      ->default_str("jpeg");
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
      "  path=pass              a hand around the body from side to side, in 100 s or so\n"
      "  path=sweep             a hand that calibrates: near and far, rolled, the body all over "
      "the picture\n"
      "  path=views             every frame from a random place of its own above the table\n"
      "  hold=FRAMES            with path=views: a hand drifts at each place for so many frames\n"
      "  walk=MM                with hold: in place of the drift it goes so far to one side\n"
      "  clutter=none|hand|towel|parts|all  what the CT does not have, in depth and colour\n"
      "  bias=MM                smooth systematic depth error, root mean square at 800 mm\n"
      "  focal=PERCENT          the calibration's focal length is so much too long\n"
      "  exposure=SHARE         brightness and white balance swing, jump and flicker, up to 0.6\n"
      "  skin=plain|marked      marked: with freckles, fine lines and bruises\n"
      "  table=MM               the table is uneven by so much, root mean square, in long waves\n"
      "  frames=N  speed=real|full  for serve: it ends after so many; paced by the clock or not\n"
      "\n"
      "Examples:\n"
      "  morgagni record --case cases/head --camera simulated:seed=7 --frames 300 --out head.mcap\n"
      "  morgagni record --camera mcap:head.mcap,speed=full --out recordings/head    (to TUM)\n"
      "  morgagni record --camera mcap:head.mcap,speed=full --out head.mkv           (to "
      "Matroska)\n"
      "  morgagni record --case cases/head --camera simulated:path=views,clutter=hand,bias=3\n"
      "      --frames 100 --targets 16 --out recordings/head-views");
  command->callback([arguments] { record(*arguments); });
}

}  // namespace mor
