// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// Things laid against the body of a real CT: how far the skin is from where it is without them.
// Seeds that nothing was tuned on; many more are in BENCHMARK.md (build/release/bin/covers).
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "morgagni/ct/internal/body_mask.h"
#include "morgagni/ct/internal/components.h"
#include "morgagni/ct/internal/marching_cubes.h"
#include "morgagni/ct/internal/uncovering.h"
#include "morgagni/ct/testing/cover_scenes.h"
#include "morgagni/ct/volume_import.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

constexpr double kThresholdHu = -300.0;

Result<Volume> head() {
  return import_volume(
      fs::path(MORGAGNI_DATA_DIR) / "ct_head_invesalius/promed_ct_0051.nii.gz", {}, {});
}

struct Off {
  testing_covers::Distances lost;
  testing_covers::Distances gained;
};

/// Of the skin found under the cover from the bare skin, near the cover.
Off skin_off(const testing_covers::BareBody& bare,
             const testing_covers::Covered& scene,
             const std::string& name) {
  const auto uncovered = internal::bare_ct(scene.volume);
  const auto found = internal::body_mask(scene.volume, uncovered, {}, {});
  EXPECT_TRUE(found) << found.error().message;
  if (!found) return {};
  const Volume& seen = uncovered.volume ? *uncovered.volume : scene.volume;
  const auto skin = internal::marching_cubes(seen, found->body, kThresholdHu);
  const Off off = {testing_covers::distances_at(bare.skin, skin, scene),
                   testing_covers::distances_at(skin, bare.skin, scene)};
  EXPECT_GT(off.lost.num, 500U) << name;
  std::cout << name;
  for (const auto& [what, way] : {std::pair("lost", off.lost), {"gained", off.gained}})
    std::cout << "; " << what << " median " << way.median_mm << " p95 " << way.p95_mm << " p99 "
              << way.p99_mm << " max " << way.max_mm;
  std::cout << " mm\n";
  return off;
}

void expect_within(const testing_covers::BareBody& bare,
                   const std::string& kind,
                   unsigned seed,
                   double median_mm,
                   double p95_mm) {
  const auto off = skin_off(bare, testing_covers::covered(bare, kind, seed), kind);
  for (const auto& way : {off.lost, off.gained}) {
    EXPECT_LE(way.median_mm, median_mm) << kind;
    EXPECT_LE(way.p95_mm, p95_mm) << kind;
  }
}

TEST(RealCovers, LeaveTheSkinOfAHead) {
  constexpr unsigned kSeed = 31;
  const auto ct = head();
  if (!ct) GTEST_SKIP() << ct.error().message;
  const auto bare = testing_covers::bare_body(*ct);
  for (const auto* kind :
       {"blanket-400", "blanket-300", "blanket-150", "flat-300", "flat-150", "plaster", "clothing"})
    expect_within(bare, kind, kSeed, 0.35, 1.0);
  expect_within(bare, "mattress", kSeed, 0.6, 1.0);
  // A shell with a skin's HU is followed from where it is free; ears touch it.
  expect_within(bare, "headrest", kSeed, 0.3, 1.5);
  // As dense as flesh and half as much again, with noise: less sure.
  expect_within(bare, "silicone", kSeed, 0.8, 2.0);
}

