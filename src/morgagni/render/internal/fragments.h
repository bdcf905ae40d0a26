// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "morgagni/render/internal/layer.h"

namespace mor::internal {

/// A layer's pixel on the way of a ray.
struct Fragment {
  float depth_mm;
  Rgba8 color;  ///< Premultiplied.
};

/// What a ray meets in the layers, nearest first. Of more than fit, the farthest are left out.
class Fragments {
 public:
  static constexpr int kMost = 16;

  void gather(std::span<const Layer> layers, int x, int y) {
    size_ = 0;
    for (const Layer& layer : layers) {
      const int column = x - layer.box.left;
      const int row = y - layer.box.top;
      if (column < 0 || row < 0 || column >= layer.box.width || row >= layer.box.height) continue;
      const std::size_t i = layer.row_start(y) + static_cast<std::size_t>(column);
      if (layer.pixels[i].a != 0) insert({layer.depth_mm[i], layer.pixels[i]});
    }
  }

  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] const Fragment& operator[](int i) const {
    return items_[static_cast<std::size_t>(i)];
  }

 private:
  void insert(const Fragment& fragment) {
    int at = size_;
    while (at > 0 && items_[static_cast<std::size_t>(at - 1)].depth_mm > fragment.depth_mm) --at;
    if (at == kMost) return;
    size_ = std::min(size_ + 1, kMost);
    for (int i = size_ - 1; i > at; --i) {
      items_[static_cast<std::size_t>(i)] = items_[static_cast<std::size_t>(i - 1)];
    }
    items_[static_cast<std::size_t>(at)] = fragment;
  }

  std::array<Fragment, kMost> items_;
  int size_ = 0;
};

}  // namespace mor::internal
