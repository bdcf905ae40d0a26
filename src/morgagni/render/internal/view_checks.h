// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "morgagni/render/free_view.h"
#include "morgagni/render/overlay_renderer.h"

namespace mor::internal {

/// @errors kInvalidArgument: a vertex that is not finite, a triangle of a vertex that is not there.
[[nodiscard]] Result<void> check_mesh(const std::string& name, const TriangleMesh& mesh);

/// @errors kInvalidArgument: too few voxels to interpolate between, or fewer than its size says.
[[nodiscard]] Result<void> check_volume(const Volume& volume);

/// @errors kInvalidArgument: what OverlayRenderer::render refuses.
[[nodiscard]] Result<void> check_view(ImageView<const Rgb8> color, const OverlayView& view);

/// @errors kInvalidArgument: what FreeViewRenderer::render refuses.
[[nodiscard]] Result<void> check_free_view(const FreeView& view);

}  // namespace mor::internal
