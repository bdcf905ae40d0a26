// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"
#include "morgagni/documentation/skin_texture.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

/// What the skin is painted with where no camera saw it: no body has this colour, so nobody takes
/// it for a finding.
inline constexpr Rgb8 kNeverSeenColor{118, 126, 134};
/// The skin of a model without texture.
inline constexpr Rgb8 kPlainSkinColor{217, 184, 164};

/// One surface as the exports write it. Frame ct, mm.
struct ExportSurface {
  std::string name;
  Rgb8 color;         ///< sRGB; of the whole surface where it has no picture.
  TriangleMesh mesh;  ///< With normals. Along the picture's seams a place has several vertices.
  std::vector<Eigen::Vector2f> picture_px;  ///< Of each vertex; (0, 0) is the centre of the first
                                            ///< texel. Empty: no picture.
};

/// What the exported models show.
struct ExportModel {
  ExportSurface skin;
  TriangleMesh skin_mesh;   ///< The same triangles in the same order, each place one vertex.
  Image<Rgb8> picture;      ///< On the skin; empty: plain.
  double seen_share = 0.0;  ///< Of the skin's area, what a camera saw.
  std::vector<ExportSurface> structures;
};

/// @param texture  None: the skin is plain.
/// @errors kInvalidArgument: no skin; an atlas or picture that does not fit to the texture.
[[nodiscard]] Result<ExportModel> make_export_model(const TriangleMesh& skin,
                                                    const SkinTexture* texture,
                                                    std::vector<ExportSurface> structures);

/// The colour between texels, as a viewer draws it (bilinear, clamped to the edge).
[[nodiscard]] Rgb8 sample_picture(const Image<Rgb8>& picture, const Eigen::Vector2f& place_px);

/// Each triangle becomes four, `levels` times; places, normals and picture places in between.
[[nodiscard]] ExportSurface subdivided(ExportSurface surface, int levels);

/// (0..1, 0..1) of a place in a picture, from its upper left corner.
[[nodiscard]] inline Eigen::Vector2f picture_share(const Eigen::Vector2f& place_px,
                                                   const Image<Rgb8>& picture) {
  return {(place_px.x() + 0.5F) / static_cast<float>(picture.width()),
          (place_px.y() + 0.5F) / static_cast<float>(picture.height())};
}

}  // namespace mor
