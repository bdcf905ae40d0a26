// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/casefile/prepare.h"

#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <string>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/casefile/case.h"
#include "morgagni/casefile/internal/case_format.h"
#include "morgagni/casefile/kept_folders.h"
#include "morgagni/core/files.h"
#include "morgagni/core/folder_lock.h"
#include "morgagni/core/image_png.h"
#include "morgagni/core/pending_folder.h"
#include "morgagni/core/utc.h"
#include "morgagni/core/version.h"
#include "morgagni/geometry/triangle_mesh_io.h"
#include "morgagni/geometry/volume_io.h"
#include "morgagni/registration/distance_field.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kMaxStructures = 200;  ///< As many as load_case() takes.
const Eigen::Vector3d kBoneColor(0.93, 0.89, 0.78);

double seconds_between(Clock::time_point start, Clock::time_point end) {
  return std::chrono::duration<double>(end - start).count();
}

Json to_json(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Json to_json(const PrepareOptions& options) {
  const auto& skin = options.skin;
  const auto& bone = options.bone;
  return {{"skin",
           {{"threshold_hu", skin.threshold_hu},
            {"upper_hu", skin.upper_hu},
            {"closing_mm", skin.closing_mm},
            {"num_vertices", skin.num_vertices},
            {"sub_sampling", skin.sub_sampling},
            {"gradation", skin.gradation}}},
          {"bone",
           {{"threshold_hu", bone.threshold_hu},
            {"min_component_mm3", bone.min_component_mm3},
            {"num_triangles", bone.num_triangles}}},
          {"automatic",
           {{"gas_hu", options.automatic.gas_hu},
            {"lung_min_mean_hu", options.automatic.lung_min_mean_hu},
            {"min_lung_ml", options.automatic.min_lung_ml},
            {"min_gas_ml", options.automatic.min_gas_ml},
            {"metal_hu", options.automatic.metal_hu},
            {"min_metal_mm3", options.automatic.min_metal_mm3},
            {"num_triangles", options.automatic.num_triangles}}},
          {"mesh",
           {{"frame", options.mesh.frame == MeshFrame::kRas ? "ras" : "lps"},
            {"num_triangles", options.mesh.num_triangles}}},
          {"labels",
           {{"num_triangles", options.labels.num_triangles},
            {"min_volume_mm3", options.labels.min_volume_mm3},
            {"total_segmentator", options.total_segmentator}}},
          {"series", options.ct.series}};
}

Eigen::Vector3d center_mm(const Volume& volume) {
  Eigen::Vector3d middle;
  for (int axis = 0; axis < 3; ++axis) {
    middle[axis] =
        0.5 * (volume.size[static_cast<std::size_t>(axis)] - 1) * volume.spacing_mm[axis];
  }
  return volume.ct_from_grid * middle;
}

Eigen::Vector3d half_voxel_mm(const Volume& volume) {
  return 0.5 * (volume.ct_from_grid.linear() * volume.spacing_mm);
}

/// Which CT this is: read from the voxels, so that it holds for a folder of slices as for one file.
Json identity(const Volume& volume, const fs::path& source) {
  Json axes = Json::array();
  for (int column = 0; column < 3; ++column) {
    axes.push_back(to_json(Eigen::Vector3d(volume.ct_from_grid.linear().col(column))));
  }
  return {{"source", fs::absolute(source).lexically_normal().filename().string()},
          {"description", volume.description},
          {"size", volume.size},
          {"spacing_mm", to_json(volume.spacing_mm)},
          {"origin_mm", to_json(Eigen::Vector3d(volume.ct_from_grid.translation()))},
          {"axes", axes},
          {"center_mm", to_json(center_mm(volume))},
          {"half_voxel_mm", to_json(half_voxel_mm(volume))},
          {"voxels_sha256", sha256_hex(std::as_bytes(std::span(volume.hu)))}};
}

Result<void> check_target(const fs::path& folder) {
  std::error_code status;
  if (!fs::exists(folder, status) || fs::exists(folder / kCaseFile, status)) return {};
  if (fs::is_directory(folder, status) && fs::is_empty(folder, status)) return {};
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("{} exists and is no case (it has no {}): name another folder",
                                folder.string(),
                                kCaseFile));
}

