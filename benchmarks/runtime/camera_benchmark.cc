// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numbers>

#include <benchmark/benchmark.h>

#include "morgagni/camera/simulated_camera.h"
#include "morgagni/camera/tum_recording.h"
#include "morgagni/geometry/depth_raster.h"

namespace mor {
namespace {

/// 20,000 vertices, 40,000 triangles, the size of a torso.
std::shared_ptr<const TriangleMesh> torso() {
  auto mesh = std::make_shared<TriangleMesh>();
  constexpr unsigned kRings = 100;
  constexpr unsigned kColumns = 200;
  for (unsigned ring = 0; ring <= kRings; ++ring) {
    for (unsigned column = 0; column < kColumns; ++column) {
      const double polar = std::numbers::pi * ring / kRings;
      const double azimuth = 2.0 * std::numbers::pi * column / kColumns;
      mesh->vertices.emplace_back(static_cast<float>(190.0 * std::sin(polar) * std::cos(azimuth)),
                                  static_cast<float>(110.0 * std::sin(polar) * std::sin(azimuth)),
                                  static_cast<float>(150.0 * std::cos(polar)));
    }
  }
  for (unsigned ring = 0; ring < kRings; ++ring) {
    for (unsigned column = 0; column < kColumns; ++column) {
      const unsigned next = (column + 1) % kColumns;
      const unsigned a = ring * kColumns + column;
      const unsigned b = ring * kColumns + next;
      mesh->triangles.push_back({a, a + kColumns, b});
      mesh->triangles.push_back({b, a + kColumns, b + kColumns});
    }
  }
  return mesh;
}

void BM_RasterizeDepth(benchmark::State& state) {
  const auto skin = torso();
  const auto camera = SimulatedCamera::create(skin, {}).value();
  const auto camera_from_ct = camera->ct_from_camera(0).inverse();
  for (auto _ : state) {
    benchmark::DoNotOptimize(rasterize_depth(*skin, camera->calibration().depth, camera_from_ct));
  }
}
BENCHMARK(BM_RasterizeDepth)->Unit(benchmark::kMillisecond);

void BM_SimulatedFrame(benchmark::State& state) {
  const auto camera = SimulatedCamera::create(torso(), {.has_noise = state.range(0) == 1}).value();
  std::uint64_t frame_id = 0;
  for (auto _ : state) benchmark::DoNotOptimize(camera->frame_at(frame_id++));
}
BENCHMARK(BM_SimulatedFrame)->ArgName("noise")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

/// Everything in the way: hand, towel, parts, on a path and made anew for every view.
void BM_ClutteredFrame(benchmark::State& state) {
  const auto path = state.range(0) == 1 ? SimulatedPath::kViews : SimulatedPath::kOrbit;
  const auto camera =
      SimulatedCamera::create(torso(), {.path = path, .clutter = SimulatedClutter::kAll}).value();
  std::uint64_t frame_id = 0;
  for (auto _ : state) benchmark::DoNotOptimize(camera->frame_at(frame_id++));
}
BENCHMARK(BM_ClutteredFrame)->ArgName("views")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

void BM_ReadRecordedFrame(benchmark::State& state) {
  const auto recording = TumRecording::open(MORGAGNI_DATA_DIR "/synthetic_rgbd/head_seq");
  if (!recording) {
    state.SkipWithError(recording.error().message.c_str());
    return;
  }
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(recording->read(i++ % recording->size()));
}
BENCHMARK(BM_ReadRecordedFrame)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mor
