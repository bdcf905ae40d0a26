// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Draws one picture of a case as the live view shows it, at the simulated camera's true pose:
//
//   draw_view CASE OUT.png CAMERA FRAME VIEW [moving]
//
// CAMERA is what follows `simulated:`, VIEW what POST /api/view takes; `moving`: as a live picture
// is drawn, else as a frozen one. Says how much processor time the picture took, all threads
// together, drawn again and again (median).
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/simulated_camera.h"
#include "morgagni/core/files.h"
#include "morgagni/core/image_png.h"
#include "morgagni/core/statistics.h"
#include "morgagni/session/scene_view.h"

namespace mor {
namespace {

constexpr int kRepetitions = 5;

template <class T>
T value_or_exit(Result<T> result) {
  if (result) return *std::move(result);
  fmt::print(stderr, "{}\n", result.error().message);
  std::exit(1);
}

double processor_ms() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

/// Draws `draw()` again and again; says how long that takes and writes the last picture.
template <class Draw>
void measure(const std::string& path, const Draw& draw) {
  std::vector<double> times_ms;
  ImageView<const Rgba8> picture;
  for (int i = 0; i < kRepetitions; ++i) {
    const double start_ms = processor_ms();
    picture = draw();
    times_ms.push_back(processor_ms() - start_ms);
  }
  const auto bytes = encode_png(picture);
  if (const auto written = write_file(path, bytes); !written) {
    fmt::print(stderr, "{}\n", written.error().message);
    std::exit(1);
  }
  fmt::print("{}: {:.1f} ms of CPU, {} kB\n", path, quantile(times_ms, 0.5), bytes.size() / 1000);
}

void draw(const std::vector<std::string>& words) {
  const Case body = value_or_exit(load_case(words[1]));
  const auto skin = std::shared_ptr<const TriangleMesh>(body.skin, &body.skin->mesh);
  const auto options = value_or_exit(SimulatedCameraOptions::parse(words[3]));
  const auto camera = value_or_exit(SimulatedCamera::create(skin, options));
  const auto frame_id = std::stoull(words[4]);
  const auto frame = camera->frame_at(frame_id);
  const auto pose = camera->ct_from_camera(frame_id);
  const auto settings = value_or_exit(changed(first_view(body), words[5]));
  if (settings.free.is_shown) {
    const FreeView view = free_view(settings,
                                    bounding_sphere(*skin),
                                    frame->color.width(),
                                    frame->color.height(),
                                    frame.get(),
                                    pose);
    const auto renderer = value_or_exit(FreeViewRenderer::create(scene_of(body)));
    return measure(words[2], [&] { return value_or_exit(renderer->render(view)).picture; });
  }
  const bool is_still = words.size() < 7;
  const auto overlay = overlay_view(*frame, pose, std::nullopt, settings, is_still);
  const auto renderer = value_or_exit(OverlayRenderer::create(scene_of(body)));
  measure(words[2], [&] { return value_or_exit(renderer->render(frame->color.view(), overlay)); });
}

}  // namespace
}  // namespace mor

int main(int argc, char** argv) {
  const std::vector<std::string> words{argv, argv + argc};
  if (words.size() < 6 || words.size() > 7 || (words.size() == 7 && words[6] != "moving")) {
    fmt::print(stderr, "usage: draw_view CASE OUT.png CAMERA FRAME VIEW [moving]\n");
    return 2;
  }
  mor::draw(words);
}
