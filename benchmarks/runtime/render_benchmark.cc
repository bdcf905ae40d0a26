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

/// A chest's CT in code, 512 x 512 x 275 voxels of 0.7 x 0.7 x 1 mm: fat and muscle around lungs
/// with vessels, ribs, a spine and a heart with contrast.
std::shared_ptr<const Volume> chest_ct() {
  static const auto kChest = [] {
    auto volume = std::make_shared<Volume>();
    volume->size = {512, 512, 275};
    volume->spacing_mm = {0.7, 0.7, 1.0};
    volume->ct_from_grid.translation() = Eigen::Vector3d(-178.9, -178.9, -137.0);
    volume->hu.reserve(512U * 512U * 275U);
    for (int z = 0; z < 275; ++z) {
      for (int y = 0; y < 512; ++y) {
        for (int x = 0; x < 512; ++x) {
          const double px = 0.7 * x - 178.9;
          const double py = 0.7 * y - 178.9;
          const double pz = z - 137.0;
          const double wall = std::hypot(px / 170.0, py / 115.0);
          double hu = wall > 1.0 ? kOutsideHu : wall > 0.93 ? -90.0 : 50.0;
          const double rib = std::remainder(pz + 0.3 * py, 26.0);
          if (std::abs(wall - 0.84) < 0.035 && std::abs(rib) < 5.5) hu = 500.0;
          if (wall < 0.78) hu = -820.0 + 60.0 * std::sin(0.9 * px) * std::sin(0.8 * py + 0.7 * pz);
          if (std::hypot(px, py - 80.0) < 22.0) hu = 420.0;
          if (Eigen::Vector3d(px - 25.0, py + 30.0, pz).norm() < 50.0) hu = 180.0;
          volume->hu.push_back(static_cast<std::int16_t>(hu));
        }
      }
    }
    return volume;
  }();
  return kChest;
}

RenderScene scene_of(std::size_t num_structures, std::shared_ptr<const Volume> volume) {
  RenderScene scene;
  scene.skin = testing::make_sphere(Eigen::Vector3d::Zero(), 140.0, 100);
  scene.volume = std::move(volume);
  for (std::size_t i = 0; i < num_structures; ++i) {
    TriangleMesh mesh = testing::make_bones(kNumTriangles);
    for (auto& vertex : mesh.vertices) vertex *= 1.0F - 0.2F * static_cast<float>(i);
    scene.structures.push_back({"bones" + std::to_string(i), std::move(mesh)});
  }
  return scene;
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
