// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/skin_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mor::internal {
namespace {

/// Cells a unit of ray slope: one holds three by three points of a Kinect at a down-sampling
/// of 2.5.
constexpr float kCellsPerSlope = 70.0F;
/// Wider views than this are cut: 150 degrees.
constexpr int kMaxSide = 512;
constexpr std::size_t kNumPoints = 800;
/// The slope of a point behind the camera.
constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
/// Skin seen at a flatter angle is left out: a pose right to a millimetre may put it beside the
/// body.
constexpr float kMinFacing = 0.45F;

}  // namespace

RangeMap::RangeMap(const PointCloud& moving) {
  const float kMost = 0.5F * static_cast<float>(kMaxSide) / kCellsPerSlope;
  Eigen::Array2f low = Eigen::Array2f::Constant(std::numeric_limits<float>::infinity());
  Eigen::Array2f high = -low;
  std::vector<Eigen::Array2f> slopes(moving.size(), Eigen::Array2f::Constant(kNowhere));
  for (std::size_t i = 0; i < moving.size(); ++i) {
    const Eigen::Vector3f& p = moving.points[i];
    if (!(p.z() > 0.0F)) continue;
    slopes[i] = p.head<2>().array() / p.z();
    low = low.min(slopes[i]);
    high = high.max(slopes[i]);
  }
  if (!(low.x() <= high.x())) return;
  first_ = low.max(-kMost);
  const Eigen::Array2f span = (high.min(kMost) - first_) * kCellsPerSlope;
  width_ = static_cast<int>(std::max(0.0F, span.x())) + 1;
  height_ = static_cast<int>(std::max(0.0F, span.y())) + 1;
  cells_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), {});
  for (std::size_t i = 0; i < moving.size(); ++i) {
    const auto index = index_of(slopes[i]);
    if (!index) continue;
    const float z_mm = moving.points[i].z();
    Cell& cell = cells_[*index];
    cell.nearest_mm = cell.farthest_mm == 0.0F ? z_mm : std::min(cell.nearest_mm, z_mm);
    cell.farthest_mm = std::max(cell.farthest_mm, z_mm);
  }
}

std::optional<std::size_t> RangeMap::index_of(const Eigen::Array2f& slope) const {
  const Eigen::Array2f place = (slope - first_) * kCellsPerSlope;
  // Written so that NaN is outside.
  if (!(place.x() >= 0.0F && place.y() >= 0.0F && place.x() < static_cast<float>(width_) &&
        place.y() < static_cast<float>(height_))) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(place.y()) * static_cast<std::size_t>(width_) +
         static_cast<std::size_t>(place.x());
}

const RangeMap::Cell* RangeMap::at(const Eigen::Vector3f& point) const {
  if (!(point.z() > 0.0F)) return nullptr;
  const auto index = index_of(point.head<2>().array() / point.z());
  return index ? &cells_[*index] : nullptr;
}

double SkinView::absent_fraction() const {
  const int bare = num_seen + num_floating + num_missing;
  return bare > 0 ? static_cast<double>(num_floating + num_missing) / bare : 1.0;
}

double SkinView::floating_fraction() const {
  const int bare = num_seen + num_floating;
  return bare > 0 ? static_cast<double>(num_floating) / bare : 0.0;
}

SkinProbe::SkinProbe(const TriangleMesh& skin) {
  const std::size_t stride = std::max<std::size_t>(1, skin.vertices.size() / kNumPoints);
  for (std::size_t i = 0; i < skin.vertices.size(); i += stride) {
    points_.push_back(skin.vertices[i]);
    normals_.push_back(skin.normals[i]);
  }
}

SkinView SkinProbe::look(const RangeMap& map,
                         const Eigen::Isometry3d& fixed_from_moving,
                         float tolerance_mm) const {
  const Eigen::Matrix3f rotation = fixed_from_moving.linear().transpose().cast<float>();
  const Eigen::Vector3f eye = fixed_from_moving.translation().cast<float>();
  SkinView view;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Eigen::Vector3f ray = points_[i] - eye;
    const float facing = -normals_[i].dot(ray);
    if (!(facing > 0.0F && facing * facing >= kMinFacing * kMinFacing * ray.squaredNorm()))
      continue;
    const Eigen::Vector3f point = rotation * ray;
    const RangeMap::Cell* cell = map.at(point);
    if (cell == nullptr) continue;
    if (cell->farthest_mm == 0.0F) {
      ++view.num_missing;
    } else if (point.z() < cell->nearest_mm - tolerance_mm) {
      ++view.num_floating;
    } else if (point.z() > cell->farthest_mm + tolerance_mm) {
      ++view.num_covered;
    } else {
      ++view.num_seen;
    }
  }
  return view;
}

Eigen::Vector3d SkinProbe::facing_center(const Eigen::Isometry3d& fixed_from_moving) const {
  const Eigen::Vector3f eye = fixed_from_moving.translation().cast<float>();
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float count = 0.0F;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (normals_[i].dot(points_[i] - eye) >= 0.0F) continue;
    sum += points_[i];
    count += 1.0F;
  }
  return (sum / std::max(1.0F, count)).cast<double>();
}

}  // namespace mor::internal
