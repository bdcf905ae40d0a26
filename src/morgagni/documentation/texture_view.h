// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "morgagni/core/image.h"
#include "morgagni/documentation/skin_texture.h"

namespace mor {

/// The skin in its texture seen from afar, on white; what was never seen is shaded in orange
/// stripes.
/// @param from  From the body to the viewer, frame ct, not zero. The head's end is up.
/// @pre A texture with an atlas and pictures of its size; the mesh has normals.
/// @cost About 15 ms for 40,000 triangles and 300x300 px. No GPU, any thread.
[[nodiscard]] Image<Rgb8> draw_skin_texture(const SkinTexture& texture,
                                            const Eigen::Vector3d& from,
                                            int width_px,
                                            int height_px);

/// From the front, the patient's left, the back and the right, side by side.
[[nodiscard]] Image<Rgb8> draw_four_sides(const SkinTexture& texture,
                                          int side_width_px,
                                          int height_px);

}  // namespace mor
