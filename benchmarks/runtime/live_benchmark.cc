// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// The whole live path on a prepared case: from a camera frame to the encoded picture.
//   live_benchmark CASE [CAMERA] [SECONDS]

#include <chrono>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>

#include <spdlog/fmt/fmt.h>
#include <sys/resource.h>

#include "morgagni/casefile/case.h"
#include "morgagni/session/live_session.h"

namespace {

/// Until tracking has caught and the medians are those of tracked frames.
constexpr std::chrono::seconds kWarmUp{6};

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: live_benchmark CASE [CAMERA] [SECONDS]\n");
    return 2;
  }
  const std::string camera_name = argc > 2 ? argv[2] : "simulated:";
  const int seconds = argc > 3 ? std::atoi(argv[3]) : 20;

  auto body = mor::load_case(argv[1]);
  if (!body) return fmt::print(stderr, "{}\n", body.error().message), 1;
  const auto skin = std::shared_ptr<const mor::TriangleMesh>(body->skin, &body->skin->mesh);
  auto camera = mor::open_camera(camera_name, skin);
  if (!camera) return fmt::print(stderr, "{}\n", camera.error().message), 1;
  mor::LiveSessionOptions options;
  options.camera_name = camera_name;
  options.server.port = 0;
  options.server.web_root = MORGAGNI_WEB_ROOT;
  const auto session = mor::LiveSession::start(*std::move(body), *std::move(camera), options);
  if (!session) return fmt::print(stderr, "{}\n", session.error().message), 1;

  std::this_thread::sleep_for(kWarmUp);
  const auto before = (*session)->stream_stats();
  const double cpu_before = cpu_seconds();
  std::this_thread::sleep_for(std::chrono::seconds(seconds));
  const auto after = (*session)->stream_stats();
  const double cpu = cpu_seconds() - cpu_before;
  const auto status = (*session)->status();
  const double frames = static_cast<double>(after.num_encoded - before.num_encoded);

  fmt::print("| figure | value |\n|---|---|\n");
  fmt::print("| state | {} |\n", mor::to_string(status.last.state));
  fmt::print("| pictures a second | {:.1f} |\n", frames / seconds);
  fmt::print("| frame in to encoded, median / p95 | {:.1f} / {:.1f} ms |\n",
             after.capture_to_encoded_ms,
             after.capture_to_encoded_p95_ms);
  fmt::print(
      "| wait, depth, registration, render, encode (medians) | {:.1f}, {:.1f}, {:.1f}, {:.1f}, "
      "{:.1f} ms |\n",
      status.wait_ms,
      status.depth_ms,
      status.registration_ms,
      status.render_ms,
      after.encode_ms);
  fmt::print("| processor time a picture, camera simulation included | {:.1f} ms |\n",
             1e3 * cpu / frames);
  fmt::print("| peak memory | {:.0f} MB |\n", peak_memory_mb());
  return 0;
}