/// An error where the data folder has no such archive.
Result<Volume> archived(const std::string& name) {
  const auto archive = fs::path(MORGAGNI_DATA_DIR) / name;
  if (!fs::exists(archive)) return make_error(ErrorCode::kNotFound, "no " + archive.string());
  const auto folder = fs::temp_directory_path() / ("morgagni_covers_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  const std::string command = "tar xJf '" + archive.string() + "' -C '" + folder.string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0);
  auto ct = import_volume(folder, {}, {});
  fs::remove_all(folder);
  EXPECT_TRUE(ct) << ct.error().message;
  return ct;
}

Result<Volume> chest() {
  return archived("ct_chest_lidc0314/lidc0314_138x2mm_dicom.tar.xz");
}

TEST(RealCovers, LeaveTheSkinOfAChest) {
  constexpr unsigned kSeed = 31;
  const auto ct = chest();
  if (!ct) GTEST_SKIP() << ct.error().message;
  const auto bare = testing_covers::bare_body(*ct);
  expect_within(bare, "blanket-300", kSeed, 0.35, 1.0);
  expect_within(bare, "flat-150", kSeed, 0.35, 1.3);
  expect_within(bare, "clothing", kSeed, 0.35, 1.0);
}

/// As scanned: a body that something was already taken off could not tell.
TEST(RealCovers, NothingOfABodyIsATube) {
  const auto tilted_head = archived("ct_head_tilt_ge/ge_head_tilt18_dicom.tar.xz");
  const auto bunny =
      import_volume(fs::path(MORGAGNI_DATA_DIR) / "bunny/bunny_ct_half.nii.gz", {}, {});
  for (const auto& ct : {head(), chest(), tilted_head, bunny}) {
    if (!ct) GTEST_SKIP() << ct.error().message;
    EXPECT_EQ(internal::bare_ct(*ct).tube.count(), 0U) << ct->description;
  }
}

/// A headrest's shell of 3 mm, at a slant, that presses the ear flat where it lies against it.
TEST(RealCovers, AnEarPressedFlatStays) {
  const auto ct = head();
  if (!ct) GTEST_SKIP() << ct.error().message;
  auto bare = testing_covers::bare_body(*ct);
  Volume& alone = bare.volume;
  constexpr double kPressedMm = 2.0;
  constexpr double kShellMm = 3.0;
  constexpr double kShellHu = 100.0;
  const Eigen::Vector3d outwards = Eigen::Vector3d(1.0, 0.15, 0.075).normalized();
  const auto place_of = [&](int x, int y, int z) -> Eigen::Vector3d {
    return alone.ct_from_grid * Eigen::Vector3d(x, y, z).cwiseProduct(alone.spacing_mm);
  };
  const auto for_each = [&](const auto& visit) {
    for (int z = 0; z < alone.size[2]; ++z)
      for (int y = 0; y < alone.size[1]; ++y)
        for (int x = 0; x < alone.size[0]; ++x) visit(x, y, z, place_of(x, y, z));
  };
  const double ear_mm = bare.skin.bounds().max().x();
  const double front_mm = bare.skin.bounds().min().y();
  double farthest_mm = -1e9;
  for_each([&](int x, int y, int z, const Eigen::Vector3d& place) {
    if (bare.body.test(x, y, z) && place.x() > ear_mm - 25.0)
      farthest_mm = std::max(farthest_mm, outwards.dot(place));
  });
  const auto beyond_mm = [&](const Eigen::Vector3d& place) {
    return outwards.dot(place) - (farthest_mm - kPressedMm);
  };
  for_each([&](int x, int y, int z, const Eigen::Vector3d& place) {
    auto& hu = alone.hu[alone.index(x, y, z)];
    const double share = std::clamp(beyond_mm(place) / alone.spacing_mm.x() + 0.5, 0.0, 1.0);
    hu = static_cast<std::int16_t>(std::lround((1.0 - share) * hu - 1000.0 * share));
  });
  bare.body = internal::body_mask(alone, internal::bare_ct(alone), {}, {}).value().body;
  bare.skin = internal::marching_cubes(alone, bare.body, kThresholdHu);
  testing_covers::Covered scene = {alone, internal::BitMask(alone.size)};
  for_each([&](int x, int y, int z, const Eigen::Vector3d& place) {
    const double mm = beyond_mm(place);
    if (mm <= 0.0 || mm >= kShellMm || place.y() <= front_mm + 40.0) return;
    auto& hu = scene.volume.hu[alone.index(x, y, z)];
    const double air = std::clamp((40.0 - hu) / 1040.0, 0.0, 1.0);
    hu = static_cast<std::int16_t>(std::lround(hu + air * (1000.0 + kShellHu)));
    scene.cover.set_run(y, z, x, x + 1);
  });
  constexpr double kAroundMm = 4.0;  // The ear, not only what the shell touches of it.
  scene.cover = dilated(scene.cover, kAroundMm, alone.spacing_mm);
  const auto off = skin_off(bare, scene, "shell against an ear");
  for (const auto& way : {off.lost, off.gained}) {
    EXPECT_LT(way.p99_mm, 1.0);
    EXPECT_LT(way.max_mm, 2.0);
  }
}

}  // namespace
}  // namespace mor
