// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/texture_view.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "morgagni/documentation/internal/far_view.h"
#include "morgagni/geometry/depth_raster.h"

namespace mor {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr int kFiner = 2;  ///< Drawn so much larger each way, and averaged.
constexpr int kStripePx = 5 * kFiner;

Vector3f shares_of(const TriangleMesh& mesh, const Triangle& corners, const Vector3f& p) {
  const Vector3f a = mesh.vertices[corners[0]];
  const Vector3f u = mesh.vertices[corners[1]] - a;
  const Vector3f v = mesh.vertices[corners[2]] - a;
  const Vector3f across = u.cross(v);
  const float area_sq = across.squaredNorm();
  if (area_sq <= 0.0F) return {1.0F, 0.0F, 0.0F};
  const Vector3f w = p - a;
  const float to_b = std::clamp(w.cross(v).dot(across) / area_sq, 0.0F, 1.0F);
  const float to_c = std::clamp(u.cross(w).dot(across) / area_sq, 0.0F, 1.0F - to_b);
  return {1.0F - to_b - to_c, to_b, to_c};
}

Vector3f to_vector(const Rgb8& color) {
  return {static_cast<float>(color.r), static_cast<float>(color.g), static_cast<float>(color.b)};
}

Vector3f between_texels(const Image<Rgb8>& image, const Vector2f& at) {
  const float x = std::clamp(at.x(), 0.0F, static_cast<float>(image.width() - 1));
  const float y = std::clamp(at.y(), 0.0F, static_cast<float>(image.height() - 1));
  const int left = static_cast<int>(x);
  const int top = static_cast<int>(y);
  const int right = std::min(left + 1, image.width() - 1);
  const int bottom = std::min(top + 1, image.height() - 1);
  const float tx = x - static_cast<float>(left);
  const float ty = y - static_cast<float>(top);
  return (1.0F - ty) *
             ((1.0F - tx) * to_vector(image(left, top)) + tx * to_vector(image(right, top))) +
         ty * ((1.0F - tx) * to_vector(image(left, bottom)) + tx * to_vector(image(right, bottom)));
}

/// Whether one of the four texels around a place was seen: at a chart's rim the nearest may lie
/// outside of it.
bool is_seen_near(const SkinTexture& texture, const Vector2f& at) {
  const int left = static_cast<int>(std::floor(at.x()));
  const int top = static_cast<int>(std::floor(at.y()));
  for (int y = std::max(top, 0); y <= std::min(top + 1, texture.sources.height() - 1); ++y) {
    for (int x = std::max(left, 0); x <= std::min(left + 1, texture.sources.width() - 1); ++x) {
      if (texture.is_seen(x, y)) return true;
    }
  }
  return false;
}

Vector3f unseen_color(float facing, int x, int y) {
  const bool is_stripe = (x + y) / kStripePx % 2 == 0;
  const Vector3f base = is_stripe ? Vector3f(238, 140, 60) : Vector3f(214, 210, 204);
  return (0.45F + 0.55F * std::max(facing, 0.0F)) * base;
}

}  // namespace

Image<Rgb8> draw_skin_texture(const SkinTexture& texture,
                              const Eigen::Vector3d& from,
                              int width_px,
                              int height_px) {
  const auto& atlas = *texture.atlas;
  const auto& mesh = atlas.mesh;
  const Eigen::Vector3d towards = from.normalized();
  const internal::FarView view(mesh.bounds(), towards, kFiner * width_px, kFiner * height_px);
  const auto raster = rasterize_depth(mesh, view.camera, view.view_from_ct);
  const Eigen::Isometry3f ct_from_view = view.view_from_ct.inverse().cast<float>();
  Image<Rgb8> picture(width_px, height_px, {255, 255, 255});
  const auto color_at = [&](int x, int y) -> Vector3f {
    const auto triangle = raster.triangle_idx(x, y);
    if (triangle == DepthRaster::kNothing) return Vector3f::Constant(255.0F);
    const float z = raster.depth_mm(x, y);
    const Eigen::Vector2f ray = view.camera.ray({x, y}).cast<float>();
    const Vector3f p = ct_from_view * Vector3f(z * ray.x(), z * ray.y(), z);
    const auto& corners = mesh.triangles[triangle];
    const Vector3f share = shares_of(mesh, corners, p);
    const Vector3f normal = share.x() * mesh.normals[corners[0]] +
                            share.y() * mesh.normals[corners[1]] +
                            share.z() * mesh.normals[corners[2]];
    const float facing = normal.normalized().dot(towards.cast<float>());
    // The inside of the shell, through a hole.
    if (facing <= 0.0F) return Vector3f::Constant(70.0F);
    const auto& [a, b, c] = atlas.corners_px[triangle];
    const Vector2f at = share.x() * a + share.y() * b + share.z() * c;
    if (!is_seen_near(texture, at)) return unseen_color(facing, x, y);
    return between_texels(texture.color, at);
  };
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x) {
      Vector3f sum = Vector3f::Zero();
      for (int dy = 0; dy < kFiner; ++dy) {
        for (int dx = 0; dx < kFiner; ++dx) sum += color_at(kFiner * x + dx, kFiner * y + dy);
      }
      sum = sum / (kFiner * kFiner) + Vector3f::Constant(0.5F);
      picture(x, y) = {static_cast<std::uint8_t>(std::min(sum.x(), 255.0F)),
                       static_cast<std::uint8_t>(std::min(sum.y(), 255.0F)),
                       static_cast<std::uint8_t>(std::min(sum.z(), 255.0F))};
    }
  }
  return picture;
}

Image<Rgb8> draw_four_sides(const SkinTexture& texture, int side_width_px, int height_px) {
  // Supine: the front looks to -y, the patient's left is +x.
  const std::array<Eigen::Vector3d, 4> sides = {{{0, -1, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}}};
  Image<Rgb8> picture(4 * side_width_px, height_px);
  for (int side = 0; side < 4; ++side) {
    const auto part =
        draw_skin_texture(texture, sides[static_cast<std::size_t>(side)], side_width_px, height_px);
    for (int y = 0; y < height_px; ++y) {
      std::copy_n(part.view().row(y), side_width_px, picture.view().row(y) + side * side_width_px);
    }
  }
  return picture;
}

}  // namespace mor
