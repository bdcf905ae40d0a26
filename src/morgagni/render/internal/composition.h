// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "morgagni/core/image.h"
#include "morgagni/render/internal/layer.h"
#include "morgagni/render/internal/occluders.h"
#include "morgagni/render/internal/picture_rays.h"
#include "morgagni/render/internal/pixel_box.h"
#include "morgagni/render/internal/view_grid.h"
#include "morgagni/render/overlay_renderer.h"

/// Laying the drawn layers over the camera's picture is done by the CPU: the picture comes from
/// there and goes back there to the encoder, so only the hole has to leave the GPU.
namespace mor::internal {

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
  /// False where the whole picture is open.
  [[nodiscard]] bool has_rim() const { return has_rim_; }
  /// Whether something of the inside is seen within `margin_px` of a pixel.
  [[nodiscard]] bool reaches(int x, int y, float margin_px) const;
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
  bool has_rim_ = false;
  std::vector<Weights> weights_;
};

/// The colour picture, opaque.
void copy_background(ImageView<const Rgb8> color, ImageView<Rgba8> picture);

/// Softens the outline of what is drawn: its stairs are blended into what is beside them, and
/// nothing else is. A device's own four samples a pixel cost llvmpipe three times the CPU, take a
/// pixel's depth beside its centre and look elsewhere in an atlas.
void smooth_outline(Layer& layer);

/// The layers in one, each pixel's nearest over its farther ones. @param merged  Of the box it has.
void merge_layers(std::span<const Layer> layers, Layer& merged);

/// Opens the hole: the body darker in it, and what is inside.
/// @param inside     Of the mask's box.
/// @param occluders  Of the mask's box at least; null: nothing is in front of the body.
void compose_hole(const HoleMask& mask,
                  const Layer& inside,
                  const PictureRays& rays,
                  const ViewGrid& grid,
                  const Occluders* occluders,
                  ImageView<Rgba8> picture);

/// Lays a layer over the picture.
void compose_over(const Layer& layer, ImageView<Rgba8> picture);

}  // namespace mor::internal
