// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/skin_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "morgagni/geometry/depth_raster.h"

namespace mor {
namespace {

constexpr int kSamplesPerSide = 2;      ///< Of a pixel: smooth edges.
constexpr float kSameSurfaceMm = 6.0F;  ///< Neighbouring pixels farther apart see two surfaces.

const Eigen::Vector3f kBackground(20.0F, 23.0F, 28.0F);
const Eigen::Vector3f kClay(232.0F, 211.0F, 194.0F);
/// From the upper left, in the frame of the view (x right, y down, z forward).
const Eigen::Vector3f kKeyLight = Eigen::Vector3f(-0.45F, -0.60F, -0.66F).normalized();

/// What shading and interpolation need of a vertex.
struct ShadedVertex {
  float x_px = 0.0F;
  float y_px = 0.0F;
  float inverse_depth = 0.0F;
  float light = 0.0F;
};

float light_at(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) {
  const float facing = std::abs(normal.dot(point.normalized()));
  const float key = std::max(0.0F, normal.dot(kKeyLight));
  const float edge = std::clamp(facing / 0.5F, 0.0F, 1.0F);
  return std::min(1.0F, 0.16F + 0.40F * facing + 0.44F * key) * (0.60F + 0.40F * edge);
}

std::vector<ShadedVertex> shaded_vertices(const TriangleMesh& mesh,
                                          const PinholeCamera& camera,
                                          const Eigen::Isometry3d& camera_from_mesh) {
  const bool has_normals = mesh.normals.size() == mesh.vertices.size();
  const std::vector<Eigen::Vector3f> own =
      has_normals ? std::vector<Eigen::Vector3f>{} : vertex_normals(mesh);
  const std::vector<Eigen::Vector3f>& normals = has_normals ? mesh.normals : own;
  const Eigen::Isometry3f to_camera = camera_from_mesh.cast<float>();
  const auto focal = static_cast<float>(camera.focal_x_px);
  std::vector<ShadedVertex> shaded(mesh.vertices.size());
  for (std::size_t i = 0; i < shaded.size(); ++i) {
    const Eigen::Vector3f point = to_camera * mesh.vertices[i];
    const float inverse = 1.0F / std::max(point.z(), 1.0F);
    shaded[i] = {focal * point.x() * inverse + static_cast<float>(camera.center_x_px),
                 focal * point.y() * inverse + static_cast<float>(camera.center_y_px),
                 inverse,
                 light_at(point, to_camera.linear() * normals[i])};
  }
  return shaded;
}

float cross(const ShadedVertex& a, const ShadedVertex& b, float x, float y) {
  return (b.x_px - a.x_px) * (y - a.y_px) - (b.y_px - a.y_px) * (x - a.x_px);
}

/// The light at a pixel inside of a triangle, interpolated with perspective.
float light_between(const std::array<ShadedVertex, 3>& corners, float x, float y) {
  const auto& [a, b, c] = corners;
  const float weight_a = cross(b, c, x, y) * a.inverse_depth;
  const float weight_b = cross(c, a, x, y) * b.inverse_depth;
  const float weight_c = cross(a, b, x, y) * c.inverse_depth;
  const float sum = weight_a + weight_b + weight_c;
  if (sum == 0.0F) return a.light;
  return (weight_a * a.light + weight_b * b.light + weight_c * c.light) / sum;
}

/// The colour of one pixel from its samples, the mean of them.
class PixelColor {
 public:
  PixelColor(const TriangleMesh& mesh, const DepthRaster& raster, std::vector<ShadedVertex> shaded)
      : mesh_(mesh), raster_(raster), shaded_(std::move(shaded)) {}

  [[nodiscard]] Rgb8 at(int x, int y) const {
    static_assert(kSamplesPerSide == 2);
    const int left = 2 * x;
    const int top = 2 * y;
    const std::array<std::uint32_t, 4> seen{raster_.triangle_idx(left, top),
                                            raster_.triangle_idx(left + 1, top),
                                            raster_.triangle_idx(left, top + 1),
                                            raster_.triangle_idx(left + 1, top + 1)};
    // Most pixels lie within one triangle or on the background: one look is enough.
    if (seen[0] == seen[1] && seen[0] == seen[2] && seen[0] == seen[3]) {
      return to_rgb(
          sample(seen[0], static_cast<float>(left) + 0.5F, static_cast<float>(top) + 0.5F));
    }
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (int i = 0; i < 4; ++i) {
      sum += sample(seen[i], static_cast<float>(left + i % 2), static_cast<float>(top + i / 2));
    }
    return to_rgb(0.25F * sum);
  }

