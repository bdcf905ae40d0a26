// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/camera/range_camera.h"
#include "morgagni/core/image.h"
#include "morgagni/documentation/skin_texture.h"

namespace mor::internal {

/// A place of the skin and its texel. Found anew here, for what judges a texture must not share the
/// code that made it.
struct AtlasPlace {
  std::uint32_t pixel = 0;
  Eigen::Vector3f at_mm;
  Eigen::Vector3f normal;
};
[[nodiscard]] std::vector<AtlasPlace> atlas_places(const SkinAtlas& atlas);

/// Colours in an atlas, where there are any.
struct AtlasPicture {
  Image<Eigen::Vector3f> color;
  Image<float> quality;  ///< Picture px a mm of skin; 0: no colour.

  [[nodiscard]] bool has(int x, int y) const { return quality(x, y) > 0.0F; }
};
[[nodiscard]] AtlasPicture empty_picture(const SkinAtlas& atlas);

/// Lays one picture onto the skin: every place that faces the camera within 70 degrees and that no
/// skin hides, by nothing but projection. Takes a place where it shows it finer than `picture` has
/// it.
void project_onto(const RgbdFrame& frame,
                  const Eigen::Isometry3d& color_from_ct,
                  const SkinAtlas& atlas,
                  const std::vector<AtlasPlace>& places,
                  AtlasPicture& picture);

[[nodiscard]] AtlasPicture as_picture(const SkinTexture& texture);

/// How one picture of the atlas compares with the true one.
struct AtlasComparison {
  std::size_t num_texels = 0;            ///< Both have.
  std::vector<double> color_difference;  ///< CIEDE2000, a texel.
  std::vector<double> misplacement_px;   ///< A patch of 17x17 texels with enough in it.
};

/// Colours are compared after one gain a channel for the whole picture: no camera knows its
/// absolute exposure. Misplacement is the shift that lays a patch onto the truth (Lucas and
/// Kanade).
[[nodiscard]] AtlasComparison compare_pictures(const AtlasPicture& picture,
                                               const AtlasPicture& truth);

/// Sum of squared steps of brightness between neighbouring texels that `a` and `b` both have, of
/// each, after b's gain to a's brightness. Only where `b` has at least `least_quality`.
struct GradientEnergy {
  double of_a = 0.0;
  double of_b = 0.0;
  std::size_t num_steps = 0;
};
[[nodiscard]] GradientEnergy gradient_energy(const AtlasPicture& a,
                                             const AtlasPicture& b,
                                             float least_quality);

}  // namespace mor::internal
