// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/viewer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <meshoptimizer.h>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/files.h"
#include "morgagni/core/version.h"
#include "morgagni/documentation/findings_io.h"
#include "morgagni/documentation/internal/finding_json.h"
#include "morgagni/documentation/internal/packed_text.h"
#include "morgagni/documentation/internal/viewer_volume.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kPlaceOfData = "<!-- morgagni: case -->";
constexpr std::uintmax_t kMaxTemplateBytes = 8U << 20U;
constexpr std::size_t kMostStructureTriangles = 400'000;
constexpr int kMostPictureSidePx = 4096;
constexpr std::uintmax_t kMaxPhotoBytes = 4U << 20U;
constexpr std::size_t kMaxPhotosBytes = 5'000'000;
constexpr std::size_t kMaxModelBytes = 15'000'000;
constexpr std::array kVolumeSides = {256, 224, 192, 160, 128, 96, 64};

Json to_json(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

/// A block of data in the page. Neither JSON nor base64 can end it early: '<' is escaped.
std::string block(const std::string& id, const std::string& type, const std::string& text) {
  return fmt::format("<script type=\"{}\" id=\"{}\">{}</script>\n", type, id, text);
}

std::string json_text(const Json& json) {
  std::string text;
  for (const char c : json.dump(-1, ' ', false, Json::error_handler_t::replace)) {
    if (c == '<') {
      text += "\\u003c";
    } else {
      text += c;
    }
  }
  return text;
}

Image<Rgb8> halved(const Image<Rgb8>& picture) {
  Image<Rgb8> half(std::max(1, picture.width() / 2), std::max(1, picture.height() / 2));
  for (int y = 0; y < half.height(); ++y) {
    for (int x = 0; x < half.width(); ++x) {
      const int x1 = std::min(2 * x + 1, picture.width() - 1);
      const int y1 = std::min(2 * y + 1, picture.height() - 1);
      const auto mean = [&](std::uint8_t Rgb8::*c) {
        return static_cast<std::uint8_t>((picture(2 * x, 2 * y).*c + picture(x1, 2 * y).*c +
                                          picture(2 * x, y1).*c + picture(x1, y1).*c + 2) /
                                         4);
      };
      half(x, y) = {mean(&Rgb8::r), mean(&Rgb8::g), mean(&Rgb8::b)};
    }
  }
  return half;
}

/// Half the size; the surface's places in the picture go with it.
void halve_picture(ExportModel& model) {
  model.picture = halved(model.picture);
  for (auto& place : model.skin.picture_px) place = (place.array() + 0.5F) * 0.5F - 0.5F;
}

ExportSurface simplified(const ExportSurface& surface, std::size_t num_triangles) {
  std::vector<std::uint32_t> indices(surface.mesh.triangles.size() * 3);
  const auto* corners = surface.mesh.triangles.front().data();
  const std::size_t count = meshopt_simplify(indices.data(),
                                             corners,
                                             indices.size(),
                                             surface.mesh.vertices.front().data(),
                                             surface.mesh.vertices.size(),
                                             sizeof(Eigen::Vector3f),
                                             num_triangles * 3,
                                             1.0F);
  ExportSurface result{surface.name, surface.color, {}, {}};
  std::vector<std::uint32_t> new_of_old(surface.mesh.vertices.size(), 0xFFFFFFFFU);
  for (std::size_t i = 0; i + 2 < count; i += 3) {
    Triangle triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      auto& vertex = new_of_old[indices[i + k]];
      if (vertex == 0xFFFFFFFFU) {
        vertex = static_cast<std::uint32_t>(result.mesh.vertices.size());
        result.mesh.vertices.push_back(surface.mesh.vertices[indices[i + k]]);
      }
      triangle[k] = vertex;
    }
    result.mesh.triangles.push_back(triangle);
  }
  result.mesh.normals = vertex_normals(result.mesh);
  return result;
}

/// Makes the structures coarser where they are too many triangles for a tablet.
void lighten(ExportModel& model, std::vector<std::string>& remarks) {
  std::size_t all = 0;
  for (const auto& structure : model.structures) all += structure.mesh.triangles.size();
  if (all <= kMostStructureTriangles) return;
  const double share = static_cast<double>(kMostStructureTriangles) / static_cast<double>(all);
  std::size_t left = 0;
  for (auto& structure : model.structures) {
    const auto wanted =
        static_cast<std::size_t>(share * static_cast<double>(structure.mesh.triangles.size()));
    if (wanted >= 4) structure = simplified(structure, wanted);
    left += structure.mesh.triangles.size();
  }
  remarks.push_back(
      fmt::format("In viewer.html the structures are coarser: {} triangles of {}.", left, all));
}

/// The model, gzipped and as text, small enough for the page.
std::string packed_model(ExportModel model,
                         const ExportTitle& title,
                         std::vector<std::string>& remarks) {
  lighten(model, remarks);
  const int full_width = model.picture.width();
  while (std::max(model.picture.width(), model.picture.height()) > kMostPictureSidePx)
    halve_picture(model);
  std::string text = internal::base64(internal::gzip(encode_glb(model, title)));
  while (text.size() > kMaxModelBytes && model.picture.width() > 512) {
    halve_picture(model);
    text = internal::base64(internal::gzip(encode_glb(model, title)));
  }
  if (model.picture.width() != full_width) {
    remarks.push_back(fmt::format("In viewer.html the skin's picture is {} px wide, of {} px.",
                                  model.picture.width(),
                                  full_width));
  }
  return text;
}

