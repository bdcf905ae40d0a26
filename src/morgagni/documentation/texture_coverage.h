// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "morgagni/core/image.h"
#include "morgagni/documentation/skin_texture.h"

namespace mor {

/// How much of the skin that a camera could see a texture shows.
///
/// Could be seen: from outside, from one of 26 directions all around at least, not more slantingly
/// than 70 degrees and not behind other skin. The inside of nostrils is not; the back is, for a
/// body can be turned over.
class SkinCoverage {
 public:
  /// @pre An atlas that passes check(). @cost About 0.2 s for 40,000 triangles.
  explicit SkinCoverage(std::shared_ptr<const SkinAtlas> atlas);

  /// Share by area, 0..1; 0 for a skin of which nothing could be seen.
  /// @pre A texture of this atlas. @cost About 2 ms.
  [[nodiscard]] double share(const SkinTexture& texture) const;

  [[nodiscard]] bool could_be_seen(std::size_t triangle) const { return is_reachable_[triangle]; }

 private:
  struct Place {
    std::uint32_t pixel;
    float area_mm2;
  };
  std::shared_ptr<const SkinAtlas> atlas_;
  std::vector<bool> is_reachable_;
  std::vector<Place> places_;  ///< The texels of what could be seen.
  double area_mm2_ = 0.0;
};

}  // namespace mor