/// What people made belongs to the CT that it was made on: another one must not take it over.
Result<void> check_kept(const fs::path& folder, const Json& ct) {
  if (!has_kept_files(folder)) return {};
  constexpr std::uintmax_t kMaxCaseJsonBytes = 16U << 20U;
  const auto text = read_text_file(folder / kCaseFile, kMaxCaseJsonBytes);
  const Json before = Json::parse(text.value_or(""), nullptr, /*allow_exceptions=*/false);
  const auto said = [](const Json& json, const char* key) {
    return json.is_object() ? json.value(key, Json()) : Json();
  };
  const auto is_same = [&](const char* key) { return said(said(before, "ct"), key) == ct.at(key); };
  if (is_same("voxels_sha256") && is_same("size") && is_same("spacing_mm") &&
      is_same("origin_mm") && is_same("axes"))
    return {};
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format("{} holds what was made on another CT ({}): name another folder for this one",
                  folder.string(),
                  fmt::join(kKeptFolders, ", ")));
}

/// Nobody writes into the case while it is exchanged. None: there is no case yet.
Result<std::optional<FolderLock>> lock_case(const fs::path& folder) {
  std::error_code status;
  if (!fs::is_directory(folder, status)) return std::nullopt;
  MOR_TRY(auto lock,
          FolderLock::take(folder,
                           FolderLock::Kind::kExclusive,
                           fmt::format("{} is in use by another Morgagni: stop that one first",
                                       folder.string())));
  return std::optional(std::move(lock));
}

Result<Json> hashes(const fs::path& folder) {
  std::map<std::string, std::string> by_name;
  for (const auto& entry : fs::directory_iterator(folder)) {
    MOR_TRY(by_name[entry.path().filename().string()], sha256_hex_of_file(entry.path()));
  }
  return Json(by_name);
}

Json to_json(const std::vector<CutPart>& parts) {
  Json list = Json::array();
  for (const auto& part : parts)
    list.push_back(
        {{"place", part.place}, {"volume_ml", part.volume_ml}, {"size_mm", to_json(part.size_mm)}});
  return list;
}

Eigen::AlignedBox3d box_of(const Volume& grid) {
  Eigen::AlignedBox3d box;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d place;
    for (int axis = 0; axis < 3; ++axis)
      place[axis] = (corner >> axis & 1) * (grid.size[static_cast<std::size_t>(axis)] - 1) *
                    grid.spacing_mm[axis];
    box.extend(grid.ct_from_grid * place);
  }
  return box;
}

/// No structure of another body: it has to lie where the CT lies.
Result<void> check_place(const Eigen::AlignedBox3d& box,
                         const Volume& volume,
                         const fs::path& path,
                         const char* otherwise) {
  constexpr double kLeastShare = 0.5;
  const auto common = box.intersection(box_of(volume));
  // A flat structure has no volume, but lies somewhere too.
  const Eigen::Vector3d sizes = box.sizes().cwiseMax(1e-3);
  if (!common.isEmpty() && common.sizes().cwiseMax(1e-3).prod() >= kLeastShare * sizes.prod())
    return {};
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format("{} lies elsewhere in space than the CT: {}", path.string(), otherwise));
}

/// Structures from files, each name once.
class GivenStructures {
 public:
  GivenStructures(const Volume& volume, std::vector<StructureSurface> found)
      : volume_(volume), all_(std::move(found)) {
    for (const auto& structure : all_) names_.insert(structure.name);
  }

  Result<void> add_label_map(const fs::path& path,
                             const PrepareOptions& options,
                             const Progress& progress) {
    MOR_TRY(LabelMap labels, import_label_map(path, progress));
    MOR_CHECK(check_place(box_of(labels.voxels), volume_, path, "it was made from another scan"));
    if (labels.names.empty() && options.total_segmentator) labels.names = total_segmentator_names();
    auto surfaces = extract_labels(labels, options.labels, progress);
    if (!surfaces)
      return make_error(surfaces.error().code, path.string() + ": " + surfaces.error().message);
    for (auto& surface : *surfaces) add(std::move(surface));
    return {};
  }

  Result<void> add_mesh(const fs::path& path,
                        const PrepareOptions& options,
                        const Progress& progress) {
    MOR_TRY(auto surface, import_structure_mesh(path, options.mesh, progress));
    MOR_CHECK(check_place(surface.mesh.bounds().cast<double>(),
                          volume_,
                          path,
                          "it is of another scan, in RAS (--structure-frame ras), or not in mm"));
    add(std::move(surface));
    return {};
  }

  Result<std::vector<StructureSurface>> take() {
    if (all_.size() < kMaxStructures) return std::move(all_);
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format(
            "there are {} structures, a case takes up to {}", all_.size(), kMaxStructures - 1));
  }

 private:
  void add(StructureSurface surface) {
    const std::string name = surface.name;
    for (int i = 2; !names_.insert(surface.name).second; ++i)
      surface.name = fmt::format("{} {}", name, i);
    all_.push_back(std::move(surface));
  }

  const Volume& volume_;
  std::vector<StructureSurface> all_;
  std::set<std::string> names_ = {"bone", "skin"};
};

