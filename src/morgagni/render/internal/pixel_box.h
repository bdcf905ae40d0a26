// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace mor::internal {

/// A rectangle of pixels: columns [left, left + width), rows [top, top + height).
struct PixelBox {
  int left = 0;
  int top = 0;
  int width = 0;
  int height = 0;

  bool operator==(const PixelBox&) const = default;
  [[nodiscard]] bool empty() const { return width <= 0 || height <= 0; }
};

}  // namespace mor::internal
