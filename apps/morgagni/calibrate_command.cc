// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/calibration/board_pattern.h"
#include "morgagni/calibration/calibration_check.h"
#include "morgagni/calibration/calibration_desk.h"
#include "morgagni/calibration/calibration_store.h"
#include "morgagni/calibration/view_collector.h"
#include "morgagni/calibration/view_source.h"
#include "morgagni/camera/calibration_json.h"
#include "morgagni/camera/infrared_source.h"
#include "morgagni/core/files.h"

#include "coming_camera.h"
#include "commands.h"
#include "exit.h"
#include "options.h"
#include "stop_signals.h"

namespace mor {
namespace {

struct Arguments {
  std::string board = to_string(CalibrationBoard{});
  std::string camera;
  std::filesystem::path images;
  std::filesystem::path design;
  std::filesystem::path calibration;
  std::filesystem::path out;
  std::filesystem::path pdf = "board.pdf";
  std::string device;
  int num_views = 24;
  int num_wall_views = 10;
  int num_check_views = 3;
  bool skips_depth = false;
  bool keeps = true;
  bool is_on_page = false;
  LiveServerOptions server;
  std::string depth_form = "auto";
  std::pair<double, double> infrared_offset_px{0.0, 0.0};
};

const std::map<std::string, DepthForm> kForms = {{"auto", DepthForm::kAuto},
                                                 {"disparity", DepthForm::kDisparity},
                                                 {"tof", DepthForm::kTimeOfFlight}};
constexpr int kMaxErrorsInARow = 10;
constexpr std::uintmax_t kMaxCalibrationBytes = 4U << 20U;

[[noreturn]] void fail(std::string sentence) {
  value_or_exit(
      Result<void>(tl::unexpect, Error{ErrorCode::kInvalidArgument, std::move(sentence)}));
  throw CLI::RuntimeError(kExitFailure);
}

/// A file of `calibrate --out`, or the one that calibrate keeps.
RgbdCalibration read_calibration(const std::filesystem::path& file) {
  const auto text = value_or_exit(read_text_file(file, kMaxCalibrationBytes));
  if (auto kept = kept_calibration_from_json(text)) return kept->calibration;
  return value_or_exit(calibration_from_json(text));
}

/// What was gathered, and of which device.
struct Gathered {
  ViewCollector collector;
  std::string device_id;
};

Gathered gather_images(const Arguments& arguments, const CalibrationBoard& board) {
  const auto pictures = value_or_exit(read_still_pictures(arguments.images));
  const auto design =
      arguments.design.empty() ? unknown_calibration(pictures) : read_calibration(arguments.design);
  Gathered gathered{ViewCollector(board, design), arguments.device};
  const auto pointer = [](const auto& optional) { return optional ? &*optional : nullptr; };
  for (const auto& each : pictures) {
    const auto reason = gathered.collector.add(
        each.name, pointer(each.color), pointer(each.infrared), pointer(each.depth_mm));
    if (!reason.empty()) fmt::print("{}: {}\n", each.name, reason);
  }
  return gathered;
}

/// Looks until enough is gathered, the recording has ended, or Ctrl-C; says what to do meanwhile.
Gathered gather_live(const Arguments& arguments, const CalibrationBoard& board, int num_views) {
  const StopSignals signals;
  const auto camera = wait_for_camera(
      [&](std::stop_token stop, const SayWaiting& say) {
        return open_camera_before_board(arguments.camera, board, std::move(stop), say);
      },
      signals.token(),
      [](const std::string& sentence) {
        fmt::print("{}\n", sentence);
        std::fflush(stdout);
      });
  if (!camera) throw CLI::RuntimeError(kExitFailure);
  auto* infrared_source = dynamic_cast<InfraredSource*>(camera.get());
  const auto infrared = [&]() -> std::optional<Image<Rgb8>> {
    if (infrared_source == nullptr) return std::nullopt;
    auto picture = infrared_source->infrared_picture(signals.token());
    if (picture) return *std::move(picture);
    fmt::print("no infrared picture: {}\n", picture.error().message);
    return std::nullopt;
  };
  // A check needs a few views, not all kinds.
  const bool is_check = num_views <= arguments.num_check_views;
  const WantedViews wanted{num_views,
                           is_check || arguments.skips_depth ? 0 : arguments.num_wall_views};
  Gathered gathered{ViewCollector(board, camera->calibration(), {.wanted = wanted}),
                    arguments.device.empty() ? camera->device_id() : arguments.device};
  std::string said;
  int num_errors = 0;
  while (!signals.token().stop_requested()) {
    const auto frame = camera->next_frame(signals.token());
    if (!frame) {
      fmt::print("{}\n", frame.error().message);
      if (++num_errors == kMaxErrorsInARow) fail(frame.error().message);
      continue;
    }
    if (!*frame) break;
    num_errors = 0;
    const auto look = gathered.collector.look(**frame, Taking::kNewPoses, infrared);
    std::string say = look.say;
    if (look.was_taken) {
      const auto coverage = gathered.collector.coverage();
      if (coverage.missing.empty()) break;
      say = fmt::format("view {} is taken; next: {}", coverage.num_views, coverage.missing.front());
    }
    if (say != said) fmt::print("{}\n", say);
    std::fflush(stdout);
    said = std::move(say);
    if (is_check && static_cast<int>(gathered.collector.views().size()) >= num_views) {
      break;
    }
  }
  return gathered;
}

Gathered gather(const Arguments& arguments, int num_views) {
  const auto board = value_or_exit(parse_board(arguments.board));
  if (arguments.camera.empty() == arguments.images.empty()) {
    fail("say where the views come from: --camera NAME or --images DIR, one of the two");
  }
  return arguments.images.empty() ? gather_live(arguments, board, num_views)
                                  : gather_images(arguments, board);
}

void print(const std::vector<std::pair<std::string, std::string>>& figures) {
  for (const auto& [name, value] : figures) fmt::print("  {:<32} {}\n", name, value);
}

void print_views(const RigCalibration& result) {
  for (const auto& view : result.color.views) {
    if (!view.is_used) fmt::print("  {} was left out: {}\n", view.name, view.reason);
  }
}

void keep(const Arguments& arguments, const Gathered& gathered, const RigCalibration& result) {
  if (!arguments.out.empty()) {
    auto calibration = result.calibration;
    calibration.origin = "board";
    value_or_exit(write_file(arguments.out, calibration_to_json(calibration)));
    fmt::print("Written to {}: use it as calibration={} in the camera's name\n",
               arguments.out.string(),
               arguments.out.string());
  }
  if (!arguments.keeps) return;
  if (gathered.device_id.empty()) {
    if (arguments.out.empty()) {
      fmt::print("Not kept: the device has no serial number here; say --out FILE or --device ID\n");
    }
    return;
  }
  const auto file =
      value_or_exit(CalibrationStore().save({.device_id = gathered.device_id,
                                             .made_at = std::chrono::system_clock::now(),
                                             .made_by = "board",
                                             .figures = result.figures(),
                                             .calibration = result.calibration}));
  fmt::print("Kept for {}: {}\n", gathered.device_id, file.string());
}

/// On the page until Ctrl-C.
void serve_page(const Arguments& arguments) {
  if (arguments.camera.empty() || !arguments.images.empty())
    fail("--page needs a live camera: --camera NAME");
  if (!arguments.out.empty() || !arguments.keeps)
    fail("on the page it is kept by the key Keep it: --out and --no-keep go without --page");
  const StopSignals signals;
  CalibrationDeskOptions options;
  options.board = value_or_exit(parse_board(arguments.board));
  options.collector.wanted = {arguments.num_views,
                              arguments.skips_depth ? 0 : arguments.num_wall_views};
  options.rig.fits_depth = !arguments.skips_depth;
  options.rig.depth.form = kForms.at(arguments.depth_form);
  options.rig.infrared_offset_px = {arguments.infrared_offset_px.first,
                                    arguments.infrared_offset_px.second};
  options.device_id = arguments.device;
  options.server = arguments.server;
  if (options.server.web_root.empty()) options.server.web_root = default_web_root();
  auto camera = wait_for_camera_on_page(
      [&](std::stop_token stop, const SayWaiting& say) {
        return open_camera_before_board(arguments.camera, options.board, std::move(stop), say);
      },
      signals.token(),
      "Calibration",
      arguments.camera,
      "calibrate.html",
      options.server);
  if (!camera) return;
  const auto desk = value_or_exit(CalibrationDesk::start(std::move(camera), options));
  fmt::print("Calibration at http://127.0.0.1:{}/calibrate.html  (stop with Ctrl-C)\n",
             desk->port());
  std::fflush(stdout);
  signals.wait();
}

void calibrate(const Arguments& arguments) {
  if (arguments.is_on_page) return serve_page(arguments);
  const auto gathered = gather(arguments, arguments.num_views);
  RigOptions options{.fits_depth = !arguments.skips_depth};
  options.depth.form = kForms.at(arguments.depth_form);
  options.infrared_offset_px = {arguments.infrared_offset_px.first,
                                arguments.infrared_offset_px.second};
  const auto result = value_or_exit(gathered.collector.solve(options));
  fmt::print("Calibrated from {} views\n", gathered.collector.views().size());
  print(result.figures());
  print_views(result);
  for (const auto& remark : result.remarks) fmt::print("  {}\n", remark);
  keep(arguments, gathered, result);
}

void check(const Arguments& arguments) {
  const auto gathered = gather(arguments, arguments.num_check_views);
  auto calibration = gathered.collector.by_design();
  if (!arguments.calibration.empty()) {
    calibration = read_calibration(arguments.calibration);
  } else if (auto kept = CalibrationStore().newest(gathered.device_id)) {
    calibration = std::move(kept->calibration);
  }
  const auto checked = value_or_exit(
      check_calibration(gathered.collector.board(), gathered.collector.views(), calibration));
  fmt::print("Calibration: {}\n",
             calibration.origin.empty() ? "none kept: the device's own word" : calibration.origin);
  print(checked.figures());
}

void print_board(const Arguments& arguments) {
  const auto board = value_or_exit(parse_board(arguments.board));
  value_or_exit(write_board_pdf(board, arguments.pdf));
  fmt::print("{}: {}; print at 100 %, then measure both rulers\n",
             arguments.pdf.string(),
             to_string(board));
}

void add_sources(CLI::App& command, Arguments& arguments) {
  command
      .add_option("--board",
                  arguments.board,
                  "charuco:COLUMNSxROWS:SQUARE_MM:MARKER_MM or chessboard:COLUMNSxROWS:SQUARE_MM, "
                  "counted in squares, one number odd and one even")
      ->capture_default_str();
  command.add_option("--camera",
                     arguments.camera,
                     "As for `morgagni serve`, recordings too, or simulated-board:[key=value,...]");
  command.add_option("--images",
                     arguments.images,
                     "Folder of PNG pictures: color_NAME, infrared_NAME, depth_NAME (16 bit, mm)");
  command.add_option(
      "--device", arguments.device, "The device's id, where a recording or pictures do not say it");
}

}  // namespace

void add_calibrate_command(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  auto* command = app.add_subcommand(
      "calibrate", "Find a camera's lenses, and what its depth is wrong by, with a printed board");
  add_sources(*command, *arguments);
  command
      ->add_option("--views", arguments->num_views, "Poses of the board that are taken, at least")
      ->capture_default_str()
      ->check(CLI::Range(8, 200));
  command
      ->add_option("--wall-views",
                   arguments->num_wall_views,
                   "Besides, of the board on a wall or a wide table, for the depth")
      ->capture_default_str()
      ->check(CLI::Range(0, 100));
  command->add_option("--design",
                      arguments->design,
                      "--images: calibration that stands where the views say nothing");
  command->add_option("--out,--output", arguments->out, "Write the calibration to this file");
  command->add_flag("!--no-keep", arguments->keeps, "Do not keep it for the device");
  command->add_flag("--no-depth", arguments->skips_depth, "Do not correct the depth");
  command
      ->add_option("--depth-form",
                   arguments->depth_form,
                   "What the depth's error is like: auto, disparity (structured light) or tof")
      ->capture_default_str()
      ->check(CLI::IsMember(kForms));
  command
      ->add_option("--infrared-offset",
                   arguments->infrared_offset_px,
                   "X,Y: a place of the infrared picture lies so many pixels further in the depth "
                   "picture")
      ->delimiter(',');
  command->add_flag("--page", arguments->is_on_page, "On a page, for a tablet");
  command->add_option("--port", arguments->server.port, "--page: on 127.0.0.1; 0 takes a free one")
      ->capture_default_str();
  command->add_option("--web", arguments->server.web_root, "--page: the built page")
      ->type_name("DIR");
  auto* check_command = command->add_subcommand(
      "check", "Say in millimetres how good the calibration is today, from a few views");
  add_sources(*check_command, *arguments);
  check_command->add_option("--views", arguments->num_check_views, "How many")
      ->capture_default_str()
      ->check(CLI::Range(1, 50));
  check_command->add_option("--calibration", arguments->calibration, "Instead of the one kept");
  check_command->add_option(
      "--design", arguments->design, "--images: calibration that stands where none is kept");
  check_command->callback([arguments] { check(*arguments); });
  auto* board_command = command->add_subcommand("board", "Write the board as a PDF to print");
  board_command->add_option("--board", arguments->board, "As for calibrate")->capture_default_str();
  board_command->add_option("--out,--output", arguments->pdf, "The file")->capture_default_str();
  board_command->callback([arguments] { print_board(*arguments); });
  command->require_subcommand(0, 1);
  command->footer(
      "Keys of the simulated board, for trying it out:\n"
      "  seed=1  sensor=kinect|tof  bias=MM  blur=PX  grain=LEVEL  wall=0|1|turns  near=MM  "
      "far=MM\n"
      "  tilt=DEGREES  hold=SECONDS  infrared=0|1  speed=real|full\n"
      "\n"
      "Examples:\n"
      "  morgagni calibrate board --out board.pdf\n"
      "  morgagni calibrate --camera freenect:\n"
      "  morgagni calibrate check --camera freenect:\n"
      "  morgagni calibrate --camera simulated-board:hold=0.4 --out calibration.json");
  command->callback([arguments, command] {
    if (command->get_subcommands().empty()) calibrate(*arguments);
  });
}

}  // namespace mor
