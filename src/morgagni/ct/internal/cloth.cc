// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/cloth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "morgagni/ct/internal/components.h"
#include "morgagni/ct/internal/skin_profiles.h"
#include "morgagni/ct/internal/smoothed_threshold.h"
#include "morgagni/ct/internal/uncovering.h"

namespace mor::internal {
namespace {

/// Between air and the lightest cloth, which may be lighter than SkinProfile::kEdgeHu.
constexpr float kEdgeHu = -550.0F;
constexpr float kLightestHu = -450.0F;
constexpr float kDensestHu = -95.0F;
/// Smaller pieces are noise.
constexpr double kLeastMm2 = 400.0;
/// What is lighter in the mean is no fat: there the way inwards needs no end.
constexpr double kLightestFatHu = -140.0;
constexpr double kSkinHu = 20.0;

/// Cloth that has air beneath it.
struct Piece {
  std::vector<std::size_t> places;
  double hu = 0.0;  ///< In the middle.
  bool is_over_body = false;
};

BitMask air_outside(const Volume& volume) {
  const Components air(threshold(volume, -32768.0, kEdgeHu - 0.5));
  return air.select([&](std::size_t i) { return air.parts()[i].at_side; });
}

/// The most of what has air beneath it and is as light as cloth; none where nothing is.
std::optional<float> lifted_hu(const SkinProfile& profile) {
  constexpr int kLast = 12;  // 6 mm.
  float most_hu = profile.at(0);
  for (int step = 1; step <= kLast; ++step) {
    if (profile.at(step) < std::min(kEdgeHu, profile.at(step - 1))) {
      if (most_hu > kLightestHu && most_hu < kDensestHu) return most_hu;
      return std::nullopt;
    }
    most_hu = std::max(most_hu, profile.at(step));
  }
  return std::nullopt;
}

/// Beneath a third of its places flesh is seen, and outside of most is air: no cover of a headrest
/// or of a mattress, whose own foam is beneath or around it.
bool is_over_body(const SkinProfiles& profiles, const std::vector<std::size_t>& places) {
  constexpr double kLeastOver = 1.0 / 3.0;
  constexpr int kBeneath = SkinProfile::kZero + 4;
  constexpr float kLeastFoamHu = -960.0F;
  constexpr float kMostFoamHu = -760.0F;
  double num_over = 0.0;
  std::vector<float> outside;
  for (const std::size_t i : places) {
    const auto& hu = profiles.all()[i].hu;
    if (*std::max_element(hu.begin() + kBeneath, hu.end()) > kDensestHu) ++num_over;
    outside.push_back((hu[0] + hu[1] + hu[2]) / 3.0F);
  }
  const auto middle = outside.begin() + static_cast<std::ptrdiff_t>(outside.size() / 2);
  std::nth_element(outside.begin(), middle, outside.end());
  return num_over >= kLeastOver * static_cast<double>(places.size()) &&
         (*middle <= kLeastFoamHu || *middle >= kMostFoamHu);
}

std::vector<Piece> lifted_pieces(const SkinProfiles& profiles) {
  constexpr float kAlikeHu = 60.0F;
  const std::size_t num = profiles.all().size();
  std::vector<std::optional<float>> hu(num);
  for (std::size_t i = 0; i < num; ++i)
    if (profiles.all()[i].area_mm2 > 0.0F) hu[i] = lifted_hu(profiles.all()[i]);
  std::vector<Piece> pieces;
  std::vector<char> seen(num);
  for (std::size_t i = 0; i < num; ++i) {
    if (seen[i] != 0 || !hu[i]) continue;
    auto places = profiles.region(i, seen, [&](std::size_t from, std::size_t to) {
      return hu[to] && std::abs(*hu[to] - *hu[from]) < kAlikeHu;
    });
    if (profiles.area_mm2(places) < kLeastMm2) continue;
    std::vector<float> all;
    for (const std::size_t k : places) all.push_back(*hu[k]);
    const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
    std::nth_element(all.begin(), middle, all.end());
    const bool is_over = is_over_body(profiles, places);
    pieces.push_back({std::move(places), *middle, is_over});
  }
  return pieces;
}

/// Of the pieces over a body; none: there are none.
std::optional<double> cloth_hu(const std::vector<Piece>& pieces) {
  double sum = 0.0;
  double num = 0.0;
  for (const Piece& piece : pieces) {
    if (!piece.is_over_body) continue;
    sum += piece.hu * static_cast<double>(piece.places.size());
    num += static_cast<double>(piece.places.size());
  }
  if (num == 0.0) return std::nullopt;
  return sum / num;
}

/// As far as the cloth may go on from where it is off the skin, from fold to fold.
BitMask around(const std::vector<Piece>& pieces,
               double hu,
               const SkinProfiles& profiles,
               const Volume& volume) {
  constexpr double kAlikeHu = 60.0;
  constexpr double kStepMm = 6.0;
  constexpr int kNumSteps = 7;
  BitMask where(volume.size);
  for (const Piece& piece : pieces)
    if (piece.is_over_body || std::abs(piece.hu - hu) <= kAlikeHu)
      where |= profiles.voxels_of(piece.places, volume);
  for (int step = 0; step < kNumSteps; ++step) where = dilated(where, kStepMm, volume.spacing_mm);
  return where;
}

/// From the air outside through all that is light. Not through passages into the body, and where
/// cloth may be taken for fat only so deep.
BitMask reached(const Volume& volume, const BitMask& outside, const BitMask& where, double hu) {
  constexpr double kPassageMm = 2.4;
  constexpr int kDeepVoxels = 2;
  constexpr double kNoLeastHu = -32768.0;
  const double middle_hu = 0.5 * (hu + kSkinHu);
  BitMask light =
      smoothed_threshold(volume, where, kNoLeastHu, std::min(middle_hu, kLightestFatHu));
  light |= outside;
  light = opened(light, kPassageMm, volume.spacing_mm);
  const Components parts(light);
  const auto open = parts.overlap(outside);
  BitMask cloth = parts.select([&](std::size_t i) { return open[i] > 0; });
  cloth &= where;
  if (middle_hu <= kLightestFatHu) return cloth;
  const BitMask lighter = smoothed_threshold(volume, where, kNoLeastHu, middle_hu);
  for (int step = 0; step < kDeepVoxels; ++step) {
    BitMask next = dilated(cloth, 1.0, Eigen::Vector3d::Ones());
    next &= lighter;
    cloth |= next;
  }
  return cloth;
}

}  // namespace

BitMask take_cloth_off(Volume& volume, const BitMask& settled) {
  const BitMask outside = air_outside(volume);
  BitMask solid = outside;
  solid.invert();
  const SkinProfiles profiles(volume, solid, kEdgeHu);
  const auto pieces = lifted_pieces(profiles);
  const auto hu = cloth_hu(pieces);
  if (!hu) return BitMask(volume.size);
  BitMask where = around(pieces, *hu, profiles, volume);
  where.subtract(settled);
  const BitMask cloth = reached(volume, outside, where, *hu);
  BitMask taken = cloth;
  taken &= threshold(volume, SkinProfile::kEdgeHu, 32767.0);
  volume = uncovered(volume, cloth, *hu);
  return taken;
}

}  // namespace mor::internal
