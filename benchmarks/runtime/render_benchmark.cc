// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// How long a picture takes. The wall time counts the renderer's own threads; with --benchmark's CPU
// column only the calling thread, so the process's CPU time stands beside it.
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include "morgagni/render/overlay_renderer.h"
#include "morgagni/render/skin_view.h"
#include "morgagni/render/testing/shapes.h"

#include "chest_scene.h"

namespace mor {
namespace {

double process_cpu_ms() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto ms = [](const timeval& time) { return time.tv_sec * 1e3 + time.tv_usec * 1e-3; };
  return ms(usage.ru_utime) + ms(usage.ru_stime);
}

void run(benchmark::State& state, const OverlayView& view, const RenderScene& scene) {
  const auto renderer = OverlayRenderer::create(scene);
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
  run(state,
      view_of(static_cast<int>(state.range(0)), static_cast<int>(state.range(1))),
      scene_of(1, nullptr));
}

/// 120,000 triangles in three structures, all of them transparent.
void BM_GlassInHole(benchmark::State& state) {
  OverlayView view = view_of(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  view.structure_opacity = {{"bones0", 0.4F}, {"bones1", 0.5F}, {"bones2", 0.6F}};
  run(state, view, scene_of(3, nullptr));
}

/// The bones with a camera's depth picture in which a hand covers a part of the hole.
void BM_HandInFront(benchmark::State& state) {
  OverlayView view = view_of(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  Image<std::uint16_t> depth(640, 480, 370);
  for (int y = 0; y < 300; ++y) std::fill_n(&depth(280, y), 90, std::uint16_t{300});
  view.measured = MeasuredDepth{depth.view(), {640, 480, 525.0, 525.0, 319.5, 239.5, {}}, {}};
  view.measured->color_from_depth.setIdentity();
  run(state, view, scene_of(1, nullptr));
}

void BM_SliceInHole(benchmark::State& state) {
  OverlayView view = view_of(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  view.slice = {.plane = SlicePlane::kCamera, .depth_mm = 60.0F};
  run(state, view, scene_of(1, chest_ct()));
}

/// @param state  Width, height, preset, the hole's height in per cent of the picture's (0: all of
/// it), 1 for a still picture.
void BM_Volume(benchmark::State& state) {
  OverlayView view = view_of(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  const auto preset = static_cast<VolumePreset>(state.range(2));
  view.volume = {preset, volume_window(preset).level_hu, volume_window(preset).window_hu};
  view.hole.radius = state.range(3) == 0 ? 2.0F : 0.005F * static_cast<float>(state.range(3));
  view.is_still = state.range(4) == 1;
  RenderScene scene = scene_of(0, chest_ct());
  scene.skin = {};
  run(state, view, scene);
  state.SetLabel(std::string(to_string(preset)));
}

void BM_Ghost(benchmark::State& state) {
  OverlayView view = view_of(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  view.color_from_ghost = std::exchange(view.color_from_ct, std::nullopt);
  run(state, view, scene_of(1, nullptr));
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
BENCHMARK(BM_GlassInHole)
    ->ArgNames({"width", "height"})
    ->Args({640, 480})
    ->Args({1280, 720})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(BM_HandInFront)
    ->ArgNames({"width", "height"})
    ->Args({640, 480})
    ->Args({1280, 720})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(BM_SliceInHole)
    ->ArgNames({"width", "height"})
    ->Args({640, 480})
    ->Args({1280, 720})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(BM_Volume)
    ->ArgNames({"width", "height", "preset", "hole_pct", "still"})
    ->ArgsProduct({{640}, {480}, {1, 2, 3, 4, 5}, {50}, {0, 1}})
    ->ArgsProduct({{640}, {480}, {1, 2, 3, 4, 5}, {0}, {0, 1}})
    ->ArgsProduct({{1280}, {720}, {1, 2}, {0}, {0, 1}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(BM_Ghost)
    ->ArgNames({"width", "height"})
    ->Args({640, 480})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(BM_SkinView)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mor
