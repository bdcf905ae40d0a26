// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/documentation/skin_atlas.h"
#include "morgagni/documentation/texture_fusion.h"
#include "morgagni/evaluation/summary.h"
#include "morgagni/registration/fixed_surface.h"

namespace mor {

struct TextureStudyOptions {
  /// As after `simulated:`; seed, frames and speed are set by the run.
  std::string camera = "path=pass,skin=marked,exposure=0.3,clutter=hand,fps=4";
  std::uint64_t seed = 1;
  int num_frames = 400;   ///< Four a second, as a live session melts them: one pass takes 100 s.
  int fuse_every = 1;     ///< >= 1.
  int truth_every = 8;    ///< Frames that the truth is drawn from. >= 1.
  int single_every = 20;  ///< Frames that are laid onto the skin alone, for comparison. >= 1.
  /// What `clutter=` names is there in the second half of so many frames, and gone in the first.
  /// 0: it is always there; where its shadow falls all the time, the skin is dark for the texture.
  int clutter_period = 80;
  double start_error_mm = 3.0;  ///< The tracking starts so far off. >= 0.
  SkinAtlasOptions atlas;
  TextureFusionOptions fusion;

  [[nodiscard]] Result<void> check() const;
};

/// A texture, or single pictures projected onto the skin, against the truth.
struct TextureQuality {
  Summary color_difference;  ///< CIEDE2000 of the texels.
  Summary misplacement_px;   ///< Of patches of 17x17 texels.
  double within_1_px = 0.0;  ///< Share of the patches.
  std::size_t num_patches = 0;
};

struct TextureStudy {
  TextureQuality fused;
  TextureQuality single;  ///< All single pictures taken together.
  /// Fused over single, where the single picture, without its clutter, shows the skin at 80 % of
  /// its own best resolution at least: the least and the middle over the single pictures.
  double least_gradient_ratio = 0.0;
  double median_gradient_ratio = 0.0;
  double coverage = 0.0;             ///< Of the skin that could be seen (SkinCoverage).
  double coverage_of_visible = 0.0;  ///< Of what the pass's cameras could see, without clutter.
  std::size_t num_melted = 0;
  std::size_t num_offered = 0;
  std::size_t num_tracked = 0;
  Summary pose_error_mm;  ///< Of the tracker, at the skin's centre, of the frames offered.
  Summary cpu_ms;         ///< Of TextureFusion::add, thread time.
  SkinTexture texture;
  Image<Rgb8> truth;  ///< In the same atlas.
};

/// Lets the real tracker follow a simulated camera around a body whose paint is known, melts what
/// it tracked, and compares.
///
/// The truth is the skin as the pass shows it best: each texel from the true pose from which it is
/// seen finest, without noise, clutter and exposure changes, at 2.25 times the camera's resolution.
/// @errors kInvalidArgument: bad options.
[[nodiscard]] Result<TextureStudy> run_texture_study(std::shared_ptr<const FixedSurface> body,
                                                     const TextureStudyOptions& options,
                                                     const Progress& progress);

[[nodiscard]] std::string to_markdown(const TextureStudy& study);

}  // namespace mor
