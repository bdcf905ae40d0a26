// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "morgagni/core/image.h"
#include "morgagni/render/internal/layer_pass.h"
#include "morgagni/render/internal/pixel_box.h"
#include "morgagni/render/overlay_renderer.h"

/// Laying the drawn layers over the camera's picture is done by the CPU: the picture comes from
/// there and goes back there to the encoder, so only the hole has to leave the GPU.
namespace mor::internal {

/// Alpha of a layer's pixel where the body is and nothing is drawn: 0 is beside the body, 255 a
/// structure.
inline constexpr int kBodyAlpha = 16;

/// How the hole treats each of its pixels. Made anew only when the hole or the opacity changes.
class HoleMask {
 public:
  struct Weights {
    std::uint8_t structure;   ///< Share of the structures, 0..255.
    std::uint8_t background;  ///< Share of the body's brightness that stays, 0..255.
    std::uint8_t ring;        ///< Share of the light line around the hole, 0..255.
  };

  void update(const Hole& hole, float opacity, int picture_width, int picture_height);

  /// The part of the picture that the hole changes; empty where it changes nothing.
  [[nodiscard]] const PixelBox& box() const { return box_; }
  [[nodiscard]] const Weights* row(int y) const {
    return weights_.data() + static_cast<std::size_t>(y - box_.top) * box_.width;
  }

 private:
  void fill(const Hole& hole, float opacity, int picture_width, int picture_height);

  Hole hole_;
  float opacity_ = -1.0F;
  int picture_width_ = 0;
  int picture_height_ = 0;
  PixelBox box_;
  std::vector<Weights> weights_;
};

/// The colour picture, opaque.
void copy_background(ImageView<const Rgb8> color, ImageView<Rgba8> picture);

/// Softens the outline of what is drawn, where the device takes one sample a pixel: its stairs are
/// blended into what is beside them, and nothing else is.
void smooth_outline(Layer& layer);

/// Opens the hole: the body darker in it and the structures inside. `structures` is the hole's box,
/// with the body marked by kBodyAlpha.
void compose_hole(const HoleMask& mask, const Layer& structures, ImageView<Rgba8> picture);

/// Lays a layer over the picture.
void compose_over(const Layer& layer, ImageView<Rgba8> picture);

}  // namespace mor::internal
