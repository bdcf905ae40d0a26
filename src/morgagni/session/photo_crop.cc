// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/photo_crop.h"

#include <cmath>

namespace mor {
namespace {

template <class Pixel>
Image<Rgb8> copied(ImageView<const Pixel> picture, const Eigen::AlignedBox2i& box) {
  Image<Rgb8> crop(box.sizes().x() + 1, box.sizes().y() + 1);
  for (int y = 0; y < crop.height(); ++y) {
    for (int x = 0; x < crop.width(); ++x) {
      const auto& pixel = picture(box.min().x() + x, box.min().y() + y);
      crop(x, y) = {pixel.r, pixel.g, pixel.b};
    }
  }
  return crop;
}

}  // namespace

std::optional<Eigen::AlignedBox2i> box_around(const std::vector<Eigen::Vector3d>& places_ct_mm,
                                              const PinholeCamera& camera,
                                              const Eigen::Isometry3d& camera_from_ct,
                                              double margin_mm) {
  const Eigen::AlignedBox2i all(Eigen::Vector2i::Zero(),
                                Eigen::Vector2i(camera.width_px - 1, camera.height_px - 1));
  Eigen::AlignedBox2d box;
  for (const auto& place : places_ct_mm) {
    const Eigen::Vector3d point = camera_from_ct * place;
    const auto pixel = camera.project(point);
    if (!pixel || !all.cast<double>().contains(*pixel)) return std::nullopt;
    const Eigen::Vector2d margin =
        margin_mm / point.z() * Eigen::Vector2d(camera.focal_x_px, camera.focal_y_px);
    box.extend(Eigen::Vector2d(*pixel - margin));
    box.extend(Eigen::Vector2d(*pixel + margin));
  }
  const Eigen::AlignedBox2d within = box.intersection(all.cast<double>());
  return Eigen::AlignedBox2i(within.min().array().floor().matrix().cast<int>(),
                             within.max().array().floor().matrix().cast<int>());
}

Image<Rgb8> cropped(ImageView<const Rgb8> picture, const Eigen::AlignedBox2i& box) {
  return copied(picture, box);
}

Image<Rgb8> cropped(ImageView<const Rgba8> picture, const Eigen::AlignedBox2i& box) {
  return copied(picture, box);
}

void draw_ring(ImageView<Rgb8> picture, const Eigen::Vector2d& center) {
  constexpr double kRadiusPx = 8.0;
  constexpr double kHalfWhitePx = 1.1;
  constexpr double kHalfDarkPx = 2.2;
  const int reach = static_cast<int>(kRadiusPx + kHalfDarkPx) + 1;
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const int x = static_cast<int>(std::lround(center.x())) + dx;
      const int y = static_cast<int>(std::lround(center.y())) + dy;
      const double off_px = std::abs((Eigen::Vector2d(x, y) - center).norm() - kRadiusPx);
      if (!picture.contains(x, y) || off_px > kHalfDarkPx) continue;
      picture(x, y) = off_px <= kHalfWhitePx ? Rgb8{255, 255, 255} : Rgb8{20, 20, 20};
    }
  }
}

}  // namespace mor
