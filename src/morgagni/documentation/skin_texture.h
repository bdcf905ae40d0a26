// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

/// The CT skin unwrapped into a picture (the atlas): where in it each triangle lies.
struct SkinAtlas {
  TriangleMesh mesh;  ///< The CT skin, with normals. Frame ct, mm.
  /// Of each triangle its three corners in the picture, px: (0, 0) is the centre of the first
  /// texel, rows run downwards. Triangles do not overlap.
  std::vector<std::array<Eigen::Vector2f, 3>> corners_px;
  int width_px = 0;
  int height_px = 0;
  double px_per_mm = 1.0;  ///< Of skin, as good as unwrapping allows.

  /// @errors kInvalidArgument: corners missing or outside of the picture; says which triangle.
  [[nodiscard]] Result<void> check() const;
};

/// A camera picture that has gone into a texture.
struct TextureFrame {
  std::uint64_t frame_id = 0;
  std::int64_t captured_unix_ms = 0;  ///< Wall clock.
  Eigen::Isometry3d ct_from_color = Eigen::Isometry3d::Identity();
  std::optional<double> bound_mm;  ///< 95 % error bound of its pose at the skin it shows.
};

/// Where a texel's colour comes from mostly: the provenance that a court may ask for.
struct TexelSource {
  static constexpr std::uint32_t kNeverSeen = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t frame = kNeverSeen;  ///< Index into SkinTexture::frames.
  float angle_rad = 0.0F;            ///< Between the skin's normal and the way to the camera.
  float distance_mm = 0.0F;          ///< From the camera.
  float px_per_mm = 0.0F;            ///< Of the camera picture on the skin there.
};

/// The CT skin in the camera's colours.
struct SkinTexture {
  std::shared_ptr<const SkinAtlas> atlas;
  Image<Rgb8> color;           ///< Size of the atlas.
  Image<TexelSource> sources;  ///< Same size; outside of every triangle kNeverSeen.
  std::vector<TextureFrame> frames;

  [[nodiscard]] bool is_seen(int x, int y) const {
    return sources(x, y).frame != TexelSource::kNeverSeen;
  }
};

}  // namespace mor
