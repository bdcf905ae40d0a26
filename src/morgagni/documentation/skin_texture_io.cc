// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/skin_texture_io.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/files.h"
#include "morgagni/core/image_png.h"
#include "morgagni/core/pending_folder.h"
#include "morgagni/geometry/triangle_mesh_io.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

static_assert(std::endian::native == std::endian::little, "corners.bin is little-endian");

constexpr int kFormat = 1;
constexpr const char* kIndexFile = "texture.json";
constexpr const char* kColorFile = "color.png";
constexpr const char* kSkinFile = "skin.ply";
constexpr const char* kCornersFile = "corners.bin";
constexpr std::uintmax_t kMaxIndexBytes = 64U << 20U;
constexpr std::uintmax_t kMaxSkinBytes = 256U << 20U;
constexpr std::uintmax_t kMaxCornersBytes = 256U << 20U;

/// One number of the provenance as a 16-bit picture.
struct Plane {
  const char* file;
  float TexelSource::*member;
  float per_unit;
};
constexpr const char* kFrameFile = "source_frame.png";
constexpr std::array<Plane, 3> kPlanes = {{
    {"source_angle.png", &TexelSource::angle_rad, 10000.0F},
    {"source_distance.png", &TexelSource::distance_mm, 10.0F},
    {"source_resolution.png", &TexelSource::px_per_mm, 1000.0F},
}};

tl::unexpected<Error> damaged(const fs::path& folder, const std::string& what) {
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("the texture in {} is damaged: {}", folder.string(), what));
}

bool is_side(int side_px) {
  return side_px >= 1 && side_px <= kMaxAtlasSidePx;
}

Result<void> check_sizes(const SkinTexture& texture) {
  if (!texture.atlas) return make_error(ErrorCode::kInvalidArgument, "a texture needs an atlas");
  const auto& atlas = *texture.atlas;
  if (!is_side(atlas.width_px) || !is_side(atlas.height_px)) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("an atlas must be 1 to {} px wide and high, got {}x{}",
                                  kMaxAtlasSidePx,
                                  atlas.width_px,
                                  atlas.height_px));
  }
  MOR_CHECK(atlas.check());
  const auto has_size = [&](const auto& image) {
    return image.width() == atlas.width_px && image.height() == atlas.height_px;
  };
  if (!has_size(texture.color) || !has_size(texture.sources)) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("the texture's pictures must have the atlas's size, {}x{} px, got {}x{} px",
                    atlas.width_px,
                    atlas.height_px,
                    texture.color.width(),
                    texture.color.height()));
  }
  if (texture.frames.size() > kMaxTextureFrames) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format(
            "a texture keeps at most {} frames, got {}", kMaxTextureFrames, texture.frames.size()));
  }
  return {};
}

Result<Image<std::uint16_t>> frame_plane(const SkinTexture& texture) {
  const auto& sources = texture.sources;
  Image<std::uint16_t> plane(sources.width(), sources.height(), 0);
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const auto frame = sources.data()[i].frame;
    if (frame == TexelSource::kNeverSeen) continue;
    if (frame >= texture.frames.size()) {
      return make_error(ErrorCode::kInvalidArgument,
                        fmt::format("a texel names frame {} of {}", frame, texture.frames.size()));
    }
    plane.data()[i] = static_cast<std::uint16_t>(frame + 1);
  }
  return plane;
}

Image<std::uint16_t> number_plane(const Image<TexelSource>& sources, const Plane& plane) {
  Image<std::uint16_t> result(sources.width(), sources.height(), 0);
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const float scaled = sources.data()[i].*plane.member * plane.per_unit;
    if (scaled > 0.0F) {
      result.data()[i] = static_cast<std::uint16_t>(std::min(std::round(scaled), 65535.0F));
    }
  }
  return result;
}

Json to_json(const TextureFrame& frame) {
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) rows.push_back(frame.ct_from_color(row, column));
  }
  return {{"frame_id", frame.frame_id},
          {"captured_unix_ms", frame.captured_unix_ms},
          {"ct_from_color", rows},
          {"bound_mm", frame.bound_mm ? Json(*frame.bound_mm) : Json(nullptr)}};
}

/// Writes the files and notes their hashes.
class FolderWriter {
 public:
  explicit FolderWriter(fs::path folder) : folder_(std::move(folder)) {}

  Result<void> write(const char* name, std::span<const std::byte> bytes) {
    MOR_CHECK(write_file(folder_ / name, bytes));
    hashes_[name] = sha256_hex(bytes);
    return {};
  }
  Result<void> write_skin(const TriangleMesh& mesh) {
    MOR_CHECK(write_ply(folder_ / kSkinFile, mesh));
    MOR_TRY(hashes_[kSkinFile], sha256_hex_of_file(folder_ / kSkinFile));
    return {};
  }
  [[nodiscard]] const Json& hashes() const { return hashes_; }

 private:
  fs::path folder_;
  Json hashes_ = Json::object();
};

