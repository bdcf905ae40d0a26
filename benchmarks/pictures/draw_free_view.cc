// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Draws the free view of a case, its skin in the colours of the simulated camera at its true pose:
//
//   draw_free_view CASE OUT.png CAMERA FRAME VIEW
//
// CAMERA is what follows `simulated:`, VIEW what POST /api/view takes. Says how much CPU time the
// picture took, drawn again and again (median).
#include <chrono>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include <spdlog/fmt/fmt.h>
#include <sys/resource.h>

#include "morgagni/camera/simulated_camera.h"
#include "morgagni/core/files.h"
#include "morgagni/core/image_png.h"
#include "morgagni/core/statistics.h"
#include "morgagni/session/scene_view.h"

namespace mor {
namespace {

constexpr int kRepetitions = 15;

template <class T>
T value_or_exit(Result<T> result) {
  if (result) return *std::move(result);
  fmt::print(stderr, "{}\n", result.error().message);
  std::exit(1);
}

/// Of all threads of this process.
double cpu_ms() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto ms = [](const timeval& t) { return 1e3 * t.tv_sec + 1e-3 * t.tv_usec; };
  return ms(usage.ru_utime) + ms(usage.ru_stime);
}

void draw(const std::vector<std::string>& words) {
  const Case body = value_or_exit(load_case(words[1]));
  const auto skin = std::shared_ptr<const TriangleMesh>(body.skin, &body.skin->mesh);
  const auto options = value_or_exit(SimulatedCameraOptions::parse(words[3]));
  const auto camera = value_or_exit(SimulatedCamera::create(skin, options));
  const auto frame_id = std::stoull(words[4]);
  const auto frame = camera->frame_at(frame_id);
  const auto settings = value_or_exit(changed(first_view(body), words[5]));
  const FreeView view = free_view(settings,
                                  bounding_sphere(*skin),
                                  frame->color.width(),
                                  frame->color.height(),
                                  frame.get(),
                                  camera->ct_from_camera(frame_id));
  const auto renderer = value_or_exit(FreeViewRenderer::create(scene_of(body)));
  std::vector<double> times_ms;
  FreePicture drawn;
  for (int i = 0; i < kRepetitions; ++i) {
    const double start_ms = cpu_ms();
    drawn = value_or_exit(renderer->render(view));
    times_ms.push_back(cpu_ms() - start_ms);
  }
  const auto bytes = encode_png(drawn.picture);
  if (const auto written = write_file(words[2], bytes); !written) {
    fmt::print(stderr, "{}\n", written.error().message);
    std::exit(1);
  }
  fmt::print(
      "{}: {:.1f} ms of CPU, {} kB\n", words[2], quantile(times_ms, 0.5), bytes.size() / 1000);
}

}  // namespace
}  // namespace mor

int main(int argc, char** argv) {
  if (argc != 6) {
    fmt::print(stderr, "usage: draw_free_view CASE OUT.png CAMERA FRAME VIEW\n");
    return 2;
  }
  mor::draw({argv, argv + argc});
}
