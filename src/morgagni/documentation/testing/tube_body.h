// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>

#include "morgagni/documentation/export_model.h"
#include "morgagni/documentation/skin_texture.h"

namespace mor::testing_body {

inline constexpr int kAround = 48;  ///< Vertices around the tube,
inline constexpr int kUp = 25;      ///< and along it.
inline constexpr int kAtlasWidth = 520;
inline constexpr int kAtlasHeight = 210;
/// Beyond this height no camera saw the skin.
inline constexpr float kSeenToMm = 200.0F;

inline Eigen::Vector3f tube_place(int around, int up) {
  const float angle =
      2.0F * std::numbers::pi_v<float> * static_cast<float>(around % kAround) / kAround;
  const float z = 40.0F + 200.0F * static_cast<float>(up) / (kUp - 1);
  const float bulge = 1.0F + 0.15F * std::sin(z / 40.0F);
  return {20.0F + 85.0F * bulge * std::cos(angle), -30.0F + 60.0F * bulge * std::sin(angle), z};
}

/// A body like a trunk: a tube along z, open at both ends as where a CT ends, counter-clockwise
/// from outside. Front (y < -30), back, left and right differ.
inline TriangleMesh tube_skin() {
  TriangleMesh mesh;
  for (int up = 0; up < kUp; ++up)
    for (int around = 0; around < kAround; ++around)
      mesh.vertices.push_back(tube_place(around, up));
  for (int up = 0; up + 1 < kUp; ++up) {
    for (int around = 0; around < kAround; ++around) {
      const auto at = [](int a, int u) {
        return static_cast<std::uint32_t>(u * kAround + a % kAround);
      };
      mesh.triangles.push_back({at(around, up), at(around + 1, up), at(around + 1, up + 1)});
      mesh.triangles.push_back({at(around, up), at(around + 1, up + 1), at(around, up + 1)});
    }
  }
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

inline Rgb8 tube_color(int x, int y) {
  const bool is_dark = (x / 26 + y / 25) % 2 == 0;
  return {static_cast<std::uint8_t>(is_dark ? 120 : 220),
          static_cast<std::uint8_t>(60 + x * 150 / kAtlasWidth),
          static_cast<std::uint8_t>(60 + y * 150 / kAtlasHeight)};
}

/// The tube unrolled into a picture with one seam; squares of colours, the upper part never seen.
inline SkinTexture tube_texture() {
  auto atlas = std::make_shared<SkinAtlas>();
  atlas->mesh = tube_skin();
  atlas->width_px = kAtlasWidth;
  atlas->height_px = kAtlasHeight;
  const auto place = [](int around, int up) {
    return Eigen::Vector2f(10.0F + (kAtlasWidth - 20.0F) * static_cast<float>(around) / kAround,
                           10.0F + (kAtlasHeight - 20.0F) * static_cast<float>(up) / (kUp - 1));
  };
  for (int up = 0; up + 1 < kUp; ++up) {
    for (int a = 0; a < kAround; ++a) {
      atlas->corners_px.push_back({place(a, up), place(a + 1, up), place(a + 1, up + 1)});
      atlas->corners_px.push_back({place(a, up), place(a + 1, up + 1), place(a, up + 1)});
    }
  }
  SkinTexture texture;
  texture.color = Image<Rgb8>(kAtlasWidth, kAtlasHeight);
  texture.sources = Image<TexelSource>(kAtlasWidth, kAtlasHeight);
  const int last_seen =
      static_cast<int>(10.0F + (kAtlasHeight - 20.0F) * (kSeenToMm - 40.0F) / 200.0F);
  for (int y = 0; y < kAtlasHeight; ++y) {
    for (int x = 0; x < kAtlasWidth; ++x) {
      const bool is_skin = x >= 10 && y >= 10 && x <= kAtlasWidth - 10 && y <= kAtlasHeight - 10;
      if (!is_skin || y > last_seen) continue;
      texture.color(x, y) = tube_color(x, y);
      texture.sources(x, y) = {0, 0.2F, 600.0F, 0.9F};
    }
  }
  texture.frames = {{1, 1795708805000, Eigen::Isometry3d::Identity(), 1.5}};
  texture.atlas = atlas;
  return texture;
}

/// A closed ball, an octahedron divided, inside of the tube.
inline ExportSurface ball(const std::string& name, Rgb8 color, const Eigen::Vector3f& center_mm) {
  ExportSurface surface{name, color, {}, {}};
  auto& mesh = surface.mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {
      {0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  mesh.normals = mesh.vertices;
  surface = subdivided(std::move(surface), 3);
  for (std::size_t i = 0; i < surface.mesh.vertices.size(); ++i) {
    const Eigen::Vector3f direction = surface.mesh.vertices[i].normalized();
    surface.mesh.normals[i] = direction;
    surface.mesh.vertices[i] = center_mm + 25.0F * direction;
  }
  return surface;
}

inline ExportModel tube_model() {
  const SkinTexture texture = tube_texture();
  return *make_export_model(texture.atlas->mesh,
                            &texture,
                            {ball("bone", {237, 227, 199}, {20, -30, 100}),
                             ball("left kidney", {180, 70, 60}, {60, -20, 170})});
}

}  // namespace mor::testing_body
