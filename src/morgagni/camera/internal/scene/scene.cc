// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/scene/scene.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "morgagni/camera/internal/scene/skin_marks.h"
#include "morgagni/geometry/depth_raster.h"

namespace mor::internal {
namespace {

using Eigen::Vector3f;

constexpr int kPoreSide = 64;
constexpr float kPoresPerMm = 0.8F;
constexpr float kAmbient = 0.34F;
constexpr float kLamp = 0.50F;  ///< At the camera.
constexpr float kCeiling = 0.30F;
constexpr int kGlossPower = 24;

std::uint8_t to_byte(float value) {
  return static_cast<std::uint8_t>(std::clamp(value, 0.0F, 255.0F));
}

std::uint8_t to_facing(float cosine) {
  return static_cast<std::uint8_t>(std::clamp(255.0F * std::abs(cosine) + 0.5F, 0.0F, 255.0F));
}

/// Fine grain that repeats every 80 mm, which no eye finds.
std::vector<float> make_pores(std::uint64_t seed) {
  std::vector<float> pores(std::size_t{kPoreSide} * kPoreSide * kPoreSide);
  for (std::size_t i = 0; i < pores.size(); ++i) {
    pores[i] = 1.0F + 0.05F * static_cast<float>(to_unit(scramble(seed + 20 + i)) - 0.5);
  }
  return pores;
}

std::size_t pore_at(const Vector3f& at_ct) {
  const auto cell = [](float mm) {
    return static_cast<std::size_t>(static_cast<int>(mm * kPoresPerMm + 65536.0F) &
                                    (kPoreSide - 1));
  };
  return (cell(at_ct.z()) * kPoreSide + cell(at_ct.y())) * kPoreSide + cell(at_ct.x());
}

/// `shade` of 256, at most all of it.
Rgb8 dimmed(const Rgb8& color, unsigned shade) {
  const auto dim = [&](std::uint8_t value) {
    return static_cast<std::uint8_t>(value * shade >> 8U);
  };
  return {dim(color.r), dim(color.g), dim(color.b)};
}

float power(float base, int exponent) {
  float result = 1.0F;
  for (; exponent > 0; exponent /= 2, base *= base) {
    if (exponent % 2 == 1) result *= base;
  }
  return result;
}

}  // namespace

Scene::Scene(const TriangleMesh& skin,
             const PinholeCamera& camera,
             std::uint64_t seed,
             bool is_marked,
             double table_uneven_mm)
    : camera_(camera),
      seed_(seed),
      is_marked_(is_marked),
      table_(skin, seed, table_uneven_mm),
      skin_(painted_as_skin(skin, seed)),
      pores_(make_pores(seed)),
      inverse_ray_length_(camera.width_px, camera.height_px) {
  for (int y = 0; y < camera.height_px; ++y) {
    for (int x = 0; x < camera.width_px; ++x) {
      const Eigen::Vector2d ray = camera.ray({x, y});
      inverse_ray_length_(x, y) = static_cast<float>(1.0 / std::sqrt(ray.squaredNorm() + 1.0));
    }
  }
}

std::vector<Scene::Lit> Scene::light(const PaintedMesh& surface,
                                     const Eigen::Isometry3d& ct_from_camera,
                                     const ShadeMap& shade) const {
  const auto& [mesh, albedo, gloss] = surface;
  const Eigen::Isometry3f camera_from_ct = ct_from_camera.inverse().cast<float>();
  const Vector3f eye = ct_from_camera.translation().cast<float>();
  const Vector3f ceiling = Vector3f(-0.45F, -0.80F, 0.40F).normalized();
  const auto fx = static_cast<float>(camera_.focal_x_px);
  const auto fy = static_cast<float>(camera_.focal_y_px);
  const auto cx = static_cast<float>(camera_.center_x_px);
  const auto cy = static_cast<float>(camera_.center_y_px);
  std::vector<Lit> lit(mesh.vertices.size());
  for (std::size_t i = 0; i < lit.size(); ++i) {
    const Vector3f p = camera_from_ct * mesh.vertices[i];
    const Vector3f to_eye = (eye - mesh.vertices[i]).normalized();
    const float facing = mesh.normals[i].dot(to_eye);
    const float ceiling_facing = mesh.normals[i].dot(ceiling);
    const float brightness =
        shade.light(mesh.vertices[i]) *
        (kAmbient + kLamp * std::max(facing, 0.0F) + kCeiling * std::max(ceiling_facing, 0.0F));
    const Vector3f halfway = (to_eye + ceiling).normalized();
    const float highlight =
        gloss[i] * power(std::max(mesh.normals[i].dot(halfway), 0.0F), kGlossPower);
    const Vector3f color = brightness * albedo[i] + Vector3f::Constant(highlight);
    lit[i] = {
        fx * p.x() / p.z() + cx, fy * p.y() / p.z() + cy, facing, color.x(), color.y(), color.z()};
  }
  return lit;
}

/// What of the surface is nearer than `depth_mm` has so far, which it then takes.
Scene::Seen Scene::look_at(const PaintedMesh& surface,
                           const Eigen::Isometry3d& ct_from_camera,
                           const ShadeMap& shade,
                           Image<float>& depth_mm) const {
  DepthRaster raster = rasterize_depth(surface.mesh, camera_, ct_from_camera.inverse());
  if (depth_mm.empty()) {
    depth_mm = std::move(raster.depth_mm);
  } else {
    for (std::size_t i = 0; i < depth_mm.size(); ++i) {
      const float here_mm = raster.depth_mm.data()[i];
      float& nearest_mm = depth_mm.data()[i];
      const bool is_nearest = here_mm > 0.0F && (nearest_mm == 0.0F || here_mm < nearest_mm);
      nearest_mm = is_nearest ? here_mm : nearest_mm;
      if (!is_nearest) raster.triangle_idx.data()[i] = DepthRaster::kNothing;
    }
  }
  return {&surface.mesh, light(surface, ct_from_camera, shade), std::move(raster.triangle_idx)};
}

void Scene::draw_pixel(
    const Seen& seen, int x, int y, const Vector3f& at_ct, ScenePicture& picture) const {
  const auto& corners = seen.mesh->triangles[seen.triangle_idx(x, y)];
  const auto& lit = seen.lit;
  const Lit& a = lit[corners[0]];
  const Lit& b = lit[corners[1]];
  const Lit& c = lit[corners[2]];
  const float bx = b.x_px - a.x_px;
  const float by = b.y_px - a.y_px;
  const float cx = c.x_px - a.x_px;
  const float cy = c.y_px - a.y_px;
  const float px = static_cast<float>(x) - a.x_px;
  const float py = static_cast<float>(y) - a.y_px;
  const float inverse_area = 1.0F / (bx * cy - by * cx);
  const float u = std::clamp((px * cy - py * cx) * inverse_area, 0.0F, 1.0F);
  const float v = std::clamp((bx * py - by * px) * inverse_area, 0.0F, 1.0F - u);
  const float w = 1.0F - u - v;
  Vector3f light = Vector3f::Constant(pores_[pore_at(at_ct)]);
  if (is_marked_ && seen.mesh == &skin_.mesh) {
    light = light.cwiseProduct(skin_mark_at(at_ct, seed_));
  }
  picture.depth.facing(x, y) = to_facing(w * a.facing + u * b.facing + v * c.facing);
  picture.color(x, y) = {to_byte(light.x() * (w * a.r + u * b.r + v * c.r)),
                         to_byte(light.y() * (w * a.g + u * b.g + v * c.g)),
                         to_byte(light.z() * (w * a.b + u * b.b + v * c.b))};
}

/// Whole rows at once, in vector instructions.
void Scene::look_past_skin(int y,
                           const Vector3f& eye_ct,
                           const Vector3f& first_ray_ct,
                           const Vector3f& ray_step_ct,
                           RoomRow& row) const {
  constexpr float kLeastFall = 1e-3F;  // Flatter rays meet nothing within reach.
  const Eigen::Map<const Eigen::ArrayXf> inverse_length(inverse_ray_length_.view().row(y),
                                                        camera_.width_px);
  const float to_table_mm = table_.top_mm() - eye_ct.y();
  const Eigen::Vector2f below_eye = table_.texel_at(eye_ct.x(), eye_ct.z());
  const float per_fall = to_table_mm * Table::texels_per_mm();
  row.per_fall = (first_ray_ct.y() + ray_step_ct.y() * row.x).max(kLeastFall).inverse();
  row.cosine = (first_ray_ct.y() + ray_step_ct.y() * row.x) * inverse_length;
  row.table_column =
      below_eye.x() + per_fall * row.per_fall * (first_ray_ct.x() + ray_step_ct.x() * row.x);
  row.table_row =
      below_eye.y() + per_fall * row.per_fall * (first_ray_ct.z() + ray_step_ct.z() * row.x);
}

Rgb8 Scene::floor_color(const Vector3f& at_ct, float cosine) const {
  const float grain = 2.0F * (pores_[pore_at(0.3F * at_ct)] - 1.0F);
  return dimmed({58, 64, 72},
                static_cast<unsigned>(240.0F * (0.55F + 0.43F * cosine) * (1.0F + grain)));
}

/// One row of what no surface hides: table or floor; above the horizon, darkness.
void Scene::draw_room_row(const RoomRow& room,
                          const Vector3f& eye_ct,
                          const Vector3f& row_ray,
                          const Vector3f& step_x,
                          int y,
                          const Image<std::uint8_t>& surface,
                          ScenePicture& picture) const {
  const float to_table_mm = table_.top_mm() - eye_ct.y();
  const float to_floor_mm = table_.floor_mm() - eye_ct.y();
  const bool is_above_table = to_table_mm > 0.0F;
  const auto wood = table_.picture();
  const auto num_columns = static_cast<float>(wood.width());
  const auto num_rows = static_cast<float>(wood.height());
  const std::uint8_t* is_hidden = surface.view().row(y);
  float* z_mm = picture.depth.z_mm.view().row(y);
  std::uint8_t* facing = picture.depth.facing.view().row(y);
  Rgb8* color = picture.color.view().row(y);
  for (int x = 0; x < camera_.width_px; ++x) {
    const float cosine = room.cosine[x];
    if (is_hidden[x] != 0 || cosine <= 0.0F) continue;
    const float column = room.table_column[x];
    const float row = room.table_row[x];
    const bool is_table = is_above_table & (column >= 0.0F) & (row >= 0.0F) &
                          (column < num_columns) & (row < num_rows);
    facing[x] = static_cast<std::uint8_t>(255.0F * cosine);
    if (is_table) {
      // Waves are so long that the ray meets them about where it meets the plane.
      const float height_mm = table_.is_level() ? 0.0F : table_.height_mm(column, row);
      z_mm[x] = (to_table_mm - height_mm) * room.per_fall[x];
      color[x] = dimmed(wood(static_cast<int>(column), static_cast<int>(row)),
                        static_cast<unsigned>(158.0F + 98.0F * cosine));
    } else if (to_floor_mm > 0.0F) {
      z_mm[x] = to_floor_mm * room.per_fall[x];
      const Vector3f ray_ct = row_ray + static_cast<float>(x) * step_x;
      color[x] = floor_color(eye_ct + z_mm[x] * ray_ct, cosine);
    }
  }
}

/// Samples at pixel centres leave stairs along the outline: there, and only there, neighbours mix.
void Scene::soften_outline(const Image<std::uint8_t>& surface, Image<Rgb8>& color) const {
  std::vector<std::pair<std::size_t, Rgb8>> softened;
  std::vector<std::uint8_t> is_outline(static_cast<std::size_t>(color.width()), 0);
  for (int y = 1; y + 1 < color.height(); ++y) {
    const std::uint8_t* here = surface.view().row(y);
    const std::uint8_t* above = surface.view().row(y - 1);
    const std::uint8_t* below = surface.view().row(y + 1);
    std::uint8_t* differs = is_outline.data();
    std::uint8_t any = 0;
    for (int x = 1; x + 1 < color.width(); ++x) {
      const auto difference =
          static_cast<std::uint8_t>((here[x] ^ here[x - 1]) | (here[x] ^ here[x + 1]) |
                                    (here[x] ^ above[x]) | (here[x] ^ below[x]));
      differs[x] = difference;
      any |= difference;
    }
    if (any == 0) continue;
    for (int x = 1; x + 1 < color.width(); ++x) {
      if (differs[x] == 0) continue;
      std::array<int, 3> sum{};
      for (const auto& [dx, dy, weight] :
           {std::array{0, 0, 4}, {-1, 0, 1}, {1, 0, 1}, {0, -1, 1}, {0, 1, 1}}) {
        const Rgb8& neighbor = color(x + dx, y + dy);
        sum[0] += weight * neighbor.r;
        sum[1] += weight * neighbor.g;
        sum[2] += weight * neighbor.b;
      }
      const auto mean = [](int total) { return static_cast<std::uint8_t>(total / 8); };
      softened.push_back({static_cast<std::size_t>(&color(x, y) - color.data()),
                          {mean(sum[0]), mean(sum[1]), mean(sum[2])}});
    }
  }
  for (const auto& [index, mixed] : softened) color.data()[index] = mixed;
}

ScenePicture Scene::draw(const Eigen::Isometry3d& ct_from_camera, const PaintedMesh& things) const {
  const bool has_things = !things.mesh.empty();
  const ShadeMap shade = has_things ? ShadeMap(things.mesh) : ShadeMap();
  ScenePicture picture{{{}, Image<std::uint8_t>(camera_.width_px, camera_.height_px, 0)},
                       Image<Rgb8>(camera_.width_px, camera_.height_px)};
  // The later one lies in front where both have a triangle.
  std::vector<Seen> surfaces;
  surfaces.push_back(look_at(skin_, ct_from_camera, shade, picture.depth.z_mm));
  if (has_things) {
    surfaces.push_back(look_at(things, ct_from_camera, shade, picture.depth.z_mm));
  }
  const Eigen::Matrix3f rotation = ct_from_camera.linear().cast<float>();
  const Vector3f eye_ct = ct_from_camera.translation().cast<float>();
  Image<std::uint8_t> surface(camera_.width_px, camera_.height_px, 0);
  RoomRow room(camera_.width_px);
  const Vector3f step_x = rotation.col(0) * static_cast<float>(1.0 / camera_.focal_x_px);
  const Vector3f step_y = rotation.col(1) * static_cast<float>(1.0 / camera_.focal_y_px);
  const Vector3f first_ray = rotation.col(2) - step_x * static_cast<float>(camera_.center_x_px) -
                             step_y * static_cast<float>(camera_.center_y_px);
  for (int y = 0; y < camera_.height_px; ++y) {
    const Vector3f row_ray = first_ray + static_cast<float>(y) * step_y;
    look_past_skin(y, eye_ct, row_ray, step_x, room);
    const float* z_mm = picture.depth.z_mm.view().row(y);
    const auto at_ct = [&](int x) {
      return Vector3f(eye_ct + z_mm[x] * (row_ray + static_cast<float>(x) * step_x));
    };
    for (const Seen& seen : surfaces) {
      const std::uint32_t* triangle = seen.triangle_idx.view().row(y);
      for (int x = 0; x < camera_.width_px; ++x) {
        if (triangle[x] == DepthRaster::kNothing) continue;
        draw_pixel(seen, x, y, at_ct(x), picture);
        surface(x, y) = static_cast<std::uint8_t>(1 + (&seen - surfaces.data()));
      }
    }
    draw_room_row(room, eye_ct, row_ray, step_x, y, surface, picture);
    if (!has_things) continue;
    for (int x = 0; x < camera_.width_px; ++x) {
      if (surface(x, y) != 0 || z_mm[x] <= 0.0F) continue;
      auto& color = picture.color(x, y);
      color = dimmed(color, static_cast<unsigned>(256.0F * shade.light(at_ct(x))));
    }
  }
  soften_outline(surface, picture.color);
  return picture;
}

}  // namespace mor::internal