 private:
  [[nodiscard]] Eigen::Vector3f sample(std::uint32_t idx, float x, float y) const {
    if (idx == DepthRaster::kNothing) return kBackground;
    const auto& [a, b, c] = mesh_.triangles[idx];
    return kClay * light_between({shaded_[a], shaded_[b], shaded_[c]}, x, y);
  }

  static Rgb8 to_rgb(const Eigen::Vector3f& color) {
    return {static_cast<std::uint8_t>(color.x() + 0.5F),
            static_cast<std::uint8_t>(color.y() + 0.5F),
            static_cast<std::uint8_t>(color.z() + 0.5F)};
  }

  const TriangleMesh& mesh_;
  const DepthRaster& raster_;
  std::vector<ShadedVertex> shaded_;
};

Image<Rgb8> picture_of(const TriangleMesh& mesh,
                       const PinholeCamera& camera,
                       const Eigen::Isometry3d& camera_from_mesh) {
  const PinholeCamera fine = camera.scaled(kSamplesPerSide);
  const DepthRaster raster = rasterize_depth(mesh, fine, camera_from_mesh);
  const PixelColor color(mesh, raster, shaded_vertices(mesh, fine, camera_from_mesh));
  Image<Rgb8> picture(camera.width_px, camera.height_px);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) picture(x, y) = color.at(x, y);
  }
  return picture;
}

/// Depth between four pixels. 1/z is linear across a plane in the picture; where the four see more
/// than one surface the nearest pixel's own depth holds.
float depth_at(const Image<float>& depth_mm, const Eigen::Vector2d& pixel, float nearest_mm) {
  const int x = static_cast<int>(std::floor(pixel.x()));
  const int y = static_cast<int>(std::floor(pixel.y()));
  if (!depth_mm.view().contains(x, y) || !depth_mm.view().contains(x + 1, y + 1)) {
    return nearest_mm;
  }
  const std::array<float, 4> around{
      depth_mm(x, y), depth_mm(x + 1, y), depth_mm(x, y + 1), depth_mm(x + 1, y + 1)};
  const bool is_one_surface = std::all_of(around.begin(), around.end(), [&](float depth) {
    return depth > 0.0F && std::abs(depth - nearest_mm) < kSameSurfaceMm;
  });
  if (!is_one_surface) return nearest_mm;
  const auto u = static_cast<float>(pixel.x() - x);
  const auto v = static_cast<float>(pixel.y() - y);
  const float upper = (1.0F - u) / around[0] + u / around[1];
  const float lower = (1.0F - u) / around[2] + u / around[3];
  return 1.0F / ((1.0F - v) * upper + v * lower);
}

}  // namespace

std::optional<Eigen::Vector3d> SkinView::ct_point(const Eigen::Vector2d& pixel) const {
  const bool is_inside = pixel.x() >= -0.5 && pixel.y() >= -0.5 &&
                         pixel.x() < depth_mm.width() - 0.5 && pixel.y() < depth_mm.height() - 0.5;
  if (!is_inside) return std::nullopt;  // Not a number neither.
  const float nearest_mm = depth_mm(static_cast<int>(std::floor(pixel.x() + 0.5)),
                                    static_cast<int>(std::floor(pixel.y() + 0.5)));
  if (nearest_mm <= 0.0F) return std::nullopt;
  const Eigen::Vector3d point =
      static_cast<double>(depth_at(depth_mm, pixel, nearest_mm)) * camera.ray(pixel).homogeneous();
  return view_from_ct.inverse() * point;
}

SkinView draw_skin_view(const TriangleMesh& skin, const SkinViewpoint& viewpoint) {
  SkinView view;
  view.camera = view_camera(viewpoint);
  view.view_from_ct = view_from_ct(viewpoint, bounding_sphere(skin));
  view.depth_mm = rasterize_depth(skin, view.camera, view.view_from_ct).depth_mm;
  view.picture = picture_of(skin, view.camera, view.view_from_ct);
  return view;
}

}  // namespace mor
