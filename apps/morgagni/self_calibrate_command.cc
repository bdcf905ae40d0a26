// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/calibration/calibration_store.h"
#include "morgagni/calibration/corrected_calibration.h"
#include "morgagni/calibration/self_calibration.h"
#include "morgagni/calibration/view_gatherer.h"
#include "morgagni/camera/calibration_json.h"
#include "morgagni/camera/open_camera.h"
#include "morgagni/casefile/case.h"
#include "morgagni/core/files.h"
#include "morgagni/core/log.h"
#include "morgagni/core/progress.h"
#include "morgagni/core/utc.h"
#include "morgagni/registration/automatic_start.h"
#include "morgagni/tracking/tracker.h"

#include "commands.h"
#include "exit.h"
#include "options.h"
#include "stop_signals.h"

namespace mor {
namespace {

constexpr int kMaxViews = 200;
constexpr int kMaxErrorsInARow = 10;

struct Arguments {
  std::filesystem::path folder;
  std::string camera = "simulated:path=sweep";
  std::filesystem::path out;
  int num_views = 60;
  bool is_forced = false;
  BodySurfaceOptions depth = {.far_mm = kHandHeldFarMm};
};

/// Tracks the body and keeps a view whenever the camera has moved on.
class Gatherer {
 public:
  Gatherer(const Arguments& arguments, const Case& body, RangeCamera& camera)
      : arguments_(arguments),
        body_(body),
        camera_(camera),
        start_(value_or_exit(AutomaticStart::create(body.skin, camera.calibration().depth, {}))),
        tracker_(
            value_or_exit(Tracker::create({},
                                          body.skin,
                                          value_or_exit(BodySurfaceExtractor::create(
                                              camera.calibration().depth, arguments.depth)),
                                          value_or_exit(make_fine_registration(body.skin, {}))))),
        gatherer_(camera.calibration().depth) {}

  [[nodiscard]] const ViewGatherer& gather(std::stop_token stop) {
    const auto progress = console_progress();
    int num_errors = 0;
    while (static_cast<int>(gatherer_.views().size()) < arguments_.num_views) {
      const auto given = camera_.next_frame(stop);
      if (!given) {
        log::warn("{}", given.error().message);
        // What was gathered so far may be enough.
        if (++num_errors == kMaxErrorsInARow) break;
        continue;
      }
      num_errors = 0;
      const auto& frame = *given;
      if (!frame) break;
      const auto tracked = value_or_exit(tracker_.process(frame));
      if (tracked.needs_start) offer_start(*tracked.frame, stop);
      if (tracked.state != TrackingState::kTracking ||
          !gatherer_.pace().wants(*tracked.ct_from_depth, frame->captured_at)) {
        continue;
      }
      // Of what tracking sees: corrected, where the camera has a correction already.
      levels_.learn(tracked.frame->depth_mm.view());
      gatherer_.add(read_skin(body_.skin->mesh,
                              tracked.frame->calibration->depth,
                              tracked.frame->depth_mm.view(),
                              levels_,
                              *tracked.ct_from_depth),
                    frame->captured_at);
      progress("views in motion",
               static_cast<double>(gatherer_.views().size()) / arguments_.num_views);
    }
    return gatherer_;
  }

 private:
  void offer_start(const RgbdFrame& frame, std::stop_token stop) {
    const auto found = start_.find(frame.depth_mm.view(), stop);
    if (found && found->status == AutomaticStartStatus::kFound) {
      tracker_.offer_start(frame, found->ct_from_depth);
    }
  }

