// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "morgagni/core/result.h"
#include "morgagni/render/overlay_renderer.h"

namespace mor {

struct StructureLook {
  bool is_shown = true;
  float opacity = 1.0F;  ///< 0..1.
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
  bool has_ct = false;  ///< The case has the voxels that slices and volume are made of.
};

/// The members as docs/http-api.md lists them.
[[nodiscard]] std::string to_json(const ViewSettings& view);

/// `view` with the members that `json` names changed.
/// @errors kInvalidArgument: no JSON object, an unknown member or structure, a value outside its
/// range, a slice or volume where the case has no CT.
[[nodiscard]] Result<ViewSettings> changed(const ViewSettings& view, const std::string& json);

}  // namespace mor
