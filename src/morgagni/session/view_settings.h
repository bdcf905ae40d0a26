// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "morgagni/core/result.h"
#include "morgagni/render/overlay_renderer.h"

namespace mor {

struct StructureLook {
  bool is_shown = true;
  float opacity = 1.0F;  ///< 0..1.
};

/// The body from a side of one's own choice, with the live picture on its skin.
struct FreeViewSettings {
  bool is_shown = false;  ///< Instead of the camera's picture.
  double yaw_rad = 0.0;   ///< As SkinViewpoint's.
  double pitch_rad = 0.0;
  double zoom = 1.3;  ///< The skin's sphere is larger than what is seen of it.
  Eigen::Vector3d target_mm = Eigen::Vector3d::Zero();
  bool wears_fused =
      false;                ///< The skin's colours are the fused texture's, not the live picture's.
  bool opens_hole = false;  ///< The hole of the camera's picture is cut into the skin.
  bool shows_bare_skin = false;  ///< Where it has no colours; else that is cut away.
};

/// How the user wants the live picture. Shares are of the colour picture.
struct ViewSettings {
  float opacity = 0.75F;
  Hole hole;
  bool keeps_hands_in_front = true;  ///< What the camera sees before the body hides the overlay.
  bool has_outlines = false;         ///< Of structures where something hides them.
  std::map<std::string, StructureLook> structures;  ///< By name.
  SliceView slice;
  VolumeView volume;
  FreeViewSettings free;
  bool has_ct = false;  ///< The case has the voxels that slices and volume are made of.
};

/// The members as docs/http-api.md lists them.
[[nodiscard]] std::string to_json(const ViewSettings& view);

/// `view` with the members that `json` names changed.
/// @errors kInvalidArgument: no JSON object, an unknown member or structure, a value outside its
/// range, a slice or volume where the case has no CT.
[[nodiscard]] Result<ViewSettings> changed(const ViewSettings& view, const std::string& json);

}  // namespace mor