Result<std::vector<StructureSurface>> all_structures(const Volume& volume,
                                                     const Volume& body,
                                                     const PrepareOptions& options,
                                                     const Progress& progress) {
  MOR_TRY(auto found, extract_automatic_structures(body, options.automatic, progress));
  GivenStructures given(volume, std::move(found));
  for (const auto& path : options.label_maps)
    MOR_CHECK(given.add_label_map(path, options, progress));
  for (const auto& path : options.meshes) MOR_CHECK(given.add_mesh(path, options, progress));
  return given.take();
}

struct Prepared {
  TriangleMesh skin;
  TriangleMesh bone;
  std::vector<StructureSurface> structures;  ///< Beside the bone.
  DistanceField field;
  std::vector<std::byte> preview;  ///< PNG.
  Volume body;
};

Result<void> write_case(const fs::path& folder, const Prepared& prepared, Json& document) {
  MOR_CHECK(write_ply(folder / internal::kSkinFile, prepared.skin));
  MOR_CHECK(write_file(folder / internal::kPreviewFile, prepared.preview));
  MOR_CHECK(write_distance_field(folder / internal::kFieldFile, prepared.field));
  MOR_CHECK(write_volume(folder / internal::kVolumeFile, prepared.body));
  document["structures"] = Json::array();
  if (!prepared.bone.empty()) {
    MOR_CHECK(write_ply(folder / internal::kBoneFile, prepared.bone));
    document["structures"].push_back(
        {{"name", "bone"}, {"file", internal::kBoneFile}, {"color", to_json(kBoneColor)}});
  }
  for (std::size_t i = 0; i < prepared.structures.size(); ++i) {
    const auto& structure = prepared.structures[i];
    const std::string file = fmt::format("structure_{:03}.ply", i + 1);
    MOR_CHECK(write_ply(folder / file, structure.mesh));
    document["structures"].push_back({{"name", structure.name},
                                      {"file", file},
                                      {"color", to_json(structure.color.cast<double>())}});
  }
  MOR_TRY(document["files"], hashes(folder));
  return write_file(folder / kCaseFile, document.dump(2) + "\n");
}

}  // namespace

Result<PrepareSummary> prepare_case(const fs::path& ct,
                                    const fs::path& folder,
                                    const PrepareOptions& options,
                                    const Progress& progress) {
  MOR_CHECK(options.skin.check());
  MOR_CHECK(options.bone.check());
  MOR_CHECK(options.labels.check());
  MOR_CHECK(options.mesh.check());
  MOR_CHECK(options.automatic.check());
  MOR_CHECK(check_target(folder));
  MOR_TRY(const auto lock, lock_case(folder));

  const auto started = Clock::now();
  MOR_TRY(const Volume volume, import_volume(ct, options.ct, progress));
  const auto read = Clock::now();
  const Json ct_identity = identity(volume, ct);
  MOR_CHECK(check_kept(folder, ct_identity));

  MOR_TRY(auto skin, extract_skin(volume, options.skin, progress));
  MOR_TRY(auto bone, extract_bone(skin.body, options.bone, progress));
  MOR_TRY(auto structures, all_structures(volume, skin.body, options, progress));
  progress("distance field", 0.0);
  MOR_TRY(auto field, DistanceField::build(skin.remeshed));
  progress("distance field", 1.0);

  PrepareSummary summary;
  summary.num_skin_vertices = skin.remeshed.vertices.size();
  summary.num_full_skin_vertices = skin.full.vertices.size();
  summary.num_bone_triangles = bone.triangles.size();
  summary.cut = skin.preview.cut;
  for (const auto& structure : structures) summary.structure_names.push_back(structure.name);

  progress("write case", 0.0);
  MOR_TRY(auto pending, PendingFolder::create(folder));
  Json document = {
      {"format", internal::kCaseFormat},
      {"name", fs::absolute(folder / "").lexically_normal().parent_path().filename().string()},
      {"made_by", fmt::format("Morgagni {}", kVersion)},
      {"made_at", utc_text()},
      {"ct", ct_identity},
      {"options", to_json(options)},
      {"cut", to_json(skin.preview.cut)}};
  MOR_CHECK(write_case(pending.path(),
                       {std::move(skin.remeshed),
                        std::move(bone),
                        std::move(structures),
                        std::move(field),
                        encode_png(skin.preview.picture.view()),
                        std::move(skin.body)},
                       document));
  progress("write case", 0.8);
  MOR_CHECK(carry_over_kept_folders(folder, pending.path()));
  progress("write case", 0.9);
  MOR_CHECK(pending.commit());
  progress("write case", 1.0);

  summary.reading_seconds = seconds_between(started, read);
  summary.seconds = seconds_between(read, Clock::now());
  return summary;
}

}  // namespace mor
