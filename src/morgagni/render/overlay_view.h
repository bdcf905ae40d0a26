// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/render/volume_preset.h"

namespace mor {

/// The circle in which the inside is shown; around it the colour picture stays as it is.
struct Hole {
  Eigen::Vector2f center = {0.5F, 0.5F};  ///< Share of the picture's width and height.
  float radius =
      0.35F;  ///< Share of the picture's height. 0: no hole, nothing is shown. >= 2: everywhere.
  float rim = 0.02F;  ///< Width of the soft edge, share of the picture's height.
};

/// What the depth camera measured with the colour picture.
struct MeasuredDepth {
  ImageView<const std::uint16_t> depth_mm;  ///< 0 = no reading.
  PinholeCamera depth_camera;
  Eigen::Isometry3d color_from_depth = Eigen::Isometry3d::Identity();
};

enum class SlicePlane : std::uint8_t {
  kNone,
  kAxial,     ///< Across the body's long axis; position 0 is at the feet.
  kCoronal,   ///< Parallel to the front; position 0 is at the front.
  kSagittal,  ///< Parallel to the side; position 0 is at the body's right.
  kCamera,    ///< Parallel to the picture, `depth_mm` below the skin at the hole's centre.
};

/// A grey CT slice inside the body.
struct SliceView {
  SlicePlane plane = SlicePlane::kNone;
  float position = 0.5F;     ///< Of the planes of the body: 0..1 through it.
  float depth_mm = 40.0F;    ///< Of the camera's plane. >= 0.
  float level_hu = 40.0F;    ///< Middle grey.
  float window_hu = 400.0F;  ///< From black to white; negative: from white to black. Not 0.
  float opacity = 1.0F;      ///< 0..1.
  bool cuts = true;          ///< What is between the camera and the slice is taken away.
};

/// The CT's volume itself, seen through a transfer function.
struct VolumeView {
  VolumePreset preset = VolumePreset::kNone;
  float level_hu = 0.0F;   ///< The preset's colours lie around this,
  float window_hu = 1.0F;  ///< as wide as this. > 0. volume_window() has the preset's own.
};

/// How the body is to be seen. What is shown in the hole are layers: structures, a slice, the
/// volume, in any combination; the nearer ones are in front.
struct OverlayView {
  PinholeCamera color_camera;  ///< Of the colour picture; with its distortion.
  std::optional<Eigen::Isometry3d> color_from_ct = {};  ///< None: the plain colour picture.
  float opacity = 0.75F;                                ///< Of all that is in the hole, 0..1.
  Hole hole = {};
  std::map<std::string, float> structure_opacity =
      {};                     ///< By name, 0 (not drawn) to 1; those not named are opaque.
  bool has_outlines = false;  ///< Structures' outlines are drawn as lines where something hides
                              ///< them, and under the skin beside the hole.
  SliceView slice = {};
  VolumeView volume = {};
  std::optional<MeasuredDepth> measured =
      {};  ///< Hands and instruments in it stay in front. None: nothing is in front of the body.
  std::optional<Eigen::Isometry3d> color_from_ghost =
      {};                 ///< Where the CT skin is drawn as a ghost to be met (start by placement).
  bool is_still = false;  ///< The volume is drawn as sharp as it is, however long that takes; else
                          ///< as sharp as a live picture allows.
};

}  // namespace mor
