// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "morgagni/core/result.h"
#include "morgagni/render/overlay_renderer.h"

namespace mor {

/// How the user wants the live picture. Shares are of the colour picture.
struct ViewSettings {
  float opacity = 0.75F;
  Hole hole;
  std::map<std::string, bool> structures;  ///< Shown or not, by name.
};

/// {"opacity", "hole_radius", "hole_x", "hole_y", "structures": {name: bool}}.
[[nodiscard]] std::string to_json(const ViewSettings& view);

/// `view` with the members that `json` names changed.
/// @errors kInvalidArgument: no JSON object, an unknown member or structure, a value outside its
/// range.
[[nodiscard]] Result<ViewSettings> changed(const ViewSettings& view, const std::string& json);

}  // namespace mor
