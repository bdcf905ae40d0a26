// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/export_model.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include <spdlog/fmt/fmt.h>

#include "morgagni/documentation/internal/atlas_picture.h"

namespace mor {
namespace {

Result<void> check_texture(const SkinTexture& texture) {
  if (!texture.atlas) return make_error(ErrorCode::kInvalidArgument, "a texture needs its atlas");
  MOR_CHECK(texture.atlas->check());
  const auto fits = [&](int width, int height) {
    return width == texture.atlas->width_px && height == texture.atlas->height_px;
  };
  if (!fits(texture.color.width(), texture.color.height()) ||
      !fits(texture.sources.width(), texture.sources.height())) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("the texture's picture is {}x{} px, its atlas {}x{} px",
                                  texture.color.width(),
                                  texture.color.height(),
                                  texture.atlas->width_px,
                                  texture.atlas->height_px));
  }
  return {};
}

/// A vertex of the mesh at a place of the picture.
struct Corner {
  std::uint32_t vertex;
  float x_px;
  float y_px;
  bool operator==(const Corner&) const = default;
};

struct CornerHash {
  std::size_t operator()(const Corner& corner) const {
    const std::hash<float> hash;
    return corner.vertex * std::size_t{0x9E3779B97F4A7C15U} ^ hash(corner.x_px) * 31U ^
           hash(corner.y_px);
  }
};

/// Vertices on the atlas's seams are split, so that each has one place in the picture.
ExportSurface split_at_seams(const SkinAtlas& atlas) {
  ExportSurface surface;
  const TriangleMesh& mesh = atlas.mesh;
  std::unordered_map<Corner, std::uint32_t, CornerHash> known;
  known.reserve(mesh.vertices.size() * 2);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Triangle triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& place = atlas.corners_px[t][k];
      const std::uint32_t vertex = mesh.triangles[t][k];
      const auto [found, is_new] = known.try_emplace(
          {vertex, place.x(), place.y()}, static_cast<std::uint32_t>(surface.mesh.vertices.size()));
      triangle[k] = found->second;
      if (!is_new) continue;
      surface.mesh.vertices.push_back(mesh.vertices[vertex]);
      surface.mesh.normals.push_back(mesh.normals[vertex]);
      surface.picture_px.push_back(place);
    }
    surface.mesh.triangles.push_back(triangle);
  }
  return surface;
}

void ensure_normals(TriangleMesh& mesh) {
  if (mesh.normals.size() != mesh.vertices.size()) mesh.normals = vertex_normals(mesh);
}

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return (static_cast<std::uint64_t>(std::min(a, b)) << 32U) | std::max(a, b);
}

/// The vertices in the middles of edges, made when first asked for.
class Midpoints {
 public:
  explicit Midpoints(ExportSurface& surface) : surface_(surface) {}

  std::uint32_t between(std::uint32_t a, std::uint32_t b) {
    auto& mesh = surface_.mesh;
    const auto [found, is_new] =
        known_.try_emplace(edge_key(a, b), static_cast<std::uint32_t>(mesh.vertices.size()));
    if (is_new) {
      mesh.vertices.emplace_back(0.5F * (mesh.vertices[a] + mesh.vertices[b]));
      mesh.normals.emplace_back((mesh.normals[a] + mesh.normals[b]).stableNormalized());
      if (!surface_.picture_px.empty()) {
        surface_.picture_px.emplace_back(0.5F * (surface_.picture_px[a] + surface_.picture_px[b]));
      }
    }
    return found->second;
  }

 private:
  ExportSurface& surface_;
  std::unordered_map<std::uint64_t, std::uint32_t> known_;
};

}  // namespace

Result<ExportModel> make_export_model(const TriangleMesh& skin,
                                      const SkinTexture* texture,
                                      std::vector<ExportSurface> structures) {
  if (skin.empty()) return make_error(ErrorCode::kInvalidArgument, "the case has no skin");
  ExportModel model;
  if (texture != nullptr) {
    MOR_CHECK(check_texture(*texture));
    SkinAtlas atlas = *texture->atlas;
    ensure_normals(atlas.mesh);
    auto painted = internal::paint_atlas(*texture);
    model.skin = split_at_seams(atlas);
    model.skin_mesh = std::move(atlas.mesh);
    model.picture = std::move(painted.picture);
    model.seen_share = painted.seen_share;
  } else {
    model.skin_mesh = skin;
    ensure_normals(model.skin_mesh);
    model.skin.mesh = model.skin_mesh;
  }
  model.skin.name = "skin";
  model.skin.color = kPlainSkinColor;
  for (auto& structure : structures) ensure_normals(structure.mesh);
  model.structures = std::move(structures);
  return model;
}

Rgb8 sample_picture(const Image<Rgb8>& picture, const Eigen::Vector2f& place_px) {
  const float x = std::clamp(place_px.x(), 0.0F, static_cast<float>(picture.width() - 1));
  const float y = std::clamp(place_px.y(), 0.0F, static_cast<float>(picture.height() - 1));
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, picture.width() - 1);
  const int y1 = std::min(y0 + 1, picture.height() - 1);
  const float right = x - static_cast<float>(x0);
  const float below = y - static_cast<float>(y0);
  const auto mix = [&](std::uint8_t Rgb8::*channel) {
    const auto at = [&](int px, int py) { return static_cast<float>(picture(px, py).*channel); };
    const float upper = at(x0, y0) * (1.0F - right) + at(x1, y0) * right;
    const float lower = at(x0, y1) * (1.0F - right) + at(x1, y1) * right;
    return static_cast<std::uint8_t>(std::lround(upper * (1.0F - below) + lower * below));
  };
  return {mix(&Rgb8::r), mix(&Rgb8::g), mix(&Rgb8::b)};
}

ExportSurface subdivided(ExportSurface surface, int levels) {
  for (int level = 0; level < levels; ++level) {
    Midpoints midpoints(surface);
    std::vector<Triangle> finer;
    finer.reserve(surface.mesh.triangles.size() * 4);
    for (const auto& [a, b, c] : surface.mesh.triangles) {
      const auto ab = midpoints.between(a, b);
      const auto bc = midpoints.between(b, c);
      const auto ca = midpoints.between(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    surface.mesh.triangles = std::move(finer);
  }
  return surface;
}

}  // namespace mor
