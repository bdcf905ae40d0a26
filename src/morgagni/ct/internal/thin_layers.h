// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "morgagni/ct/internal/skin_profiles.h"

namespace mor::internal {

/// What of a surface is no skin, but a thin layer: over it, or lifted off it. Of each profile.
struct ThinLayers {
  std::vector<float> thick_mm;     ///< How thick the layer is that is to be taken off; 0: none.
  std::vector<char> is_lifted;     ///< There is air beneath it.
  std::vector<char> is_sheet;      ///< It is as thick all over, and ends with a rim.
  std::vector<float> unknown_mm;   ///< How thick a layer may go on here unseen; 0: none is near.
  BitMask foam;                    ///< Whose cover is taken off, near to the surface; or empty.
  std::vector<std::size_t> asked;  ///< Where one was taken off because somebody asked for it.
  std::vector<Eigen::Vector3f> not_found_mm;  ///< Places asked for at which there was none.
};

/// Looks for layers whose profile no skin has.
///
/// - Lifted: within 5 mm there is air again, and over some area the sheet is as even as no ear is,
///   or thinner, or lighter.
/// - Light, on the skin: the HU rise in two steps, from air to cloth and from cloth to skin.
/// - A lifted sheet followed to where it lies on the skin: as far as its outer half looks the same;
///   the cover of a foam wherever this foam lies outside (foam_cover()); one that has a skin's HU
///   as far as it can be told from this skin (sheet_places()).
///
/// One that cannot be told (a tube's wall, a shell as dense as the skin) is left.
/// @param take_off_mm  Places, as SkinProfile::place_mm: the whole stretch of `unknown_mm` that is
///                     nearest to each is taken off, with the lifted sheet that it comes of.
[[nodiscard]] ThinLayers thin_layers(const Volume& volume,
                                     const SkinProfiles& profiles,
                                     const std::vector<Eigen::Vector3f>& take_off_mm = {});

}  // namespace mor::internal
