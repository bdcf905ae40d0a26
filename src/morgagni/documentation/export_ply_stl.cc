// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/version.h"
#include "morgagni/documentation/export_formats.h"
#include "morgagni/documentation/internal/binary_writer.h"

namespace mor {
namespace {

using internal::put;

constexpr double kColorSpacingMm = 1.2;
constexpr std::size_t kMostTriangles = 1'500'000;
constexpr std::size_t kStlHeadBytes = 80;

std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < ' '; }, ' ');
  return text;
}

/// How often to halve the edges so that the picture's detail lives on in vertices.
int levels_for_colors(const TriangleMesh& mesh) {
  if (mesh.empty()) return 0;
  const double mean_area = surface_area_mm2(mesh) / static_cast<double>(mesh.triangles.size());
  double edge_mm = std::sqrt(mean_area * 4.0 / std::sqrt(3.0));
  std::size_t num_triangles = mesh.triangles.size();
  int levels = 0;
  while (edge_mm > kColorSpacingMm && num_triangles * 4 <= kMostTriangles) {
    edge_mm *= 0.5;
    num_triangles *= 4;
    ++levels;
  }
  return levels;
}

}  // namespace

std::string encode_colored_ply(const ExportSurface& surface,
                               const Image<Rgb8>& picture,
                               const ExportTitle& title) {
  const bool is_textured = !surface.picture_px.empty();
  const ExportSurface fine = subdivided(surface, is_textured ? levels_for_colors(surface.mesh) : 0);
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment {}: {}\ncomment Morgagni {}, {}\n"
      "comment Millimetres; x to the body's left, y to the back, z to the head (LPS)\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      one_line(title.title),
      one_line(surface.name),
      kVersion,
      title.created_at,
      fine.mesh.vertices.size(),
      fine.mesh.triangles.size());
  bytes.reserve(bytes.size() + fine.mesh.vertices.size() * 27 + fine.mesh.triangles.size() * 13);
  for (std::size_t i = 0; i < fine.mesh.vertices.size(); ++i) {
    put(bytes, fine.mesh.vertices[i]);
    put(bytes, fine.mesh.normals[i]);
    put(bytes, is_textured ? sample_picture(picture, fine.picture_px[i]) : surface.color);
  }
  for (const auto& triangle : fine.mesh.triangles) {
    put(bytes, std::uint8_t{3});
    put(bytes, triangle);
  }
  return bytes;
}

std::string encode_stl(const TriangleMesh& mesh, const ExportTitle& title) {
  // A binary file must not begin as a text file does ("solid").
  std::string bytes = one_line(fmt::format("Morgagni {}, mm, LPS, {}", kVersion, title.title));
  bytes.resize(kStlHeadBytes, ' ');
  put(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  bytes.reserve(bytes.size() + mesh.triangles.size() * 50);
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto& corner = mesh.vertices[a];
    const Eigen::Vector3f normal =
        (mesh.vertices[b] - corner).cross(mesh.vertices[c] - corner).stableNormalized();
    put(bytes, normal);
    for (const auto vertex : {a, b, c}) put(bytes, mesh.vertices[vertex]);
    put(bytes, std::uint16_t{0});
  }
  return bytes;
}

}  // namespace mor