Result<Json> read_index(const fs::path& folder) {
  if (!fs::exists(folder / kIndexFile)) {
    return make_error(ErrorCode::kNotFound,
                      fmt::format("{}: there is no {}", folder.string(), kIndexFile));
  }
  MOR_TRY(const auto text, read_text_file(folder / kIndexFile, kMaxIndexBytes));
  // Nested deeper than anything written here, the parser's stack is not to be trusted with it.
  constexpr int kMaxDepth = 8;
  const auto is_shallow = [](int depth, Json::parse_event_t /*event*/, Json& /*value*/) {
    return depth < kMaxDepth;
  };
  Json json = Json::parse(text, is_shallow, /*allow_exceptions=*/false);
  if (!json.is_object()) return damaged(folder, "texture.json is not JSON");
  const auto format = json.find("format");
  if (format == json.end() || !format->is_number_integer()) {
    return damaged(folder, "texture.json names no format");
  }
  if (format->get<std::int64_t>() != kFormat) {
    return make_error(ErrorCode::kUnsupported,
                      fmt::format("{}: a texture of format {}, this version reads format {}",
                                  folder.string(),
                                  format->dump(),
                                  kFormat));
  }
  return json;
}

Result<void> check_hash(const fs::path& folder, const Json& index, const char* name) {
  const auto files = index.find("files");
  const bool is_listed = files != index.end() && files->is_object() && files->contains(name) &&
                         (*files)[name].is_string();
  if (!is_listed) return damaged(folder, fmt::format("texture.json has no hash of {}", name));
  MOR_TRY(const auto hash, sha256_hex_of_file(folder / name));
  if (hash != (*files)[name].get<std::string>()) {
    return damaged(folder, fmt::format("{} is not the file that was written", name));
  }
  return {};
}

/// A PNG's size before any of it is decoded: a small file can claim a picture of gigabytes.
Result<void> check_png_size(const fs::path& folder, const char* name, int width, int height) {
  constexpr std::size_t kHeadBytes = 24;
  MOR_TRY(const auto bytes, read_file(folder / name, std::uintmax_t{1} << 30U));
  if (bytes.size() < kHeadBytes) return damaged(folder, fmt::format("{} is no picture", name));
  const auto number_at = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      value = value << 8U | std::to_integer<std::uint32_t>(bytes[at + i]);
    }
    return value;
  };
  if (number_at(16) != static_cast<std::uint32_t>(width) ||
      number_at(20) != static_cast<std::uint32_t>(height)) {
    return damaged(folder,
                   fmt::format("{} is {}x{} px, the atlas {}x{} px",
                               name,
                               number_at(16),
                               number_at(20),
                               width,
                               height));
  }
  return {};
}

Result<int> read_side(const fs::path& folder, const Json& index, const char* key) {
  const auto found = index.find(key);
  if (found == index.end() || !found->is_number_integer() || found->get<std::int64_t>() < 1 ||
      found->get<std::int64_t>() > kMaxAtlasSidePx) {
    return damaged(folder, fmt::format("{} must be 1 to {} px", key, kMaxAtlasSidePx));
  }
  return found->get<int>();
}

Result<SkinAtlas> read_atlas(const fs::path& folder, const Json& index) {
  SkinAtlas atlas;
  MOR_TRY(atlas.width_px, read_side(folder, index, "width_px"));
  MOR_TRY(atlas.height_px, read_side(folder, index, "height_px"));
  const auto scale = index.find("px_per_mm");
  if (scale == index.end() || !scale->is_number() || !(scale->get<double>() > 0.0)) {
    return damaged(folder, "px_per_mm must be a positive number");
  }
  atlas.px_per_mm = scale->get<double>();
  MOR_CHECK(check_hash(folder, index, kSkinFile));
  MOR_CHECK(check_hash(folder, index, kCornersFile));
  if (fs::file_size(folder / kSkinFile) > kMaxSkinBytes) {
    return damaged(folder, fmt::format("{} is larger than {} bytes", kSkinFile, kMaxSkinBytes));
  }
  MOR_TRY(atlas.mesh, read_ply(folder / kSkinFile));
  MOR_TRY(const auto bytes, read_file(folder / kCornersFile, kMaxCornersBytes));
  using Corners = std::array<Eigen::Vector2f, 3>;
  static_assert(sizeof(Corners) == 6 * sizeof(float));
  if (bytes.size() != atlas.mesh.triangles.size() * sizeof(Corners)) {
    return damaged(folder,
                   fmt::format("{} has {} bytes, {} triangles need {}",
                               kCornersFile,
                               bytes.size(),
                               atlas.mesh.triangles.size(),
                               atlas.mesh.triangles.size() * sizeof(Corners)));
  }
  atlas.corners_px.resize(atlas.mesh.triangles.size());
  std::memcpy(static_cast<void*>(atlas.corners_px.data()), bytes.data(), bytes.size());
  if (const auto checked = atlas.check(); !checked) {
    return damaged(folder, checked.error().message);
  }
  return atlas;
}

