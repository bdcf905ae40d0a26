// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// What `morgagni prepare` does after reading, on a full-size CT: the real chest of the data folder
// (138 slices of 512 x 512) with a slice between every two. Unpack its archive first:
//   tar xJf ../shared/data/ct_chest_lidc0314/lidc0314_138x2mm_dicom.tar.xz -C DIR
//   MORGAGNI_CHEST=DIR build/release/benchmarks/prepare_benchmark
#include <cstdlib>
#include <optional>

#include <benchmark/benchmark.h>

#include "morgagni/ct/surfaces.h"
#include "morgagni/ct/volume_import.h"

namespace mor {
namespace {

const std::optional<Volume>& chest() {
  static const std::optional<Volume> volume = []() -> std::optional<Volume> {
    const char* folder = std::getenv("MORGAGNI_CHEST");
    if (folder == nullptr) return std::nullopt;
    auto read = import_volume(folder, {}, {});
    if (!read) return std::nullopt;
    Volume full = *read;
    full.size[2] = 2 * read->size[2] - 1;
    full.spacing_mm.z() /= 2.0;
    full.hu.clear();
    const std::size_t slice = read->index(0, 0, 1);
    for (int z = 0; z < full.size[2]; ++z) {
      const std::int16_t* low = read->hu.data() + static_cast<std::size_t>(z / 2) * slice;
      const std::int16_t* high = low + static_cast<std::size_t>(z % 2) * slice;
      for (std::size_t i = 0; i < slice; ++i)
        full.hu.push_back(static_cast<std::int16_t>((low[i] + high[i]) / 2));
    }
    return full;
  }();
  return volume;
}

void BM_ExtractSkin(benchmark::State& state) {
  if (!chest()) state.SkipWithError("set MORGAGNI_CHEST to the unpacked chest CT");
  for (auto _ : state) {
    auto skin = extract_skin(*chest(), {.sub_sampling = static_cast<int>(state.range(0))}, {});
    benchmark::DoNotOptimize(skin);
  }
}
BENCHMARK(BM_ExtractSkin)
    ->ArgName("sub_sampling")
    ->Arg(20)
    ->Arg(100)
    ->Unit(benchmark::kSecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

void BM_ExtractBone(benchmark::State& state) {
  if (!chest()) return state.SkipWithError("set MORGAGNI_CHEST to the unpacked chest CT");
  static const Volume body = extract_skin(*chest(), {.num_vertices = 1000}, {})->body;
  for (auto _ : state) {
    auto bone = extract_bone(body, {}, {});
    benchmark::DoNotOptimize(bone);
  }
}
BENCHMARK(BM_ExtractBone)->Unit(benchmark::kSecond)->MeasureProcessCPUTime()->UseRealTime();

}  // namespace
}  // namespace mor
