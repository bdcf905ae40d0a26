// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/document_case.h"

#include <algorithm>
#include <cmath>
#include <ctime>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/files.h"
#include "morgagni/core/folder_lock.h"
#include "morgagni/core/log.h"
#include "morgagni/documentation/findings_io.h"
#include "morgagni/documentation/skin_texture_io.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::uintmax_t kMaxJsonBytes = 16U << 20U;
constexpr std::size_t kMaxPictures = 40;
constexpr std::size_t kMaxHashedFiles = 500;

/// The text or numbers at a place of the JSON, as people read them; empty: not there.
std::string words(const Json& json,
                  const std::string& pointer,
                  const std::string& between = " x ") {
  const auto place = Json::json_pointer(pointer);
  if (!json.contains(place)) return {};
  const Json& value = json[place];
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return fmt::format("{:.6g}", value.get<double>());
  if (value.is_array()) {
    std::string list;
    for (std::size_t i = 0; i < value.size(); ++i)
      list += (i == 0 ? "" : between) + words(value, fmt::format("/{}", i));
    return list;
  }
  return value.is_null() ? std::string() : value.dump();
}

void add_fact(std::vector<DocumentFact>& facts, const std::string& name, const std::string& value) {
  if (!value.empty()) facts.push_back({name, value});
}

std::string preparation_words(const Json& json) {
  std::string text;
  const auto add = [&](const char* name, const std::string& value, const char* unit) {
    if (value.empty()) return;
    text += fmt::format("{}{} {}{}", text.empty() ? "" : ", ", name, value, unit);
  };
  add("skin at or above", words(json, "/options/skin/threshold_hu"), " HU");
  add("closing", words(json, "/options/skin/closing_mm"), " mm");
  add("vertices", words(json, "/options/skin/num_vertices"), "");
  add("bone at or above", words(json, "/options/bone/threshold_hu"), " HU");
  return text;
}

std::vector<DocumentFact> facts_of(const Case& body, const Json& json) {
  std::vector<DocumentFact> facts;
  add_fact(facts, "CT from", words(json, "/ct/source"));
  add_fact(facts, "CT voxels", words(json, "/ct/size"));
  const std::string spacing = words(json, "/ct/spacing_mm");
  add_fact(facts, "CT voxel size", spacing.empty() ? spacing : spacing + " mm");
  add_fact(facts, "SHA-256 of the voxels", body.ct_voxels_sha256);
  std::string prepared = words(json, "/made_at");
  if (const auto program = words(json, "/made_by"); !program.empty())
    prepared += " (UTC), " + program;
  add_fact(facts, "Case prepared", prepared);
  add_fact(facts, "Preparation", preparation_words(json));
  std::string names;
  for (const auto& structure : body.structures)
    names += (names.empty() ? "" : ", ") + structure.name;
  add_fact(facts, "Structures", names);
  return facts;
}

/// What was written beside a kept picture; an empty object where there is nothing.
Json sidecar_of(fs::path picture) {
  const auto text = read_text_file(picture.replace_extension(".json"), kMaxJsonBytes);
  Json json = text ? Json::parse(*text, nullptr, /*allow_exceptions=*/false) : Json::object();
  return json.is_object() ? json : Json::object();
}

std::string camera_words(const Json& calibration, const std::string& which) {
  const std::string size = words(calibration, "/" + which + "/width_px");
  if (size.empty()) return {};
  return fmt::format("{} {} x {} px, focal lengths {} px, centre {} px, distortion {}",
                     which == "color" ? "colour" : which,
                     size,
                     words(calibration, "/" + which + "/height_px"),
                     words(calibration, "/" + which + "/focal_px", ", "),
                     words(calibration, "/" + which + "/center_px", ", "),
                     words(calibration, "/" + which + "/distortion", ", "));
}

/// The calibration that the newest kept picture was taken with.
std::string calibration_words(const std::vector<DocumentPicture>& pictures) {
  for (auto picture = pictures.rbegin(); picture != pictures.rend(); ++picture) {
    const Json json = sidecar_of(picture->file);
    if (!json.contains("calibration") || !json["calibration"].is_object()) continue;
    const std::string color = camera_words(json["calibration"], "color");
    const std::string depth = camera_words(json["calibration"], "depth");
    if (!color.empty() || !depth.empty()) return color + (color.empty() ? "" : "; ") + depth;
  }
  return {};
}

/// When a picture was taken, and how sure its pose was.
std::string caption_of(const fs::path& picture) {
  const Json json = sidecar_of(picture);
  std::string caption = words(json, "/taken_at");
  if (caption.empty()) return picture.filename().string();
  if (const auto state = words(json, "/state"); !state.empty()) caption += ", " + state;
  const bool has_bound = json.contains("bound_mm") && json["bound_mm"].is_number();
  caption += has_bound
                 ? fmt::format(", error bound {:.1f} mm (95 %)", json["bound_mm"].get<double>())
                 : std::string(", error bound not known");
  return fmt::format("{} ({})", caption, picture.filename().string());
}

