// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// How long a picture takes. The wall time counts the renderer's own threads; with --benchmark's CPU
// column only the calling thread, so the process's CPU time stands beside it.
#include <stdexcept>

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include "morgagni/render/overlay_renderer.h"
#include "morgagni/render/skin_view.h"
#include "morgagni/render/testing/shapes.h"

namespace mor {
namespace {

constexpr std::size_t kNumTriangles = 40000;

double process_cpu_ms() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto ms = [](const timeval& time) { return time.tv_sec * 1e3 + time.tv_usec * 1e-3; };
  return ms(usage.ru_utime) + ms(usage.ru_stime);
}

OverlayView view_of(int width_px, int height_px) {
  const double focal_px = 525.0 * height_px / 480.0;
  OverlayView view;
  view.color_camera = {width_px,
                       height_px,
                       focal_px,
                       focal_px,
                       0.5 * (width_px - 1),
                       0.5 * (height_px - 1),
                       {0.05, -0.1, 0.0, 0.0, 0.0}};
  // From the front: the body's long axis is upright on the picture.
  Eigen::Isometry3d color_from_ct = Eigen::Isometry3d::Identity();
  color_from_ct.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  color_from_ct.translation() = Eigen::Vector3d(0.0, 0.0, 500.0);
  view.color_from_ct = color_from_ct;
  return view;
}

void run(benchmark::State& state, const OverlayView& view) {
  const TriangleMesh skin = testing::make_sphere(Eigen::Vector3d::Zero(), 140.0, 100);
  const auto renderer =
      OverlayRenderer::create({{"bones", testing::make_bones(kNumTriangles)}}, skin);
  if (!renderer) throw std::runtime_error(renderer.error().message);
  const Image<Rgb8> color(view.color_camera.width_px, view.color_camera.height_px, {90, 80, 70});
  benchmark::DoNotOptimize((*renderer)->render(color.view(), view));
  const double cpu_before_ms = process_cpu_ms();
  for (auto _ : state) {
    benchmark::DoNotOptimize((*renderer)->render(color.view(), view));
  }
  state.counters["process_cpu_ms"] =
      (process_cpu_ms() - cpu_before_ms) / static_cast<double>(state.iterations());
  state.SetLabel((*renderer)->device());
}

void BM_BonesInHole(benchmark::State& state) {
  run(state, view_of(static_cast<int>(state.range(0)), static_cast<int>(state.range(1))));
}

void BM_Ghost(benchmark::State& state) {
  OverlayView view = view_of(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  view.color_from_ghost = std::exchange(view.color_from_ct, std::nullopt);
  run(state, view);
}

void BM_SkinView(benchmark::State& state) {
  const TriangleMesh skin = testing::make_sphere(Eigen::Vector3d::Zero(), 140.0, 100);
  for (auto _ : state) benchmark::DoNotOptimize(draw_skin_view(skin, {.yaw_rad = 0.3}));
}

BENCHMARK(BM_BonesInHole)
    ->ArgNames({"width", "height"})
    ->Args({640, 480})
    ->Args({1280, 720})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Repetitions(15)
    ->MinTime(0.1);
BENCHMARK(BM_Ghost)
    ->ArgNames({"width", "height"})
    ->Args({640, 480})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(BM_SkinView)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mor
