// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace mor::internal {

/// Skin is floating only if the camera looks past it by so many tolerances.
inline constexpr float kFloatingTolerances = 1.2F;

/// What a picture says of the CT's skin at a pose, in parts of the skin that should be seen there.
/// Those from area_share on are of a look, not of a glance.
struct SkinAgreement {
  double num_seen = 0.0;      ///< In view, with a reading.
  double num_agree = 0.0;     ///< Measured where it should be; less the farther from there.
  double num_floating = 0.0;  ///< The camera looks through it: never so at the right pose.
  double num_hidden = 0.0;    ///< Something measured stands before it.
  double area_share = 0.0;    ///< Of all the CT's skin, what is measured well where it should be.
  /// How firmly that skin holds the pose, in the direction it holds least: mean square of what its
  /// distance changes by when the body's ends move by one, 0..1/6. A cylinder holds nothing.
  double firmness = 0.0;
  double num_patches = 0.0;  ///< How much of it, and how evenly it lies there (start_evenness.h).
  double uneven_mm = 0.0;
  double noise_mm = 0.0;     ///< Of a single reading there; standard deviation.
  double noise_share = 1.0;  ///< What is left of it in the mean of all pictures.
};

}  // namespace mor::internal
