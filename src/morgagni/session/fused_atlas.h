// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>

#include "morgagni/core/image.h"
#include "morgagni/documentation/skin_texture.h"
#include "morgagni/render/free_view.h"

namespace mor {

/// The fused texture as the free view draws it. What an atlas costs is paid once.
class FusedAtlas {
 public:
  /// @param texture  Not changed while it is shared: a newer one is another pointer.
  [[nodiscard]] AtlasPicture picture(const std::shared_ptr<const SkinTexture>& texture);

 private:
  void take(const SkinAtlas& atlas);

  std::shared_ptr<const SkinAtlas> atlas_;
  std::shared_ptr<const SkinTexture> texture_;
  AtlasPicture picture_;
  Image<std::uint8_t> is_skin_;  ///< 1: the texel lies in a triangle.
};

}  // namespace mor
