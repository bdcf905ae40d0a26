// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mesh_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>

#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "morgagni/geometry/triangle_mesh_io.h"

#include "messages.h"
#include "sandbox.h"
#include "vtp_file.h"

namespace mor::import {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 4> kEndings = {".stl", ".obj", ".ply", ".vtp"};

std::string ending_of(const fs::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char letter) {
    return static_cast<char>(std::tolower(letter));
  });
  return ending;
}

/// "RAS" or "LPS" where the file's head says so; empty where it does not.
std::string frame_named_in(const fs::path& path) {
  constexpr std::size_t kHeadBytes = 1024;
  std::string head(kHeadBytes, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), kHeadBytes);
  for (const char* frame : {"RAS", "LPS"})
    if (head.find(std::string("SPACE=") + frame) != std::string::npos) return frame;
  return {};
}

Result<void> check_ending(const fs::path& path) {
  const std::string ending = ending_of(path);
  if (std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end()) return {};
  return make_error(ErrorCode::kUnsupported,
                    path.filename().string() +
                        " is no surface that is read here: give an .stl, .obj, .ply or .vtp file");
}

/// Memory for what a text file swells to, and time for reading it: not more.
void allow_as_much_as_goes_with(const fs::path& path) {
  constexpr std::uintmax_t kSwelling = 12;
  std::error_code failure;
  const auto file_bytes = fs::file_size(path, failure);
  const auto num_bytes =
      failure ? 0
              : std::min<std::uintmax_t>(file_bytes, static_cast<std::uintmax_t>(kMaxVolumeBytes));
  allow_memory(kSwelling * num_bytes);
  limit_time_for(num_bytes);
}

/// What makes an STL or OBJ file one plain triangle mesh.
const aiScene* read_scene(Assimp::Importer& importer, const fs::path& path) {
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS,
                              aiComponent_NORMALS | aiComponent_TEXCOORDS | aiComponent_COLORS |
                                  aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_MATERIALS |
                                  aiComponent_TEXTURES);
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  return importer.ReadFile(path.string(),
                           aiProcess_RemoveComponent | aiProcess_Triangulate |
                               aiProcess_SortByPType | aiProcess_JoinIdenticalVertices |
                               aiProcess_PreTransformVertices | aiProcess_FindDegenerates);
}

/// Everything in the file as one mesh.
TriangleMesh joined(const aiScene& scene) {
  TriangleMesh all;
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
    const aiMesh& mesh = *scene.mMeshes[i];
    const auto first = static_cast<std::uint32_t>(all.vertices.size());
    for (unsigned v = 0; v < mesh.mNumVertices; ++v)
      all.vertices.emplace_back(mesh.mVertices[v].x, mesh.mVertices[v].y, mesh.mVertices[v].z);
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;
      all.triangles.push_back(
          {first + face.mIndices[0], first + face.mIndices[1], first + face.mIndices[2]});
    }
  }
  return all;
}

Result<TriangleMesh> read_with_assimp(const fs::path& path) {
  Assimp::Importer importer;
  const aiScene* scene = read_scene(importer, path);
  if (scene != nullptr && (scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE) == 0) return joined(*scene);
  return make_error(
      ErrorCode::kIo,
      path.filename().string() + " is damaged or not what its name says: it gives no surface");
}

Result<TriangleMesh> read_mesh(const fs::path& path) {
  const std::string ending = ending_of(path);
  if (ending == ".vtp") return read_vtp(path);
  // assimp's PLY reader never ends on a header that is cut short.
  return ending == ".ply" ? read_ply(path) : read_with_assimp(path);
}

Result<void> hand_over(const TriangleMesh& mesh, const std::string& name) {
  if (mesh.empty()) return make_error(ErrorCode::kInvalidArgument, name + " has no triangles");
  if (mesh.triangles.size() > kMaxMeshTriangles || mesh.vertices.size() > 3 * kMaxMeshTriangles) {
    return make_error(ErrorCode::kInvalidArgument,
                      name + " has " + std::to_string(mesh.triangles.size()) +
                          " triangles, the limit is " + std::to_string(kMaxMeshTriangles));
  }
  const auto lost = std::find_if(mesh.vertices.begin(),
                                 mesh.vertices.end(),
                                 [](const auto& vertex) { return !vertex.allFinite(); });
  if (lost != mesh.vertices.end()) {
    return make_error(ErrorCode::kInvalidArgument,
                      name + " has a vertex whose place is not a finite number (vertex " +
                          std::to_string(lost - mesh.vertices.begin()) + ")");
  }
  MOR_TRY(const auto place,
          open_mesh({kImportMeshMagic, mesh.vertices.size(), mesh.triangles.size()}));
  std::memcpy(place.positions.data(), mesh.vertices.data(), place.positions.size_bytes());
  std::memcpy(place.indices.data(), mesh.triangles.data(), place.indices.size_bytes());
  return {};
}

}  // namespace

Result<void> import_mesh_file(const fs::path& path) {
  MOR_CHECK(check_ending(path));
  const std::string name = path.filename().string();
  say_file(path.string());
  allow_as_much_as_goes_with(path);
  MOR_TRY(const TriangleMesh mesh, read_mesh(path));
  say_progress(0.8);
  if (const auto frame = frame_named_in(path); !frame.empty()) say_frame(frame);
  return hand_over(mesh, name);
}

}  // namespace mor::import
