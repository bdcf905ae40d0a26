// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "morgagni/calibration/calibration_store.h"
#include "morgagni/camera/open_camera.h"
#include "morgagni/casefile/added_cts.h"
#include "morgagni/casefile/case.h"
#include "morgagni/core/log.h"
#include "morgagni/session/live_session.h"

#include "coming_camera.h"
#include "commands.h"
#include "exit.h"
#include "options.h"
#include "stop_signals.h"

namespace mor {
namespace {

struct Arguments {
  std::filesystem::path folder;
  std::string ct;
  std::string camera = "simulated:";
  std::string side = "anterior";
  int lost_after_ms = 500;
  LiveSessionOptions options;
};

const std::map<std::string, TrackingGate> kGates = {{"evidence", TrackingGate::kEvidence},
                                                    {"residual", TrackingGate::kResidual}};
const std::map<std::string, StartMethod> kStarts = {{"automatic", StartMethod::kAutomatic},
                                                    {"placement", StartMethod::kPlacement}};

/// The CT that a page asks for, until then or a stop.
class NextCt {
 public:
  void ask(const std::string& name) {
    const std::scoped_lock lock(mutex_);
    name_ = name;
    asked_.notify_all();
  }
  /// Until one is asked for, which take() then gives.
  void wait_for_it(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    asked_.wait(lock, stop, [&] { return name_.has_value(); });
  }
  /// None: it was a stop.
  std::optional<std::string> take() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(name_, std::nullopt);
  }

 private:
  std::mutex mutex_;
  std::condition_variable_any asked_;
  std::optional<std::string> name_;
};

/// The camera. Where it has to be waited for, the page says meanwhile what for. Null: stopped.
std::unique_ptr<RangeCamera> camera_of(Arguments& arguments,
                                       const Case& body,
                                       const std::stop_token& stop) {
  const auto skin = std::shared_ptr<const TriangleMesh>(body.skin, &body.skin->mesh);
  const auto known = CalibrationStore().known();
  if (!is_device_camera(arguments.camera)) {
    return value_or_exit(open_camera(arguments.camera, skin, stop, known));
  }
  return wait_for_camera_on_page(
      [&](std::stop_token stopped, const SayWaiting& say) {
        return open_camera(arguments.camera, skin, std::move(stopped), known, say);
      },
      stop,
      body.name,
      arguments.camera,
      "",
      arguments.options.server);
}

/// One CT of the case, until another one is asked for.
void serve_ct(Arguments& arguments,
              const std::string& ct,
              NextCt& next,
              const std::stop_token& stop) {
  auto& options = arguments.options;
  options.cts = {added_cts(arguments.folder), ct, [&next](const auto& name) { next.ask(name); }};
  auto body = value_or_exit(load_case(value_or_exit(find_ct(arguments.folder, ct))));
  auto camera = camera_of(arguments, body, stop);
  if (!camera) return;
  const auto name = body.name;
  const auto session =
      value_or_exit(LiveSession::start(std::move(body), std::move(camera), options));
  options.server.port = session->port();  // Pages find the next CT where they found this one.
  fmt::print(
      "Case {} is live at http://127.0.0.1:{}/  (stop with Ctrl-C)\n", name, session->port());
  std::fflush(stdout);
  next.wait_for_it(stop);
}

void serve(Arguments& arguments) {
  auto& options = arguments.options;
  options.camera_name = shown_camera_name(arguments.camera);
  options.loop.placement.side = value_or_exit(side_option(arguments.side));
  // A camera that does not keep to the clock waits for the tracking.
  options.loop.in_step = arguments.camera.find("speed=full") != std::string::npos;
  options.loop.tracking.lost_after = std::chrono::milliseconds(arguments.lost_after_ms);
  if (options.server.web_root.empty()) options.server.web_root = default_web_root();
  const StopSignals signals;
  NextCt next;
  for (std::optional<std::string> ct = arguments.ct; ct; ct = next.take())
    serve_ct(arguments, *ct, next, signals.token());
  log::info("stopping");
}

}  // namespace

void add_serve_command(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  auto* command = app.add_subcommand("serve", "Show a case live in the browser");
  auto& loop = arguments->options.loop;
  auto& server = arguments->options.server;
  command->add_option("--case", arguments->folder, "Folder that `morgagni prepare` made")
      ->required();
  command->add_option(
      "--ct", arguments->ct, "Of a case with several CTs: which (default: the first)");
  command
      ->add_option("--camera",
                   arguments->camera,
                   "simulated:[key=value,...], freenect:, openni2:, "
                   "v4l2:/dev/videoN[,color=/dev/videoM], push:PORT, "
                   "mcap:FILE[,loop=1][,speed=full] "
                   "or tum:DIR[,loop=1][,speed=full] (docs/cameras.md); at full speed every frame "
                   "is tracked, "
                   "with the same poses each time")
      ->capture_default_str();
  command->add_option("--port", server.port, "On 127.0.0.1; 0 takes a free one")
      ->capture_default_str();
  command->add_option("--web", server.web_root, "The built page")->type_name("DIR");
  command->add_option("--bitrate-kbps", server.bitrate_kbps, "Of the VP8 stream")
      ->capture_default_str();
  add_registration_options(*command, loop.registration);
  add_depth_options(*command, loop.depth);
  command
      ->add_option("--gate",
                   loop.tracking.gate,
                   "How a frame is judged: by all evidence, or by the residual alone (the paper's)")
      ->transform(CLI::CheckedTransformer(kGates).description("evidence or residual"))
      ->default_str("evidence");
  command
      ->add_option("--sensor-bias-mm",
                   loop.tracking.sensor_bias_mm,
                   "Systematic error of the camera's depth where it is known, root mean square at "
                   "0.8 m: widens the error bound")
      ->capture_default_str();
  command
      ->add_option("--alpha",
                   loop.tracking.residual_ratio,
                   "--gate residual: frames with a residual above alpha times that of the start "
                   "hold the pose")
      ->capture_default_str();
  command
      ->add_option("--lost-after-ms",
                   arguments->lost_after_ms,
                   "Without a usable frame the tracking is lost")
      ->capture_default_str();
  command
      ->add_option("--start", loop.start, "The body is searched for, or placed before the camera")
      ->transform(CLI::CheckedTransformer(kStarts).description("automatic or placement"))
      ->default_str("automatic");
  command
      ->add_option("--start-distance-mm",
                   loop.placement.distance_mm,
                   "--start placement: distance of the placed body")
      ->capture_default_str();
  command
      ->add_option(
          "--start-side",
          arguments->side,
          "--start placement: side of the body that faces the camera: anterior, posterior, left, "
          "right")
      ->capture_default_str();
  command->footer(
      "Examples:\n"
      "  morgagni serve --case cases/0815 --camera simulated:\n"
      "  morgagni serve --case cases/head --camera tum:recordings/head,loop=1 --port 9000");
  command->callback([arguments] { serve(*arguments); });
}

}  // namespace mor
