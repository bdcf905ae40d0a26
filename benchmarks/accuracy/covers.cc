// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// Lays covers over the body of a real CT and prints, as a Markdown table, how far the skin that is
// found then lies from the skin without them.
//
//   covers CT [SEED [NUM_SEEDS [KIND...]]]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "morgagni/ct/surfaces.h"
#include "morgagni/ct/testing/cover_scenes.h"
#include "morgagni/ct/volume_import.h"

namespace {

using namespace mor;

double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void print(const testing_covers::Distances& off) {
  std::printf(" %.2f / %.2f / %.2f / %.1f | %.1f |",
              off.median_mm,
              off.p95_mm,
              off.p99_mm,
              off.max_mm,
              100.0 * off.share_above_1mm);
}

void print_row(const testing_covers::BareBody& bare, const std::string& kind, unsigned seed) {
  const auto scene = testing_covers::covered(bare, kind, seed);
  constexpr SkinOptions kQuick = {.num_vertices = 2000, .sub_sampling = 1};
  const double start_s = cpu_s();
  const auto skin = extract_skin(scene.volume, kQuick, {});
  const double took_s = cpu_s() - start_s;
  std::printf("| %s %u |", kind.c_str(), seed);
  if (!skin) {
    std::printf(" %s |\n", skin.error().message.c_str());
    return;
  }
  print(testing_covers::distances_at(bare.skin, skin->full, scene));
  print(testing_covers::distances_at(skin->full, bare.skin, scene));
  for (std::size_t i = 0; i < skin->preview.cut.size() && i < 3; ++i) {
    const auto& part = skin->preview.cut[i];
    std::printf("%s %s %.0f ml", i > 0 ? "," : "", part.place.c_str(), part.volume_ml);
  }
  std::printf(" | %.1f |\n", took_s);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fputs("usage: covers CT [SEED [NUM_SEEDS [KIND...]]]\n", stderr);
    return 2;
  }
  const auto all_kinds = testing_covers::cover_kinds();
  std::vector<std::string> kinds(argv + std::min(argc, 4), argv + argc);
  for (const auto& kind : kinds) {
    if (std::find(all_kinds.begin(), all_kinds.end(), kind) != all_kinds.end()) continue;
    fmt::print(stderr, "KIND must be one of {}, got \"{}\"\n", fmt::join(all_kinds, ", "), kind);
    return 2;
  }
  if (kinds.empty()) kinds = all_kinds;
  const auto ct = import_volume(argv[1], {}, {});
  if (!ct) {
    std::fprintf(stderr, "%s\n", ct.error().message.c_str());
    return 1;
  }
  const auto first = static_cast<unsigned>(argc > 2 ? std::atoi(argv[2]) : 1);
  const auto num = static_cast<unsigned>(argc > 3 ? std::atoi(argv[3]) : 1);
  const auto bare = testing_covers::bare_body(*ct);
  std::puts(
      "| cover, seed | lost: median / 95 % / 99 % / max mm | > 1 mm, % | gained: the same | > 1 "
      "mm, % | cut | s of CPU |\n|---|---|---|---|---|---|---|");
  for (const auto& kind : kinds)
    for (unsigned seed = first; seed < first + num; ++seed) print_row(bare, kind, seed);
  return 0;
}