std::vector<DocumentPicture> pictures_in(const fs::path& folder) {
  std::vector<DocumentPicture> pictures;
  std::error_code status;
  for (const auto& entry : fs::directory_iterator(folder, status)) {
    if (entry.path().extension() == ".png" && entry.is_regular_file(status))
      pictures.push_back({entry.path(), caption_of(entry.path())});
  }
  std::sort(pictures.begin(), pictures.end(), [](const auto& a, const auto& b) {
    return a.file < b.file;
  });
  // By name they are in the order of time.
  if (pictures.size() > kMaxPictures) {
    log::warn("{}: {} pictures, the documents show the newest {}",
              folder.string(),
              pictures.size(),
              kMaxPictures);
    pictures.erase(pictures.begin(), pictures.end() - static_cast<std::ptrdiff_t>(kMaxPictures));
  }
  return pictures;
}

/// The case's own files, and what the documents show of what people made in it.
Result<std::vector<HashedFile>> hashes_of(const fs::path& folder) {
  std::vector<fs::path> names;
  std::error_code status;
  const auto collect = [&](const fs::path& below) {
    for (const auto& entry : fs::directory_iterator(folder / below, status)) {
      if (entry.is_regular_file(status) && !entry.path().filename().string().starts_with('.'))
        names.push_back(below / entry.path().filename());
    }
  };
  for (const char* below : {"", "findings", "texture", "pictures"}) collect(below);
  std::sort(names.begin(), names.end());
  if (names.size() > kMaxHashedFiles) {
    log::warn("{}: {} files, the documents list the hashes of {}",
              folder.string(),
              names.size(),
              kMaxHashedFiles);
    names.resize(kMaxHashedFiles);
  }
  std::vector<HashedFile> files;
  for (const auto& name : names) {
    MOR_TRY(const auto sha256, sha256_hex_of_file(folder / name));
    files.push_back({name.generic_string(), fs::file_size(folder / name, status), sha256});
  }
  return files;
}

Rgb8 to_rgb8(const Eigen::Vector3f& color) {
  const auto byte = [](float share) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(share, 0.0F, 1.0F) * 255.0F));
  };
  return {byte(color.x()), byte(color.y()), byte(color.z())};
}

Result<std::optional<SkinTexture>> texture_of(const fs::path& folder) {
  auto texture = read_skin_texture(folder);
  if (texture) return std::optional<SkinTexture>(*std::move(texture));
  if (texture.error().code == ErrorCode::kNotFound) return std::optional<SkinTexture>();
  return tl::unexpected<Error>(texture.error());
}

}  // namespace

Result<DocumentSource> document_source(const Case& body) {
  DocumentSource source;
  source.case_name = body.name;
  source.ct_description = body.ct_description;
  MOR_TRY(const auto text, read_text_file(body.folder / kCaseFile, kMaxJsonBytes));
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  source.facts = facts_of(body, json.is_object() ? json : Json::object());
  source.pictures = pictures_in(body.folder / "pictures");
  const std::string calibration = calibration_words(source.pictures);
  add_fact(source.facts,
           "Camera calibration",
           calibration.empty() ? "not kept with this case" : calibration);
  MOR_TRY(source.case_files, hashes_of(body.folder));
  source.skin = body.skin->mesh;
  MOR_TRY(source.texture, texture_of(body.folder / "texture"));
  for (const auto& structure : body.structures)
    source.structures.push_back({structure.name, to_rgb8(structure.color), structure.mesh, {}});
  source.volume = body.volume;
  source.findings_folder = body.folder / "findings";
  MOR_TRY(source.findings, read_findings(source.findings_folder));
  return source;
}

fs::path new_documents_folder(const fs::path& case_folder) {
  const std::string time = fmt::format("{:%Y-%m-%dT%H-%M-%SZ}", fmt::gmtime(std::time(nullptr)));
  fs::path folder = case_folder / "documents" / time;
  std::error_code status;
  for (int i = 2; fs::exists(folder, status); ++i)
    folder = case_folder / "documents" / fmt::format("{}-{}", time, i);
  return folder;
}

Result<DocumentSummary> document_case(const Case& body,
                                      const fs::path& output,
                                      const DocumentOptions& options,
                                      const Progress& progress,
                                      std::stop_token stop) {
  MOR_CHECK(options.check());
  MOR_TRY(const auto in_use,
          FolderLock::take(body.folder,
                           FolderLock::Kind::kShared,
                           body.folder.string() + " is being prepared: try again after that"));
  progress("read the case", 0.0);
  MOR_TRY(const auto source, document_source(body));
  progress("read the case", 1.0);
  return make_documents(source,
                        output.empty() ? new_documents_folder(body.folder) : output,
                        options,
                        progress,
                        std::move(stop));
}

}  // namespace mor
