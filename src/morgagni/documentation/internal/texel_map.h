// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "morgagni/core/image.h"
#include "morgagni/documentation/skin_texture.h"

namespace mor::internal {

/// A texel that lies in a triangle, and the place on the skin that it shows.
struct Texel {
  std::uint32_t pixel = 0;  ///< Row by row in the atlas.
  std::uint32_t triangle = 0;
  Eigen::Vector3f share;  ///< Of the triangle's corners, sum 1.
  Eigen::Vector3f at_mm;  ///< Frame ct.
  Eigen::Vector3f normal;
};

/// The texels whose centres lie in a triangle, in the order of the triangles. @pre A mesh with
/// normals.
[[nodiscard]] std::vector<Texel> texels_of(const SkinAtlas& atlas);

/// Gives pixels outside of every triangle their nearest neighbours' colours, so that filtering at a
/// chart's rim does not mix in what lies beside it. @param is_texel  1 where a colour is given.
void fill_gutters(Image<Rgb8>& color, Image<std::uint8_t> is_texel, int num_rings);

}  // namespace mor::internal
