// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/skin_texture.h"

#include <spdlog/fmt/fmt.h>

namespace mor {

Result<void> SkinAtlas::check() const {
  if (corners_px.size() != mesh.triangles.size()) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("an atlas needs corners for each of the skin's {} triangles, got {}",
                    mesh.triangles.size(),
                    corners_px.size()));
  }
  const Eigen::AlignedBox2f picture(
      Eigen::Vector2f(-0.5F, -0.5F),
      Eigen::Vector2f(static_cast<float>(width_px) - 0.5F, static_cast<float>(height_px) - 0.5F));
  for (std::size_t triangle = 0; triangle < corners_px.size(); ++triangle) {
    for (const auto& corner : corners_px[triangle]) {
      if (corner.allFinite() && picture.contains(corner)) continue;
      return make_error(
          ErrorCode::kInvalidArgument,
          fmt::format("triangle {} lies at ({}, {}) px, outside of the atlas of {}x{} px",
                      triangle,
                      corner.x(),
                      corner.y(),
                      width_px,
                      height_px));
    }
  }
  return {};
}

}  // namespace mor
