// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "contour_fill.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "morgagni/ct/import_protocol.h"

#include "messages.h"

namespace mor::import {
namespace {

constexpr double kFlatMm = 0.5;
constexpr double kParallel = 0.999;
constexpr double kSamePlaneMm = 0.05;
constexpr double kOnePlaneThickMm = 2.0;
constexpr double kMostGapMm = 20.0;  ///< Wider ones are no neighbours: a slice stays thinner.
constexpr double kPixelMm = 1.0;
constexpr double kFinePixelMm = 0.5;
constexpr double kSmallMm = 60.0;

/// Twice the area, along the normal (Newell).
Eigen::Vector3d area_vector(const Contour& contour) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < contour.size(); ++i)
    sum += (contour[i] - contour[0]).cross(contour[(i + 1) % contour.size()] - contour[0]);
  return sum;
}

/// Along LPS where the planes are, else turned with them.
Eigen::Matrix3d axes_for(const Eigen::Vector3d& area) {
  if (!(area.norm() > 0.0)) return Eigen::Matrix3d::Identity();
  Eigen::Vector3d normal = area.normalized();
  int along = 0;
  normal.cwiseAbs().maxCoeff(&along);
  if (normal[along] < 0.0) normal = -normal;
  if (normal.z() > kParallel) return Eigen::Matrix3d::Identity();
  const Eigen::Vector3d aside = along == 0 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
  Eigen::Matrix3d axes;
  axes.col(2) = normal;
  axes.col(0) = (aside - normal * normal.dot(aside)).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

}  // namespace

Result<ContourStack> stack_of(const std::vector<Contour>& contours, const std::string& name) {
  Eigen::Vector3d largest = Eigen::Vector3d::Zero();
  for (const auto& contour : contours) {
    const Eigen::Vector3d area = area_vector(contour);
    if (area.norm() > largest.norm()) largest = area;
  }
  ContourStack stack;
  stack.axes = axes_for(largest);
  for (const auto& contour : contours) {
    std::vector<Eigen::Vector2d> polygon;
    double low_mm = std::numeric_limits<double>::infinity();
    double high_mm = -low_mm;
    for (const auto& place : contour) {
      const Eigen::Vector3d at = stack.axes.transpose() * place;
      polygon.emplace_back(at.x(), at.y());
      low_mm = std::min(low_mm, at.z());
      high_mm = std::max(high_mm, at.z());
    }
    if (high_mm - low_mm > kFlatMm) {
      return make_error(ErrorCode::kInvalidArgument,
                        name + " has contours that are not flat or not parallel: one is " +
                            short_text(high_mm - low_mm) + " mm high, the limit is " +
                            short_text(kFlatMm));
    }
    const double height_mm = 0.5 * (low_mm + high_mm);
    const auto plane =
        std::find_if(stack.planes.begin(), stack.planes.end(), [&](const auto& known) {
          return std::abs(known.height_mm - height_mm) < kSamePlaneMm;
        });
    if (plane != stack.planes.end()) {
      plane->polygons.push_back(std::move(polygon));
    } else {
      stack.planes.push_back({height_mm, {std::move(polygon)}});
    }
  }
  std::sort(stack.planes.begin(), stack.planes.end(), [](const auto& a, const auto& b) {
    return a.height_mm < b.height_mm;
  });
  return stack;
}

