// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <nlohmann/json.hpp>

#include "morgagni/core/image_png.h"
#include "morgagni/core/version.h"
#include "morgagni/documentation/export_formats.h"
#include "morgagni/documentation/internal/binary_writer.h"

namespace mor {
namespace {

using Json = nlohmann::ordered_json;
using internal::put;

// Numbers of the glTF 2.0 specification.
constexpr int kFloat = 5126;
constexpr int kUnsignedInt = 5125;
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;
constexpr int kLinear = 9729;
constexpr int kLinearMipmapLinear = 9987;
constexpr int kClampToEdge = 33071;
constexpr std::uint32_t kGlbMagic = 0x46546C67;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
constexpr std::uint32_t kBinaryChunk = 0x004E4942;

/// glTF's colour factors are linear light (IEC 61966-2-1).
double linear(std::uint8_t srgb) {
  const double share = srgb / 255.0;
  return share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
}

class GlbWriter {
 public:
  explicit GlbWriter(const ExportTitle& title) {
    root_ = {{"asset",
              {{"version", "2.0"},
               {"generator", std::string("Morgagni ") + kVersion},
               {"extras",
                {{"title", title.title},
                 {"created_at", title.created_at},
                 {"axes",
                  "x to the body's left, y to the head, z to the front; metres; origin as "
                  "in the CT"}}}}},
             {"scene", 0},
             {"scenes", {{{"name", title.title}, {"nodes", Json::array()}}}}};
  }

  void add_picture(const Image<Rgb8>& picture) {
    const auto png = encode_png(picture.view());
    const auto* text = reinterpret_cast<const char*>(png.data());
    const int view = add_view(std::string(text, png.size()), {});
    root_["images"] = {{{"name", "skin"}, {"mimeType", "image/png"}, {"bufferView", view}}};
    root_["samplers"] = {{{"magFilter", kLinear},
                          {"minFilter", kLinearMipmapLinear},
                          {"wrapS", kClampToEdge},
                          {"wrapT", kClampToEdge}}};
    root_["textures"] = {{{"sampler", 0}, {"source", 0}}};
    root_["extensionsUsed"] = {"KHR_materials_unlit"};
  }

  void add_surface(const ExportSurface& surface, const Image<Rgb8>& picture) {
    if (surface.mesh.empty()) return;  // glTF knows no empty mesh.
    Json attributes = {{"POSITION", add_places(surface.mesh)},
                       {"NORMAL", add_normals(surface.mesh)}};
    const bool is_textured = !surface.picture_px.empty();
    if (is_textured) attributes["TEXCOORD_0"] = add_picture_places(surface, picture);
    const auto index = static_cast<int>(root_["meshes"].size());
    root_["meshes"].push_back({{"name", surface.name},
                               {"primitives",
                                {{{"attributes", attributes},
                                  {"indices", add_triangles(surface.mesh)},
                                  {"material", add_material(surface, is_textured)}}}}});
    root_["scenes"][0]["nodes"].push_back(root_["nodes"].size());
    root_["nodes"].push_back({{"name", surface.name}, {"mesh", index}});
  }

  std::string finish() {
    root_["buffers"] = {{{"byteLength", binary_.size()}}};
    std::string json = root_.dump(-1, ' ', false, Json::error_handler_t::replace);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::string file;
    put(file, kGlbMagic);
    put(file, std::uint32_t{2});
    put(file, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + binary_.size()));
    put(file, static_cast<std::uint32_t>(json.size()));
    put(file, kJsonChunk);
    file += json;
    put(file, static_cast<std::uint32_t>(binary_.size()));
    put(file, kBinaryChunk);
    file += binary_;
    return file;
  }

 private:
  int add_view(const std::string& bytes, std::optional<int> target) {
    Json view = {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", bytes.size()}};
    if (target) view["target"] = *target;
    binary_ += bytes;
    binary_.resize((binary_.size() + 3) / 4 * 4, '\0');
    root_["bufferViews"].push_back(view);
    return static_cast<int>(root_["bufferViews"].size()) - 1;
  }

  int add_accessor(Json accessor) {
    root_["accessors"].push_back(std::move(accessor));
    return static_cast<int>(root_["accessors"].size()) - 1;
  }

  int add_places(const TriangleMesh& mesh) {
    std::string bytes;
    Eigen::AlignedBox3f box;
    for (const auto& vertex : mesh.vertices) {
      const Eigen::Vector3f place = gltf_from_ct(vertex);
      put(bytes, place);
      box.extend(place);
    }
    const auto corner = [](const Eigen::Vector3f& v) { return Json{v.x(), v.y(), v.z()}; };
    return add_accessor({{"bufferView", add_view(bytes, kArrayBuffer)},
                         {"componentType", kFloat},
                         {"count", mesh.vertices.size()},
                         {"type", "VEC3"},
                         {"min", corner(box.min())},
                         {"max", corner(box.max())}});
  }

  int add_normals(const TriangleMesh& mesh) {
    std::string bytes;
    for (const auto& normal : mesh.normals)
      put(bytes, Eigen::Vector3f(normal.x(), normal.z(), -normal.y()).stableNormalized().eval());
    return add_accessor({{"bufferView", add_view(bytes, kArrayBuffer)},
                         {"componentType", kFloat},
                         {"count", mesh.normals.size()},
                         {"type", "VEC3"}});
  }

  int add_picture_places(const ExportSurface& surface, const Image<Rgb8>& picture) {
    std::string bytes;
    for (const auto& place : surface.picture_px) {
      const auto share = picture_share(place, picture);
      put(bytes, share.x());
      put(bytes, share.y());
    }
    return add_accessor({{"bufferView", add_view(bytes, kArrayBuffer)},
                         {"componentType", kFloat},
                         {"count", surface.picture_px.size()},
                         {"type", "VEC2"}});
  }

  int add_triangles(const TriangleMesh& mesh) {
    std::string bytes;
    for (const auto& triangle : mesh.triangles) put(bytes, triangle);
    return add_accessor({{"bufferView", add_view(bytes, kElementArrayBuffer)},
                         {"componentType", kUnsignedInt},
                         {"count", mesh.triangles.size() * 3},
                         {"type", "SCALAR"}});
  }

  int add_material(const ExportSurface& surface, bool is_textured) {
    Json look = {{"metallicFactor", 0.0}, {"roughnessFactor", 0.9}};
    Json material = {{"name", surface.name}};
    if (is_textured) {
      look["baseColorTexture"] = {{"index", 0}};
      material["extensions"] = {{"KHR_materials_unlit", Json::object()}};
    } else {
      look["baseColorFactor"] = {
          linear(surface.color.r), linear(surface.color.g), linear(surface.color.b), 1.0};
    }
    material["pbrMetallicRoughness"] = look;
    root_["materials"].push_back(material);
    return static_cast<int>(root_["materials"].size()) - 1;
  }

  Json root_;
  std::string binary_;
};

}  // namespace

std::string encode_glb(const ExportModel& model, const ExportTitle& title) {
  GlbWriter writer(title);
  if (!model.picture.empty()) writer.add_picture(model.picture);
  writer.add_surface(model.skin, model.picture);
  for (const auto& structure : model.structures) writer.add_surface(structure, model.picture);
  return writer.finish();
}

}  // namespace mor
