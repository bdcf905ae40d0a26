// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/view_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "morgagni/geometry/depth_raster.h"

namespace mor::internal {
namespace {

constexpr int kMostCells = 400;  ///< In a row: as many as a depth camera can fill.
constexpr int kLeastCellPx = 2;

/// The four cells around a place, and how much each of them weighs.
template <class Visit>
void around(const Image<float>& cells, const Eigen::Vector2f& place, const Visit& visit) {
  const float x = std::clamp(place.x(), 0.0F, static_cast<float>(cells.width() - 1));
  const float y = std::clamp(place.y(), 0.0F, static_cast<float>(cells.height() - 1));
  const int left = std::min(static_cast<int>(x), std::max(cells.width() - 2, 0));
  const int top = std::min(static_cast<int>(y), std::max(cells.height() - 2, 0));
  const int right = std::min(left + 1, cells.width() - 1);
  const int bottom = std::min(top + 1, cells.height() - 1);
  const float to_right = x - static_cast<float>(left);
  const float down = y - static_cast<float>(top);
  visit(cells(left, top), (1.0F - to_right) * (1.0F - down));
  visit(cells(right, top), to_right * (1.0F - down));
  visit(cells(left, bottom), (1.0F - to_right) * down);
  visit(cells(right, bottom), to_right * down);
}

/// Of the four cells around a place, those that have something. 0: none has.
float mean_of(const Image<float>& cells, const Eigen::Vector2f& place) {
  float sum = 0.0F;
  float share = 0.0F;
  around(cells, place, [&](float cell, float weight) {
    if (cell <= 0.0F) return;
    sum += weight * cell;
    share += weight;
  });
  return share > 0.0F ? sum / share : 0.0F;
}

}  // namespace

void ViewGrid::update(const PinholeCamera& color_camera,
                      const TriangleMesh& skin,
                      const Eigen::Isometry3d& color_from_ct) {
  const int cell_px = std::max(kLeastCellPx, (color_camera.width_px + kMostCells - 1) / kMostCells);
  camera_ = color_camera.scaled(1.0 / cell_px);
  camera_.width_px = (color_camera.width_px + cell_px - 1) / cell_px;
  camera_.height_px = (color_camera.height_px + cell_px - 1) / cell_px;
  camera_.distortion = {};
  focal_ = Eigen::Vector2d(camera_.focal_x_px, camera_.focal_y_px).cast<float>();
  center_ = Eigen::Vector2d(camera_.center_x_px, camera_.center_y_px).cast<float>();
  has_skin_ = !skin.empty();
  skin_mm_ = has_skin_ ? rasterize_depth(skin, camera_, color_from_ct).depth_mm
                       : Image<float>(camera_.width_px, camera_.height_px);
  if (has_skin_) smooth_shares();
}

/// The nearest surface is what a raster keeps. z -> z * pole / (z - pole) leaves every point on its
/// ray and every plane a plane, and makes the farthest the nearest.
void ViewGrid::update_back(const TriangleMesh& skin, const Eigen::Isometry3d& color_from_ct) {
  TriangleMesh turned;
  turned.triangles = skin.triangles;
  turned.vertices.reserve(skin.vertices.size());
  const Eigen::Isometry3f pose = color_from_ct.cast<float>();
  float nearest_mm = std::numeric_limits<float>::max();
  for (const Eigen::Vector3f& vertex : skin.vertices) {
    turned.vertices.push_back(pose * vertex);
    nearest_mm = std::min(nearest_mm, turned.vertices.back().z());
  }
  back_mm_ = Image<float>(camera_.width_px, camera_.height_px);
  if (!(nearest_mm > 1.0F) || skin.empty()) return;  // The camera is within it.
  const float pole_mm = 0.5F * nearest_mm;
  for (Eigen::Vector3f& vertex : turned.vertices) vertex *= pole_mm / (vertex.z() - pole_mm);
  back_mm_ = rasterize_depth(turned, camera_, Eigen::Isometry3d::Identity()).depth_mm;
  for (std::size_t i = 0; i < back_mm_.size(); ++i) {
    float& z = back_mm_.data()[i];
    if (z > pole_mm) z = z * pole_mm / (z - pole_mm);
  }
}

/// The mean over three by three cells: of a straight outline nothing is left of its steps.
void ViewGrid::smooth_shares() {
  const int width = skin_mm_.width();
  const int height = skin_mm_.height();
  if (shares_.width() != width || shares_.height() != height) {
    shares_ = Image<float>(width, height);
    scratch_ = Image<float>(width, height);
  }
  const auto is_body = [this](int x, int y) { return skin_mm_(x, y) > 0.0F ? 1.0F : 0.0F; };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      scratch_(x, y) =
          is_body(std::max(x - 1, 0), y) + is_body(x, y) + is_body(std::min(x + 1, width - 1), y);
    }
  }
  for (int y = 0; y < height; ++y) {
    const float* above = scratch_.view().row(std::max(y - 1, 0));
    const float* here = scratch_.view().row(y);
    const float* below = scratch_.view().row(std::min(y + 1, height - 1));
    for (int x = 0; x < width; ++x) shares_(x, y) = (above[x] + here[x] + below[x]) / 9.0F;
  }
}

float ViewGrid::body_share(const Eigen::Vector2f& ray) const {
  if (!has_skin_) return 1.0F;
  float share = 0.0F;
  around(shares_, cell_of(ray), [&](float cell, float weight) { share += weight * cell; });
  // Half of the body is where its outline is: beyond it nothing is opened.
  return std::clamp(2.0F * share - 0.5F, 0.0F, 1.0F);
}

float ViewGrid::skin_at(const Eigen::Vector2f& ray) const {
  return mean_of(skin_mm_, cell_of(ray));
}

float ViewGrid::back_at(const Eigen::Vector2f& ray) const {
  return mean_of(back_mm_, cell_of(ray));
}

}  // namespace mor::internal
