// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "morgagni/render/testing/pictures.h"
#include "morgagni/render/testing/shapes.h"

/// A body the size of a fist with everything that a mode shows, made in code.
namespace mor::testing {

inline const Eigen::Vector3d kSmallBodyMm(52.0, 44.0, 56.0);  ///< Semi-axes.

inline double small_body_hu(const Eigen::Vector3d& p) {
  const double wall = p.cwiseQuotient(kSmallBodyMm).norm();
  if (wall > 1.02) return kOutsideHu;
  if (wall > 0.98) return -1000.0 + 900.0 * (1.02 - wall) / 0.04;
  double hu = wall > 0.92 ? -90.0 : 50.0;
  const auto soft_ball = [&](const Eigen::Vector3d& center, double radius_mm, double inside_hu) {
    const double depth_mm = radius_mm - (p - center).norm();
    hu += (inside_hu - hu) * std::clamp(depth_mm / 1.5 + 0.5, 0.0, 1.0);
  };
  for (const double side : {-1.0, 1.0}) {
    soft_ball({22.0 * side, 2.0, 6.0}, 16.0, -830.0);
    soft_ball({20.0 * side, -4.0, 8.0}, 3.0, 20.0);
    soft_ball({24.0 * side, 6.0, 2.0}, 2.5, 20.0);
  }
  soft_ball({5.0, -8.0, -4.0}, 12.0, 230.0);
  const double rib_mm = std::hypot((wall - 0.84) * 46.0, std::remainder(p.z() + 0.2 * p.y(), 16.0));
  hu += (620.0 - hu) * std::clamp((3.2 - rib_mm) / 1.5 + 0.5, 0.0, 1.0);
  const double spine_mm = std::hypot(p.x(), p.y() - 30.0);
  hu += (520.0 - hu) * std::clamp((6.0 - spine_mm) / 1.5 + 0.5, 0.0, 1.0);
  return hu;
}

inline RenderScene small_body() {
  RenderScene scene;
  scene.skin = make_sphere(Eigen::Vector3d::Zero(), 1.0, 60);
  for (auto& vertex : scene.skin.vertices) {
    vertex = vertex.cwiseProduct(kSmallBodyMm.cast<float>());
  }
  scene.skin.normals = vertex_normals(scene.skin);
  TriangleMesh ribs;
  for (const double z : {-30.0, -10.0, 10.0, 30.0}) {
    append(ribs, make_torus({0.0, 0.0, z}, 32.0 - 0.2 * std::abs(z), 3.0, 64, 16));
  }
  scene.structures.push_back({"ribs", ribs, {0.93F, 0.89F, 0.78F}});
  scene.structures.push_back(
      {"heart", make_sphere({5.0, -8.0, -4.0}, 12.0, 30), {0.80F, 0.15F, 0.12F}});
  scene.structures.push_back({"skin", scene.skin, {0.88F, 0.68F, 0.56F}});
  scene.volume = make_volume(116, small_body_hu);
  return scene;
}

/// From the front, a little from above and from the side.
inline Eigen::Isometry3d small_body_pose() {
  Eigen::Isometry3d color_from_ct = at(3.0, -2.0, 190.0);
  Eigen::Matrix3d front;
  front << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  color_from_ct.linear() = (Eigen::AngleAxisd(0.25, Eigen::Vector3d::UnitX()) *
                            Eigen::AngleAxisd(-0.3, Eigen::Vector3d::UnitY()) * front)
                               .eval();
  return color_from_ct;
}

}  // namespace mor::testing
