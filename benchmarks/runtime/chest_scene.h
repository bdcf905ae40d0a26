// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "morgagni/render/overlay_renderer.h"
#include "morgagni/render/testing/shapes.h"

/// What the renderers are measured on, made in code.
namespace mor {

inline constexpr std::size_t kNumTriangles = 40000;

inline OverlayView view_of(int width_px, int height_px) {
  const double focal_px = 525.0 * height_px / 480.0;
  OverlayView view;
  view.color_camera = {width_px,
                       height_px,
                       focal_px,
                       focal_px,
                       0.5 * (width_px - 1),
                       0.5 * (height_px - 1),
                       {0.05, -0.1, 0.0, 0.0, 0.0}};
  // From the front: the body's long axis is upright on the picture.
  Eigen::Isometry3d color_from_ct = Eigen::Isometry3d::Identity();
  color_from_ct.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  color_from_ct.translation() = Eigen::Vector3d(0.0, 0.0, 500.0);
  view.color_from_ct = color_from_ct;
  return view;
}

/// A chest's CT in code, 512 x 512 x 275 voxels of 0.7 x 0.7 x 1 mm: fat and muscle around lungs
/// with vessels, ribs, a spine and a heart with contrast.
inline std::shared_ptr<const Volume> chest_ct() {
  static const auto kChest = [] {
    auto volume = std::make_shared<Volume>();
    volume->size = {512, 512, 275};
    volume->spacing_mm = {0.7, 0.7, 1.0};
    volume->ct_from_grid.translation() = Eigen::Vector3d(-178.9, -178.9, -137.0);
    volume->hu.reserve(512U * 512U * 275U);
    for (int z = 0; z < 275; ++z) {
      for (int y = 0; y < 512; ++y) {
        for (int x = 0; x < 512; ++x) {
          const double px = 0.7 * x - 178.9;
          const double py = 0.7 * y - 178.9;
          const double pz = z - 137.0;
          const double wall = std::hypot(px / 170.0, py / 115.0);
          double hu = wall > 1.0 ? kOutsideHu : wall > 0.93 ? -90.0 : 50.0;
          const double rib = std::remainder(pz + 0.3 * py, 26.0);
          if (std::abs(wall - 0.84) < 0.035 && std::abs(rib) < 5.5) hu = 500.0;
          if (wall < 0.78) hu = -820.0 + 60.0 * std::sin(0.9 * px) * std::sin(0.8 * py + 0.7 * pz);
          if (std::hypot(px, py - 80.0) < 22.0) hu = 420.0;
          if (Eigen::Vector3d(px - 25.0, py + 30.0, pz).norm() < 50.0) hu = 180.0;
          volume->hu.push_back(static_cast<std::int16_t>(hu));
        }
      }
    }
    return volume;
  }();
  return kChest;
}

inline RenderScene scene_of(std::size_t num_structures, std::shared_ptr<const Volume> volume) {
  RenderScene scene;
  scene.skin = testing::make_sphere(Eigen::Vector3d::Zero(), 140.0, 100);
  scene.volume = std::move(volume);
  for (std::size_t i = 0; i < num_structures; ++i) {
    TriangleMesh mesh = testing::make_bones(kNumTriangles);
    for (auto& vertex : mesh.vertices) vertex *= 1.0F - 0.2F * static_cast<float>(i);
    scene.structures.push_back({"bones" + std::to_string(i), std::move(mesh)});
  }
  return scene;
}

}  // namespace mor
