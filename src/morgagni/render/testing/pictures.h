// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "morgagni/render/overlay_renderer.h"

/// What tests of the renderer share.
namespace mor::testing {

inline Eigen::Isometry3d at(double x, double y, double z) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(x, y, z);
  return pose;
}

inline std::unique_ptr<OverlayRenderer> make_renderer(const RenderScene& scene) {
  auto renderer = OverlayRenderer::create(scene);
  if (!renderer) throw std::runtime_error(renderer.error().message);
  return *std::move(renderer);
}

inline Image<Rgba8> rendered(OverlayRenderer& renderer,
                             const Image<Rgb8>& color,
                             const OverlayView& view) {
  const auto shown = renderer.render(color.view(), view);
  if (!shown) throw std::runtime_error(shown.error().message);
  Image<Rgba8> copy(shown->width(), shown->height());
  for (int y = 0; y < copy.height(); ++y) {
    std::copy(shown->row(y), shown->row(y) + copy.width(), &copy(0, y));
  }
  return copy;
}

/// A grid of `size` voxels a side, 1 mm apart, its middle at the origin of ct.
/// @param hu  Of a place in ct.
template <class Hu>
std::shared_ptr<const Volume> make_volume(int size, const Hu& hu) {
  auto volume = std::make_shared<Volume>();
  volume->size = {size, size, size};
  volume->ct_from_grid.translation().setConstant(-0.5 * (size - 1));
  volume->hu.reserve(static_cast<std::size_t>(size) * size * size);
  for (int z = 0; z < size; ++z) {
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        volume->hu.push_back(
            static_cast<std::int16_t>(hu(volume->ct_from_grid * Eigen::Vector3d(x, y, z))));
      }
    }
  }
  return volume;
}

}  // namespace mor::testing