/// A photo as a data URL; the page shows no other pictures.
Json photo_of(const Finding& finding, const fs::path& folder, std::size_t& bytes_left) {
  const bool is_plain_name = !finding.photo.empty() &&
                             finding.photo.find('/') == std::string::npos &&
                             !finding.photo.starts_with('.');
  if (!is_plain_name) return nullptr;
  const auto bytes = read_text_file(folder / finding.photo, kMaxPhotoBytes);
  if (!bytes || !bytes->starts_with("\x89PNG") || bytes->size() * 4 / 3 > bytes_left)
    return nullptr;
  std::string url = "data:image/png;base64," + internal::base64(*bytes);
  bytes_left -= std::min(bytes_left, url.size());
  return url;
}

Json findings_json(const DocumentSource& source, std::vector<std::string>& remarks) {
  Json list = Json::array();
  std::size_t bytes_left = kMaxPhotosBytes;
  std::size_t num_left_out = 0;
  for (const auto& finding : source.findings) {
    Json shown = internal::to_json(finding);
    shown["photo"] = photo_of(finding, source.findings_folder, bytes_left);
    if (!finding.photo.empty() && shown["photo"].is_null()) ++num_left_out;
    list.push_back(std::move(shown));
  }
  if (num_left_out > 0)
    remarks.push_back(
        fmt::format("In viewer.html {} photos of findings are left out.", num_left_out));
  return list;
}

struct PackedVolume {
  Json json;  ///< null: none.
  std::string text;
};

PackedVolume packed_volume(const Volume& volume,
                           std::size_t bytes_left,
                           std::vector<std::string>& remarks) {
  for (const int side : kVolumeSides) {
    const auto small = internal::shrink_volume(volume, side);
    std::string text = internal::base64(internal::gzip(small.codes));
    if (text.size() > bytes_left) continue;
    Json codes = Json::array();
    for (const auto& [code, hu] : internal::kHuCodes) codes.push_back({code, hu});
    Json axes = Json::array();
    for (int axis = 0; axis < 3; ++axis)
      axes.push_back(to_json(small.ct_from_grid.linear().col(axis)));
    remarks.push_back(fmt::format(
        "In viewer.html the CT has voxels of {:.2f} x {:.2f} x {:.2f} mm (of {:.2f} x {:.2f} x "
        "{:.2f} mm) and steps of 4 HU in soft tissue, 16 to 20 HU elsewhere.",
        small.spacing_mm.x(),
        small.spacing_mm.y(),
        small.spacing_mm.z(),
        volume.spacing_mm.x(),
        volume.spacing_mm.y(),
        volume.spacing_mm.z()));
    return {{{"size", small.size},
             {"spacing_mm", to_json(small.spacing_mm)},
             {"origin_mm", to_json(small.ct_from_grid.translation())},
             {"axes", axes},
             {"source_spacing_mm", to_json(volume.spacing_mm)},
             {"codes", codes}},
            std::move(text)};
  }
  remarks.emplace_back("viewer.html has no CT slices: there was no room for them.");
  return {nullptr, ""};
}

Result<std::string> read_template(const fs::path& file) {
  auto text = read_text_file(file, kMaxTemplateBytes);
  if (!text) {
    return make_error(ErrorCode::kNotFound,
                      fmt::format("{}: the viewer page is not built: build it with ./run or "
                                  "`npm run build` in web/",
                                  file.string()));
  }
  if (text->find(kPlaceOfData) == std::string::npos) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{} is not the viewer page", file.string()));
  }
  return text;
}

}  // namespace

Result<ViewerPage> fill_viewer(const DocumentSource& source,
                               const ExportModel& model,
                               const ExportTitle& title,
                               const fs::path& template_file) {
  MOR_TRY(std::string page, read_template(template_file));
  ViewerPage result;
  const std::string model_text = packed_model(model, title, result.remarks);
  Json facts = Json::array();
  for (const auto& fact : source.facts) facts.push_back({fact.name, fact.value});
  Json json = {{"name", source.case_name},
               {"description", source.ct_description},
               {"made_at", title.created_at},
               {"version", kVersion},
               {"textured", !model.picture.empty()},
               {"seen_share", model.seen_share},
               {"facts", facts},
               {"findings", findings_json(source, result.remarks)},
               {"volume", nullptr}};
  constexpr std::size_t kSpare = 20'000;
  const std::size_t used = page.size() + model_text.size() + json_text(json).size() + kSpare;
  std::string volume_text;
  if (source.volume && used < kMaxViewerBytes) {
    auto volume = packed_volume(*source.volume, kMaxViewerBytes - used, result.remarks);
    json["volume"] = std::move(volume.json);
    volume_text = std::move(volume.text);
  }
  json["remarks"] = result.remarks;
  const std::string data = block("morgagni-case", "application/json", json_text(json)) +
                           block("morgagni-model", "text/plain", model_text) +
                           block("morgagni-volume", "text/plain", volume_text);
  page.replace(page.find(kPlaceOfData), std::string_view(kPlaceOfData).size(), data);
  if (page.size() > kMaxViewerBytes) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("viewer.html would have {} bytes, at most {} are allowed: leave "
                                  "structures or findings out",
                                  page.size(),
                                  kMaxViewerBytes));
  }
  result.html = std::move(page);
  return result;
}

}  // namespace mor
