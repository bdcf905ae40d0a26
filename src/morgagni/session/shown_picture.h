// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/session/view_settings.h"
#include "morgagni/tracking/tracker.h"

namespace mor {

/// What a picture showed that went to the page.
struct ShownPicture {
  TrackedFrame tracked;
  ViewSettings view;
  bool is_still = false;  ///< Frozen.
  bool is_free = false;   ///< A free view, not the camera's picture.
  /// The picture's own: the colour camera, or the virtual one of a free view.
  PinholeCamera camera;
  std::optional<Eigen::Isometry3d> camera_from_ct;  ///< None: the body is not in it.
  /// 95 % error bound of the pose on the skin in the middle of the hole. None: not known.
  std::optional<double> bound_mm;
};

/// A picture with its pixels.
struct Snapshot {
  Image<Rgba8> pixels;
  ShownPicture shown;
  std::string marks;  ///< JSON of what is marked in it; empty: nothing.
};

/// What belongs to the picture, as the page and the video's poses get it (docs/http-api.md).
/// @param marks  The JSON of its member `marks`: what is marked on the body, where it is.
[[nodiscard]] std::string picture_json(const ShownPicture& shown, const std::string& marks);

}  // namespace mor
