// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/internal/texel_map.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace mor::internal {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

float cross(const Vector2f& u, const Vector2f& v) {
  return u.x() * v.y() - u.y() * v.x();
}

}  // namespace

std::vector<Texel> texels_of(const SkinAtlas& atlas) {
  std::vector<Texel> texels;
  std::vector<bool> is_taken(static_cast<std::size_t>(atlas.width_px) *
                             static_cast<std::size_t>(atlas.height_px));
  const auto& mesh = atlas.mesh;
  for (std::uint32_t triangle = 0; triangle < atlas.corners_px.size(); ++triangle) {
    const auto& [a, b, c] = atlas.corners_px[triangle];
    const float area = cross(b - a, c - a);
    if (area == 0.0F) continue;
    const auto& [ia, ib, ic] = mesh.triangles[triangle];
    const Vector2f low = a.cwiseMin(b).cwiseMin(c).cwiseMax(0.0F);
    const Vector2f high = a.cwiseMax(b).cwiseMax(c);
    const int last_x = std::min(atlas.width_px - 1, static_cast<int>(std::floor(high.x())));
    const int last_y = std::min(atlas.height_px - 1, static_cast<int>(std::floor(high.y())));
    for (int y = static_cast<int>(std::ceil(low.y())); y <= last_y; ++y) {
      for (int x = static_cast<int>(std::ceil(low.x())); x <= last_x; ++x) {
        const Vector2f p(static_cast<float>(x), static_cast<float>(y));
        const Vector3f share(
            cross(b - p, c - p) / area, cross(c - p, a - p) / area, cross(a - p, b - p) / area);
        // A texel on an edge belongs to the first of its two triangles.
        const auto pixel = static_cast<std::uint32_t>(y * atlas.width_px + x);
        if (!(share.minCoeff() >= -1e-5F) || is_taken[pixel]) continue;
        is_taken[pixel] = true;
        const auto mix = [&](const std::vector<Vector3f>& values) -> Vector3f {
          return share.x() * values[ia] + share.y() * values[ib] + share.z() * values[ic];
        };
        texels.push_back(
            {pixel, triangle, share, mix(mesh.vertices), mix(mesh.normals).normalized()});
      }
    }
  }
  return texels;
}

void fill_gutters(Image<Rgb8>& color, Image<std::uint8_t> is_texel, int num_rings) {
  constexpr std::array<std::array<int, 2>, 8> kAround = {
      {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}}};
  std::vector<std::pair<std::size_t, Rgb8>> ring;
  for (int round = 0; round < num_rings; ++round) {
    ring.clear();
    for (int y = 0; y < color.height(); ++y) {
      for (int x = 0; x < color.width(); ++x) {
        if (is_texel(x, y) != 0) continue;
        for (const auto& [dx, dy] : kAround) {
          if (!is_texel.view().contains(x + dx, y + dy) || is_texel(x + dx, y + dy) == 0) continue;
          ring.emplace_back(&color(x, y) - color.data(), color(x + dx, y + dy));
          break;
        }
      }
    }
    for (const auto& [pixel, value] : ring) {
      color.data()[pixel] = value;
      is_texel.data()[pixel] = 1;
    }
  }
}

}  // namespace mor::internal
