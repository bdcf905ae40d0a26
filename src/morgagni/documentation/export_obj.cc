// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <iterator>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/version.h"
#include "morgagni/documentation/export_formats.h"

namespace mor {
namespace {

/// A name without what ends a line or a word of the format.
std::string word(const std::string& name) {
  std::string result = name;
  std::replace_if(
      result.begin(), result.end(), [](unsigned char c) { return c <= ' ' || c == '#'; }, '_');
  return result.empty() ? "unnamed" : result;
}

std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < ' '; }, ' ');
  return text;
}

/// Materials are named by number too: two structures may have one name.
std::string material_name(const ExportSurface& surface, std::size_t number) {
  return fmt::format("{}_{}", number, word(surface.name));
}

struct ObjCounts {
  std::size_t vertices = 1;  ///< OBJ counts from one,
  std::size_t places = 1;    ///< and over all objects.
};

void add_surface(std::string& text,
                 const ExportSurface& surface,
                 const Image<Rgb8>& picture,
                 std::size_t number,
                 ObjCounts& counts) {
  auto out = std::back_inserter(text);
  const auto& mesh = surface.mesh;
  fmt::format_to(out, "o {}\nusemtl {}\n", word(surface.name), material_name(surface, number));
  for (const auto& v : mesh.vertices)
    fmt::format_to(out, "v {:.4f} {:.4f} {:.4f}\n", v.x(), v.y(), v.z());
  for (const auto& n : mesh.normals)
    fmt::format_to(out, "vn {:.4f} {:.4f} {:.4f}\n", n.x(), n.y(), n.z());
  for (const auto& place : surface.picture_px) {
    const auto share = picture_share(place, picture);
    fmt::format_to(out, "vt {:.7f} {:.7f}\n", share.x(), 1.0F - share.y());  // OBJ counts upwards.
  }
  const bool is_textured = !surface.picture_px.empty();
  for (const auto& triangle : mesh.triangles) {
    text += 'f';
    for (const auto corner : triangle) {
      const auto vertex = corner + counts.vertices;
      if (is_textured) {
        fmt::format_to(out, " {}/{}/{}", vertex, corner + counts.places, vertex);
      } else {
        fmt::format_to(out, " {}//{}", vertex, vertex);
      }
    }
    text += '\n';
  }
  counts.vertices += mesh.vertices.size();
  counts.places += surface.picture_px.size();
}

void add_material(std::string& text,
                  const ExportSurface& surface,
                  std::size_t number,
                  const std::string& picture_file) {
  const bool is_textured = !surface.picture_px.empty();
  const Rgb8 color = is_textured ? Rgb8{255, 255, 255} : surface.color;
  fmt::format_to(std::back_inserter(text),
                 "newmtl {}\nKa 0 0 0\nKd {:.6f} {:.6f} {:.6f}\nKs 0 0 0\nillum 1\n",
                 material_name(surface, number),
                 color.r / 255.0,
                 color.g / 255.0,
                 color.b / 255.0);
  if (is_textured) fmt::format_to(std::back_inserter(text), "map_Kd {}\n", picture_file);
  text += '\n';
}

}  // namespace

std::string encode_obj(const ExportModel& model,
                       const ExportTitle& title,
                       const std::string& material_file) {
  std::string text = fmt::format(
      "# {}\n# Morgagni {}, {}\n# Millimetres; x to the body's left, y to the back, z to the head "
      "(LPS), origin as in the CT\nmtllib {}\n",
      one_line(title.title),
      kVersion,
      title.created_at,
      material_file);
  ObjCounts counts;
  add_surface(text, model.skin, model.picture, 0, counts);
  for (std::size_t i = 0; i < model.structures.size(); ++i)
    add_surface(text, model.structures[i], model.picture, i + 1, counts);
  return text;
}

std::string encode_mtl(const ExportModel& model, const std::string& picture_file) {
  std::string text = fmt::format("# Morgagni {}\n", kVersion);
  add_material(text, model.skin, 0, picture_file);
  for (std::size_t i = 0; i < model.structures.size(); ++i)
    add_material(text, model.structures[i], i + 1, picture_file);
  return text;
}

}  // namespace mor
