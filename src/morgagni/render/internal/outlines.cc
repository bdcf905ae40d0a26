// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/outlines.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace mor::internal {
namespace {

constexpr float kBehindMm = 2.0F;  ///< Nearer than this, it is the structure itself.
constexpr float kFoldMm = 9.0F;    ///< Between a pixel and where its neighbours lead to expect it.
constexpr int kLeastHiding = 96;   ///< Of 255, of what is before it together.
constexpr float kInHole = 0.85F;   ///< Strength of the lines
constexpr float kUnderSkin = 0.6F;
constexpr float kWhitened = 0.35F;  ///< Lines are lighter than their structures: they lie on them.

/// Pixels at which the structure ends, or folds over itself: its nearer side of the step.
std::vector<std::uint8_t> edges_of(const Layer& layer) {
  const PixelBox& box = layer.box;
  std::vector<std::uint8_t> edges(layer.depth_mm.size());
  for (int y = 1; y + 1 < box.height; ++y) {
    const float* here = layer.depth_mm.data() + static_cast<std::size_t>(y) * box.width;
    const float* above = here - box.width;
    const float* below = here + box.width;
    for (int x = 1; x + 1 < box.width; ++x) {
      const float depth = here[x];
      if (depth == kNoDepth) continue;
      const auto steps_back = [depth](float a, float b) {
        if (a == kNoDepth || b == kNoDepth) return true;
        return std::max(a, b) - depth > kFoldMm && std::abs(a + b - 2.0F * depth) > kFoldMm;
      };
      if (steps_back(here[x - 1], here[x + 1]) || steps_back(above[x], below[x])) {
        edges[static_cast<std::size_t>(y) * box.width + x] = 1;
      }
    }
  }
  return edges;
}

/// 0..1: the edge's pixels and, weaker, those beside them, so that a line has no stairs.
float line_at(const std::vector<std::uint8_t>& edges, int width, std::size_t i) {
  const auto w = static_cast<std::size_t>(width);
  const int sides = edges[i - 1] + edges[i + 1] + edges[i - w] + edges[i + w];
  const int corners = edges[i - w - 1] + edges[i - w + 1] + edges[i + w - 1] + edges[i + w + 1];
  const int sum = 4 * edges[i] + 2 * sides + corners;
  return std::min(1.0F, static_cast<float>(sum) / 8.0F);
}

/// How much of a point at this depth is hidden, 0..1, and outside of the hole all of it.
float hidden_share(const OutlineScene& scene, int x, int y, float depth_mm) {
  const PixelBox& box = scene.mask->box();
  const int column = x - box.left;
  const bool is_in_box =
      column >= 0 && column < box.width && y >= box.top && y < box.top + box.height;
  if (!is_in_box) return kUnderSkin;
  const float open = static_cast<float>(scene.mask->row(y)[column].structure) / 255.0F;
  int hiding = 0;
  for (const Layer& layer : scene.layers) {
    const int left = x - layer.box.left;
    const int down = y - layer.box.top;
    if (left < 0 || down < 0 || left >= layer.box.width || down >= layer.box.height) continue;
    if (layer.depth_row(y)[left] < depth_mm - kBehindMm) hiding += layer.row(y)[left].a;
  }
  if (scene.volume != nullptr) hiding += scene.volume->row(y)[column].a;
  return (1.0F - open) * kUnderSkin + (hiding >= kLeastHiding ? open * kInHole : 0.0F);
}

void mix(Rgba8& pixel, const Eigen::Vector3f& color, float share) {
  const auto mixed = [share](std::uint8_t under, float over) {
    const float value = static_cast<float>(under) * (1.0F - share) + 255.0F * over * share;
    return static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
  };
  pixel = {mixed(pixel.r, color.x()), mixed(pixel.g, color.y()), mixed(pixel.b, color.z()), 255};
}

/// The depth of the structure at a pixel of its line, which may lie beside it.
float depth_beside(const Layer& layer, std::size_t i) {
  const auto w = static_cast<std::size_t>(layer.box.width);
  float depth = layer.depth_mm[i];
  for (const std::size_t j : {i - 1, i + 1, i - w, i + w}) {
    depth = std::min(depth, layer.depth_mm[j]);
  }
  return depth;
}

}  // namespace

void draw_hidden_outlines(std::span<const OutlinedStructure> structures,
                          const OutlineScene& scene,
                          ImageView<Rgba8> picture) {
  for (const auto& [layer, color] : structures) {
    const PixelBox& box = layer.box;
    const Eigen::Vector3f lighter =
        color + kWhitened * (Eigen::Vector3f::Ones() - color).cwiseMax(0.0F);
    const std::vector<std::uint8_t> edges = edges_of(layer);
    for (int y = 1; y + 1 < box.height; ++y) {
      const int row = box.top + y;
      for (int x = 1; x + 1 < box.width; ++x) {
        const std::size_t i = static_cast<std::size_t>(y) * box.width + x;
        const float line = line_at(edges, box.width, i);
        if (line <= 0.0F) continue;
        const int column = box.left + x;
        float share = line * hidden_share(scene, column, row, depth_beside(layer, i));
        if (share <= 0.0F) continue;
        share *= scene.grid->body_share(scene.rays->row(row)[column]);
        if (scene.occluders != nullptr) {
          share *= 1.0F - static_cast<float>(scene.occluders->row(row, column)[0]) / 255.0F;
        }
        mix(picture.row(row)[column], lighter, share);
      }
    }
  }
}

}  // namespace mor::internal
