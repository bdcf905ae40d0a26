// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// The colour camera's view in cells of a few pixels, without lens distortion: where the CT skin is
/// compared with what the depth camera saw.
class ViewGrid {
 public:
  /// @param skin  With an empty one, the body is everywhere at no known depth.
  void update(const PinholeCamera& color_camera,
              const TriangleMesh& skin,
              const Eigen::Isometry3d& color_from_ct);

  /// Where the body ends, for back_at(). @param skin, color_from_ct  As update() had them.
  void update_back(const TriangleMesh& skin, const Eigen::Isometry3d& color_from_ct);

  [[nodiscard]] int width() const { return camera_.width_px; }
  [[nodiscard]] int height() const { return camera_.height_px; }
  /// z of the CT skin in each cell, colour frame; 0: no skin there.
  [[nodiscard]] const Image<float>& skin_mm() const { return skin_mm_; }

  /// Where a ray (x/z, y/z) meets the grid, in cells; whole numbers are their centres.
  [[nodiscard]] Eigen::Vector2f cell_of(const Eigen::Vector2f& ray) const {
    return ray.cwiseProduct(focal_) + center_;
  }

  /// Share of the body at a ray: 1 on the skin, 0 beside it, between them at its outline.
  [[nodiscard]] float body_share(const Eigen::Vector2f& ray) const;

  /// z of the skin at a ray, of the cells around it that have some; 0: none has.
  [[nodiscard]] float skin_at(const Eigen::Vector2f& ray) const;

  /// z of the farthest skin at a ray; 0: there is none.
  [[nodiscard]] float back_at(const Eigen::Vector2f& ray) const;

 private:
  void smooth_shares();

  PinholeCamera camera_;
  Eigen::Vector2f focal_ = Eigen::Vector2f::Ones();
  Eigen::Vector2f center_ = Eigen::Vector2f::Zero();
  bool has_skin_ = false;
  Image<float> skin_mm_;
  Image<float> back_mm_;
  Image<float> shares_;  ///< Of the body, without the steps of the cells.
  Image<float> scratch_;
};

}  // namespace mor::internal
