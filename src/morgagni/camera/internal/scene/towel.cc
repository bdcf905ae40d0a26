// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/scene/towel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "morgagni/camera/internal/scene/table.h"
#include "morgagni/core/image.h"

namespace mor::internal {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float kCellMm = 6.0F;
constexpr float kThicknessMm = 4.0F;
constexpr float kSteepest = 1.6F;  ///< Height lost a millimetre of way.

constexpr std::array<std::array<float, 3>, 4> kCloths = {
    {{206, 210, 208}, {96, 150, 136}, {104, 146, 188}, {196, 182, 160}}};

float between(Draws& draw, double least, double most) {
  return static_cast<float>(draw(least, most));
}

struct Sheet {
  Vector2f center;
  Vector2f right;  ///< Unit, over the table.
  Vector2f up;
  int columns;
  int rows;

  [[nodiscard]] Vector2f place(int column, int row) const {
    return center +
           kCellMm * ((static_cast<float>(column) - 0.5F * static_cast<float>(columns)) * right +
                      (static_cast<float>(row) - 0.5F * static_cast<float>(rows)) * up);
  }
};

/// Covers a part of the body from a random side.
Sheet draw_sheet(const Eigen::AlignedBox2f& area, Draws& draw) {
  const float turn_rad = between(draw, 0.0, 2.0 * std::numbers::pi);
  const Vector2f away(std::cos(turn_rad), std::sin(turn_rad));
  const Vector2f half = 0.5F * area.sizes();
  // To the body's edge in that direction (an ellipse), and somewhat in.
  const float edge_mm = 1.0F / away.cwiseQuotient(half).norm();
  const float angle_rad = turn_rad + between(draw, -0.5, 0.5);
  Sheet sheet;
  sheet.center = area.center() + between(draw, 0.8, 1.1) * edge_mm * away;
  sheet.right = {std::cos(angle_rad), std::sin(angle_rad)};
  sheet.up = {-sheet.right.y(), sheet.right.x()};
  const float scale = std::clamp(half.norm() / 240.0F, 0.4F, 1.2F);
  sheet.columns = static_cast<int>(scale * between(draw, 130.0, 200.0) / kCellMm);
  sheet.rows = static_cast<int>(scale * between(draw, 200.0, 330.0) / kCellMm);
  return sheet;
}

/// No cell lower than a neighbour's height less what the way allows: two sweeps.
void limit_slope(Image<float>& height_mm) {
  const auto relax = [&](int x, int y, int dx, int dy) {
    if (!height_mm.view().contains(x + dx, y + dy)) return;
    const float way_mm = kCellMm * (dx != 0 && dy != 0 ? std::numbers::sqrt2_v<float> : 1.0F);
    height_mm(x, y) = std::max(height_mm(x, y), height_mm(x + dx, y + dy) - kSteepest * way_mm);
  };
  for (int y = 0; y < height_mm.height(); ++y) {
    for (int x = 0; x < height_mm.width(); ++x) {
      relax(x, y, -1, 0);
      for (int dx = -1; dx <= 1; ++dx) relax(x, y, dx, -1);
    }
  }
  for (int y = height_mm.height() - 1; y >= 0; --y) {
    for (int x = height_mm.width() - 1; x >= 0; --x) {
      relax(x, y, 1, 0);
      for (int dx = -1; dx <= 1; ++dx) relax(x, y, dx, 1);
    }
  }
}

/// Cloth bends over edges and spans hollows, but never sinks into what carries it.
void stiffen(const Image<float>& least_mm, Image<float>& height_mm) {
  constexpr int kPasses = 12;
  for (int pass = 0; pass < kPasses; ++pass) {
    Image<float> next = height_mm;
    for (int y = 1; y + 1 < next.height(); ++y) {
      for (int x = 1; x + 1 < next.width(); ++x) {
        const float mean = 0.25F * (height_mm(x - 1, y) + height_mm(x + 1, y) +
                                    height_mm(x, y - 1) + height_mm(x, y + 1));
        next(x, y) = std::max(mean, least_mm(x, y));
      }
    }
    height_mm = std::move(next);
  }
}

}  // namespace

PaintedMesh draped_towel(const Eigen::AlignedBox2f& area,
                         const HeightMap& ground,
                         float table_top_mm,
                         Draws& draw) {
  const Sheet sheet = draw_sheet(area, draw);
  Image<float> carried_mm(sheet.columns, sheet.rows);
  for (int row = 0; row < sheet.rows; ++row) {
    for (int column = 0; column < sheet.columns; ++column) {
      const Vector2f at = sheet.place(column, row);
      carried_mm(column, row) = ground.height_mm(at.x(), at.y()) + kThicknessMm;
    }
  }
  Image<float> height_mm = carried_mm;
  limit_slope(height_mm);
  stiffen(carried_mm, height_mm);
  const auto seed = static_cast<std::uint64_t>(draw(0.0, 1e9));
  const float fold_mm = between(draw, 5.0, 14.0);
  const float stretch = between(draw, 0.012, 0.022);
  const auto& cloth = kCloths[draw.choice(kCloths.size())];
  PaintedMesh towel;
  for (int row = 0; row < sheet.rows; ++row) {
    for (int column = 0; column < sheet.columns; ++column) {
      const Vector2f at = sheet.place(column, row);
      const float u = stretch * kCellMm * static_cast<float>(column);
      const float v = 0.35F * stretch * kCellMm * static_cast<float>(row);
      // Ridges where smooth noise passes its middle, long along the sheet.
      const float ridge =
          1.0F - std::abs(2.0F * smooth_noise(2.0F * u, 2.0F * v, 0.5F, seed) - 1.0F);
      const float fold = fold_mm * ridge * ridge;
      towel.mesh.vertices.emplace_back(
          at.x(), table_top_mm - height_mm(column, row) - fold, at.y());
      const bool is_stripe = row % 20 < 2 && (row < 22 || row > sheet.rows - 22);
      towel.albedo.push_back((is_stripe ? 0.72F : 1.0F) * Vector3f(cloth[0], cloth[1], cloth[2]));
      if (row == 0 || column == 0) continue;
      const auto corner = static_cast<std::uint32_t>(row * sheet.columns + column);
      const auto above = corner - static_cast<std::uint32_t>(sheet.columns);
      towel.mesh.triangles.push_back({above - 1, above, corner});
      towel.mesh.triangles.push_back({above - 1, corner, corner - 1});
    }
  }
  towel.mesh.normals = vertex_normals(towel.mesh);
  towel.gloss.assign(towel.mesh.vertices.size(), 0.0F);
  return towel;
}

}  // namespace mor::internal