Result<TextureFrame> read_frame(const fs::path& folder, const Json& json) {
  const bool is_frame =
      json.is_object() && json.contains("frame_id") && json["frame_id"].is_number_unsigned() &&
      json.contains("captured_unix_ms") && json["captured_unix_ms"].is_number_integer() &&
      json.contains("ct_from_color") && json["ct_from_color"].is_array() &&
      json["ct_from_color"].size() == 12;
  if (!is_frame) return damaged(folder, "texture.json has a frame without id, time or pose");
  TextureFrame frame;
  frame.frame_id = json["frame_id"].get<std::uint64_t>();
  frame.captured_unix_ms = json["captured_unix_ms"].get<std::int64_t>();
  for (int i = 0; i < 12; ++i) {
    const auto& value = json["ct_from_color"][static_cast<std::size_t>(i)];
    if (!value.is_number()) return damaged(folder, "texture.json has a pose that is no numbers");
    frame.ct_from_color.matrix()(i / 4, i % 4) = value.get<double>();
  }
  const Eigen::Matrix3d rotation = frame.ct_from_color.linear();
  if (!(rotation * rotation.transpose()).isIdentity(1e-6)) {
    return damaged(folder, fmt::format("the pose of frame {} is not rigid", frame.frame_id));
  }
  if (const auto bound = json.find("bound_mm"); bound != json.end() && bound->is_number()) {
    frame.bound_mm = bound->get<double>();
  }
  return frame;
}

Result<std::vector<TextureFrame>> read_frames(const fs::path& folder, const Json& index) {
  const auto list = index.find("frames");
  if (list == index.end() || !list->is_array() || list->size() > kMaxTextureFrames) {
    return damaged(folder,
                   fmt::format("texture.json must list at most {} frames", kMaxTextureFrames));
  }
  std::vector<TextureFrame> frames;
  frames.reserve(list->size());
  for (const auto& item : *list) {
    MOR_TRY(frames.emplace_back(), read_frame(folder, item));
  }
  return frames;
}

Result<Image<TexelSource>> read_sources(const fs::path& folder,
                                        const Json& index,
                                        const SkinAtlas& atlas,
                                        std::size_t num_frames) {
  const auto read_plane = [&](const char* name) -> Result<Image<std::uint16_t>> {
    MOR_CHECK(check_hash(folder, index, name));
    MOR_CHECK(check_png_size(folder, name, atlas.width_px, atlas.height_px));
    return read_png_gray16(folder / name);
  };
  Image<TexelSource> sources(atlas.width_px, atlas.height_px);
  MOR_TRY(const auto frames, read_plane(kFrameFile));
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const std::uint16_t one_more = frames.data()[i];
    if (one_more > num_frames) {
      return damaged(folder, fmt::format("a texel names frame {} of {}", one_more - 1, num_frames));
    }
    if (one_more > 0) sources.data()[i].frame = one_more - 1U;
  }
  for (const auto& plane : kPlanes) {
    MOR_TRY(const auto values, read_plane(plane.file));
    for (std::size_t i = 0; i < sources.size(); ++i) {
      sources.data()[i].*plane.member = static_cast<float>(values.data()[i]) / plane.per_unit;
    }
  }
  return sources;
}

}  // namespace

Result<void> write_skin_texture(const fs::path& folder, const SkinTexture& texture) {
  MOR_CHECK(check_sizes(texture));
  MOR_TRY(const auto frames, frame_plane(texture));
  MOR_TRY(auto pending, PendingFolder::create(folder));
  const auto& atlas = *texture.atlas;
  FolderWriter writer(pending.path());
  MOR_CHECK(writer.write_skin(atlas.mesh));
  MOR_CHECK(writer.write(kCornersFile, std::as_bytes(std::span(atlas.corners_px))));
  MOR_CHECK(writer.write(kColorFile, encode_png(texture.color.view())));
  MOR_CHECK(writer.write(kFrameFile, encode_png(frames.view())));
  for (const auto& plane : kPlanes) {
    const auto values = number_plane(texture.sources, plane);
    MOR_CHECK(writer.write(plane.file, encode_png(values.view())));
  }
  Json index = {{"format", kFormat},
                {"width_px", atlas.width_px},
                {"height_px", atlas.height_px},
                {"px_per_mm", atlas.px_per_mm},
                {"frames", Json::array()},
                {"files", writer.hashes()}};
  for (const auto& frame : texture.frames) index["frames"].push_back(to_json(frame));
  MOR_CHECK(write_file(pending.path() / kIndexFile, index.dump(1) + "\n"));
  return pending.commit();
}

Result<SkinTexture> read_skin_texture(const fs::path& folder) {
  MOR_TRY(const Json index, read_index(folder));
  SkinTexture texture;
  MOR_TRY(auto atlas, read_atlas(folder, index));
  MOR_CHECK(check_hash(folder, index, kColorFile));
  MOR_CHECK(check_png_size(folder, kColorFile, atlas.width_px, atlas.height_px));
  MOR_TRY(texture.color, read_png_rgb(folder / kColorFile));
  MOR_TRY(texture.frames, read_frames(folder, index));
  MOR_TRY(texture.sources, read_sources(folder, index, atlas, texture.frames.size()));
  texture.atlas = std::make_shared<const SkinAtlas>(std::move(atlas));
  return texture;
}

}  // namespace mor
