// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/casefile/case.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/casefile/internal/case_format.h"
#include "morgagni/core/files.h"
#include "morgagni/geometry/triangle_mesh_io.h"
#include "morgagni/geometry/volume_io.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::uintmax_t kMaxCaseJsonBytes = 16U << 20U;
constexpr std::size_t kMaxStructures = 200;

tl::unexpected<Error> damaged(const fs::path& folder, const std::string& what) {
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("{}: the case is damaged ({}): prepare it again with `morgagni "
                                "prepare CT --case {}`",
                                folder.string(),
                                what,
                                folder.string()));
}

Result<Json> read_case_json(const fs::path& folder) {
  const fs::path path = folder / kCaseFile;
  if (!fs::exists(path)) {
    return make_error(ErrorCode::kNotFound,
                      fmt::format("{} is no prepared case (it has no {}): make one with `morgagni "
                                  "prepare CT --case {}`",
                                  folder.string(),
                                  kCaseFile,
                                  folder.string()));
  }
  MOR_TRY(const auto text, read_text_file(path, kMaxCaseJsonBytes));
  Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return damaged(folder, "case.json is not JSON");
  const int format =
      json.value("format", Json()).is_number_integer() ? json["format"].get<int>() : 0;
  if (format < 1) return damaged(folder, "case.json names no format");
  if (format > internal::kCaseFormat) {
    return make_error(ErrorCode::kUnsupported,
                      fmt::format("{}: the case has format {}, this program reads up to {}: use a "
                                  "newer Morgagni",
                                  folder.string(),
                                  format,
                                  internal::kCaseFormat));
  }
  return json;
}

/// A file of the case is its plain name and matches the hash that case.json keeps.
Result<void> check_file(const fs::path& folder, const Json& files, const std::string& name) {
  if (name.find('/') != std::string::npos || name.starts_with('.')) {
    return damaged(folder, fmt::format("\"{}\" is no file name", name));
  }
  const auto expected = files.find(name);
  if (expected == files.end() || !expected->is_string()) {
    return damaged(folder, fmt::format("case.json has no hash of {}", name));
  }
  const auto found = sha256_hex_of_file(folder / name);
  if (!found) return damaged(folder, found.error().message);
  if (*found != expected->get<std::string>()) {
    return damaged(folder, fmt::format("{} does not match its hash", name));
  }
  return {};
}

Result<Eigen::Vector3d> read_vector(const fs::path& folder, const Json& json, const char* key) {
  const auto found = json.find(key);
  const bool is_vector =
      found != json.end() && found->is_array() && found->size() == 3 &&
      std::all_of(found->begin(), found->end(), [](const Json& x) { return x.is_number(); });
  if (!is_vector) return damaged(folder, fmt::format("{} is not three numbers", key));
  return Eigen::Vector3d(
      (*found)[0].get<double>(), (*found)[1].get<double>(), (*found)[2].get<double>());
}

std::string text_of(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

Result<std::vector<Structure>> read_structures(const fs::path& folder, const Json& json) {
  std::vector<Structure> structures;
  const Json& list = json.value("structures", Json::array());
  if (!list.is_array() || list.size() > kMaxStructures) return damaged(folder, "structures");
  for (const auto& item : list) {
    if (!item.is_object()) return damaged(folder, "structures");
    const std::string file = text_of(item, "file");
    MOR_CHECK(check_file(folder, json["files"], file));
    MOR_TRY(auto mesh, read_ply(folder / file));
    MOR_TRY(const Eigen::Vector3d color, read_vector(folder, item, "color"));
    structures.push_back({text_of(item, "name"), color.cast<float>(), std::move(mesh)});
  }
  return structures;
}

}  // namespace

Result<Case> load_case(const fs::path& folder) {
  std::error_code status;
  if (!fs::is_directory(folder, status)) {
    return make_error(
        ErrorCode::kNotFound,
        fmt::format("{}: no such case folder: make one with `morgagni prepare CT --case {}`",
                    folder.string(),
                    folder.string()));
  }
  MOR_TRY(const Json json, read_case_json(folder));
  if (!json.contains("files") || !json["files"].is_object() || !json.contains("ct") ||
      !json["ct"].is_object()) {
    return damaged(folder, "case.json lacks its files or its CT");
  }
  Case result;
  result.name = text_of(json, "name");
  result.folder = fs::absolute(folder);
  result.ct_description = text_of(json["ct"], "description");
  result.ct_voxels_sha256 = text_of(json["ct"], "voxels_sha256");
  MOR_TRY(result.ct_center_mm, read_vector(folder, json["ct"], "center_mm"));
  MOR_TRY(result.ct_half_voxel_mm, read_vector(folder, json["ct"], "half_voxel_mm"));
  MOR_CHECK(check_file(folder, json["files"], internal::kSkinFile));
  MOR_CHECK(check_file(folder, json["files"], internal::kFieldFile));
  MOR_TRY(auto mesh, read_ply(folder / internal::kSkinFile));
  MOR_TRY(auto field, read_distance_field(folder / internal::kFieldFile));
  result.skin =
      std::make_shared<const FixedSurface>(FixedSurface{std::move(mesh), std::move(field)});
  MOR_TRY(result.structures, read_structures(folder, json));
  if (json["files"].contains(internal::kVolumeFile)) {
    MOR_CHECK(check_file(folder, json["files"], internal::kVolumeFile));
    MOR_TRY(auto volume, read_volume(folder / internal::kVolumeFile));
    result.volume = std::make_shared<const Volume>(std::move(volume));
  }
  return result;
}

}  // namespace mor