Result<ImportHeader> grid_of(const ContourStack& stack, const std::string& name) {
  Eigen::AlignedBox2d box;
  for (const auto& plane : stack.planes)
    for (const auto& polygon : plane.polygons)
      for (const auto& place : polygon) box.extend(place);
  double gap_mm = kMostGapMm;
  for (std::size_t i = 1; i < stack.planes.size(); ++i)
    gap_mm = std::min(gap_mm, stack.planes[i].height_mm - stack.planes[i - 1].height_mm);
  if (stack.planes.size() == 1) gap_mm = kOnePlaneThickMm;
  const double pixel_mm = box.sizes().maxCoeff() < kSmallMm ? kFinePixelMm : kPixelMm;
  const double low_z_mm = stack.planes.front().height_mm - gap_mm;
  const Eigen::Vector3d sides(box.sizes().x() / pixel_mm + 3.0,
                              box.sizes().y() / pixel_mm + 3.0,
                              (stack.planes.back().height_mm - low_z_mm) / gap_mm + 1.5);
  if (!(sides.maxCoeff() <= kMaxVolumeSide) ||
      !(2.0 * sides.prod() <= static_cast<double>(kMaxVolumeBytes))) {
    return make_error(ErrorCode::kInvalidArgument,
                      name + " reaches over " + short_text(box.sizes().x()) + " x " +
                          short_text(box.sizes().y()) + " mm in " +
                          std::to_string(stack.planes.size()) +
                          " planes: that is no structure of a body (the limits are " +
                          std::to_string(kMaxVolumeSide) + " pixels a side and " +
                          std::to_string(kMaxVolumeBytes >> 20) + " MiB)");
  }
  ImportHeader grid;
  grid.magic = kImportMagic;
  for (int axis = 0; axis < 3; ++axis)
    grid.size[static_cast<std::size_t>(axis)] = static_cast<std::int32_t>(sides[axis]) + 1;
  grid.spacing_mm = {pixel_mm, pixel_mm, gap_mm};
  const Eigen::Vector3d origin =
      stack.axes * Eigen::Vector3d(box.min().x() - pixel_mm, box.min().y() - pixel_mm, low_z_mm);
  std::copy_n(origin.data(), 3, grid.origin_mm.begin());
  std::copy_n(stack.axes.data(), 9, grid.axes.begin());
  return grid;
}

void fill(const ContourStack& stack,
          const ImportHeader& grid,
          std::int16_t label,
          std::span<std::int16_t> voxels) {
  const Eigen::Map<const Eigen::Vector3d> origin(grid.origin_mm.data());
  const Eigen::Vector3d corner = stack.axes.transpose() * origin;
  for (int z = 0; z < grid.size[2]; ++z) {
    const double height_mm = corner.z() + z * grid.spacing_mm[2];
    const auto plane = std::min_element(
        stack.planes.begin(), stack.planes.end(), [&](const auto& a, const auto& b) {
          return std::abs(a.height_mm - height_mm) < std::abs(b.height_mm - height_mm);
        });
    const bool is_beyond = height_mm < stack.planes.front().height_mm - 0.5 * grid.spacing_mm[2] ||
                           height_mm > stack.planes.back().height_mm + 0.5 * grid.spacing_mm[2];
    if (is_beyond) continue;
    for (int y = 0; y < grid.size[1]; ++y) {
      const double row_mm = corner.y() + y * grid.spacing_mm[1];
      std::vector<double> crossings;
      for (const auto& polygon : plane->polygons) {
        for (std::size_t i = 0; i < polygon.size(); ++i) {
          const Eigen::Vector2d& a = polygon[i];
          const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
          if ((a.y() <= row_mm) == (b.y() <= row_mm)) continue;
          crossings.push_back(a.x() + (row_mm - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
        }
      }
      std::sort(crossings.begin(), crossings.end());
      const std::size_t row =
          (static_cast<std::size_t>(z) * static_cast<std::size_t>(grid.size[1]) +
           static_cast<std::size_t>(y)) *
          static_cast<std::size_t>(grid.size[0]);
      for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
        const double step = grid.spacing_mm[0];
        const int from = static_cast<int>(std::ceil((crossings[i] - corner.x()) / step));
        const int to = static_cast<int>(std::ceil((crossings[i + 1] - corner.x()) / step));
        for (int x = std::max(from, 0); x < std::min<int>(to, grid.size[0]); ++x)
          voxels[row + static_cast<std::size_t>(x)] = label;
      }
    }
  }
}

}  // namespace mor::import