  const Arguments& arguments_;
  const Case& body_;
  RangeCamera& camera_;
  AutomaticStart start_;
  Tracker tracker_;
  DepthLevels levels_;
  ViewGatherer gatherer_;
};

std::string in_words(const SelfCalibration& found) {
  switch (found.verdict) {
    case SelfCalibrationVerdict::kTooFewViews:
      return "too few views: move the camera on, at least 20 are needed, 60 are better";
    case SelfCalibrationVerdict::kTooLittleMotion:
      return "too little motion: move nearer and farther, roll the camera, look from the sides";
    case SelfCalibrationVerdict::kOtherBody:
      return "the skin is farther off than a body changes: another body, or a cover";
    case SelfCalibrationVerdict::kSkinChanged:
      return "the body's skin has changed since its CT, and no error of the sensor was found: "
             "`morgagni serve` follows the skin as it is now when it is told to";
    case SelfCalibrationVerdict::kNoError:
      return "no error of the sensor that the held-out views would confirm: leave it as it is";
    case SelfCalibrationVerdict::kSmall:
      return "an error too small to matter: leave it as it is";
    case SelfCalibrationVerdict::kError:
      return "a systematic error of the sensor: the correction is worth having";
  }
  return {};
}

/// The correction at the reference distance over the picture, as numbers to look at.
void print_map(const SelfCalibration& found) {
  constexpr double kReferenceMm = 800.0;
  const int width = found.depth.width_px;
  const int height = found.depth.height_px;
  fmt::print("correction of depth at {:.0f} mm, over the picture, mm:\n", kReferenceMm);
  for (int row = 0; row < 5; ++row) {
    for (int column = 0; column < 7; ++column) {
      const Eigen::Vector2d pixel(column * (width - 1) / 6.0, row * (height - 1) / 4.0);
      fmt::print("{:+7.2f}", found.correction.add_mm(pixel, width, height, kReferenceMm));
    }
    fmt::print("\n");
  }
}

void print(const SelfCalibration& found) {
  const auto& held = found.held_out;
  fmt::print("{}\n", in_words(found));
  fmt::print(
      "views {}; poses are estimated to be off by {:.1f} mm; of such errors {:.1f} mm stay "
      "unknown (one standard deviation)\n",
      found.num_views,
      found.shift_mm,
      found.remaining_mm);
  fmt::print(
      "held-out views lie off the skin by {:.3f} mm as it is, {:.3f} with a changed skin, "
      "{:.3f} with the sensor corrected as well; gain of that {:.1f} times its standard error, {} "
      "of {} parts better\n",
      held.as_it_is_mm,
      held.skin_mm,
      held.both_mm,
      held.sensor.significance,
      held.sensor.num_better,
      held.num_folds);
  fmt::print(
      "{}; focal length {:+.2f} / {:+.2f} %, centre {:+.1f} / {:+.1f} px, skin changed by "
      "{:.2f} mm; {} of {} combinations are not seen and stay as they are\n",
      found.sees_table ? "the table under the body told along" : "no table was seen",
      100.0 * found.focal_x_ratio,
      100.0 * found.focal_y_ratio,
      found.center_px.x(),
      found.center_px.y(),
      found.skin_rms_mm,
      found.num_open,
      found.num_parameters);
  if (found.follows_skin) {
    fmt::print(
        "the skin has changed by up to {:.1f} mm, which moves the poses by {:.1f} mm; that is the "
        "body's, not the sensor's: it is in no file\n",
        found.skin_most_mm,
        found.skin_shift_mm);
  }
  print_map(found);
}

void self_calibrate(const Arguments& arguments) {
  const StopSignals signals;
  const auto body = value_or_exit(load_case(arguments.folder));
  const auto skin = std::shared_ptr<const TriangleMesh>(body.skin, &body.skin->mesh);
  const auto camera = value_or_exit(
      open_camera(arguments.camera, skin, signals.token(), CalibrationStore().known()));
  const auto& calibration = camera->calibration();
  Gatherer gatherer(arguments, body, *camera);
  const auto& gathered = gatherer.gather(signals.token());
  const auto found = value_or_exit(estimate_self_calibration(*skin, calibration, gathered.views()));
  print(found);
  for (const auto& sentence : gathered.coverage().missing()) {
    fmt::print("it would know more of this: {}\n", sentence);
  }
  if (arguments.out.empty()) return;
  if (found.verdict != SelfCalibrationVerdict::kError && !arguments.is_forced) {
    fmt::print("{} was not written\n", arguments.out.string());
    return;
  }
  auto corrected = value_or_exit(without_error(calibration, found));
  corrected.origin = "self-calibration on the CT skin, " + utc_text();
  value_or_exit(write_file(arguments.out, calibration_to_json(corrected) + "\n"));
  fmt::print("{}: for calibration=FILE of the camera\n", arguments.out.string());
}

}  // namespace

void add_self_calibrate_command(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  auto* command = app.add_subcommand("self-calibrate",
                                     "Find a depth camera's systematic error on the skin of a CT");
  command->add_option("--case", arguments->folder, "Folder that `morgagni prepare` made")
      ->required();
  command->add_option("--camera", arguments->camera, "A camera or recording that looks at the body")
      ->capture_default_str();
  command
      ->add_option(
          "--views", arguments->num_views, "In motion, each 0.7 s and 20 mm or 3 degrees on")
      ->check(CLI::Range(20, kMaxViews))
      ->capture_default_str();
  command->add_option("--out", arguments->out, "Write the calibration there if one is proposed")
      ->type_name("FILE");
  command->add_flag("--force", arguments->is_forced, "Write it even if it is not");
  add_depth_options(*command, arguments->depth);
  command->footer(
      "Move slowly: nearer and farther, rolled, the body to all sides of the picture, for a "
      "minute.\n"
      "Examples:\n"
      "  morgagni self-calibrate --case cases/head --camera mcap:head.mcap,speed=full --out "
      "kinect.json\n"
      "  morgagni serve --case cases/head --camera freenect:calibration=kinect.json");
  command->callback([arguments] { self_calibrate(*arguments); });
}

}  // namespace mor
