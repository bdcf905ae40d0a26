// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/foam_cover.h"

#include <numeric>

#include "morgagni/ct/internal/components.h"
#include "morgagni/ct/internal/smoothed_threshold.h"

namespace mor::internal {
namespace {

/// So far outside of the surface foam is looked for.
constexpr double kOutsideMm = 4.0;

/// The foam that a sheet is the cover of, along the whole surface.
BitMask foam_outside(const Volume& volume, const SkinProfiles& profiles, const LiftedSheet& sheet) {
  constexpr double kAirHu = -1000.0;
  constexpr double kRimMm = 2.0;  // The surface's own voxels, half air, look alike.
  constexpr double kBesideMm = 1.0;
  std::vector<std::size_t> all(profiles.all().size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const auto near = [&](const std::vector<std::size_t>& places) {
    return dilated(profiles.voxels_of(places, volume), kOutsideMm + kBesideMm, volume.spacing_mm);
  };
  const double most_off_hu = 0.5 * (sheet.outside_hu - kAirHu);
  const BitMask foam =
      opened(smoothed_threshold(
                 volume, near(all), sheet.outside_hu - most_off_hu, sheet.outside_hu + most_off_hu),
             kRimMm,
             volume.spacing_mm);
  const Components parts(foam);
  const auto beside = parts.overlap(near(sheet.places));
  return parts.select([&](std::size_t i) { return beside[i] > 0; });
}

}  // namespace

FoamCover foam_cover(const Volume& volume, const SkinProfiles& profiles, const LiftedSheet& sheet) {
  constexpr float kSeekMm = 0.5F;
  FoamCover cover = {{}, foam_outside(volume, profiles, sheet)};
  const auto is_under = [&](const SkinProfile& profile) {
    for (float mm = 0.0F; mm <= static_cast<float>(kOutsideMm); mm += kSeekMm) {
      const Eigen::Vector3i at =
          volume.nearest_voxel((profile.place_mm - mm * profile.inwards).cast<double>());
      if (at.minCoeff() >= 0 && at.x() < volume.size[0] && at.y() < volume.size[1] &&
          at.z() < volume.size[2] && cover.foam.test(at.x(), at.y(), at.z()))
        return true;
    }
    return false;
  };
  for (std::size_t i = 0; i < profiles.all().size(); ++i)
    if (profiles.all()[i].area_mm2 > 0.0F && is_under(profiles.all()[i])) cover.places.push_back(i);
  return cover;
}

}  // namespace mor::internal
