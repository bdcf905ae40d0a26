// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include "morgagni/depth/body_surface.h"

#include "torso_scene.h"

namespace mor {
namespace {

void extract(benchmark::State& state, const Image<std::uint16_t>& depth) {
  auto extractor = *BodySurfaceExtractor::create(
      torso_camera(), {.down_sampling = static_cast<double>(state.range(0)) / 100.0});
  std::size_t num_points = 0;
  for (auto _ : state) {
    const auto surface = extractor.extract(depth.view());
    num_points = surface->cloud.size();
    benchmark::DoNotOptimize(num_points);
  }
  state.counters["points"] = static_cast<double>(num_points);
}

/// A torso that fills about a third of the picture; down-sampling in hundredths.
void BM_BodySurfaceOfTorso(benchmark::State& state) {
  extract(state, torso_depth(torso_mesh()));
}

/// A tilted wall: every pixel is part of the surface, the most that can happen.
void BM_BodySurfaceOfWall(benchmark::State& state) {
  Image<std::uint16_t> depth(640, 480);
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width(); ++x) {
      depth(x, y) = static_cast<std::uint16_t>(700 + x / 8 + (x * 7 + y * 3) % 3);
    }
  }
  extract(state, depth);
}

BENCHMARK(BM_BodySurfaceOfTorso)
    ->ArgName("down_sampling_pct")
    ->Arg(100)
    ->Arg(200)
    ->Arg(250)
    ->Arg(400)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(BM_BodySurfaceOfWall)
    ->ArgName("down_sampling_pct")
    ->Arg(100)
    ->Arg(250)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mor
