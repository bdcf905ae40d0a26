// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/casefile/prepare.h"

#include <array>
#include <chrono>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>
#include <tbb/parallel_invoke.h>

#include "morgagni/casefile/added_cts.h"
#include "morgagni/casefile/case.h"
#include "morgagni/casefile/internal/case_format.h"
#include "morgagni/casefile/internal/structures.h"
#include "morgagni/casefile/kept_folders.h"
#include "morgagni/core/files.h"
#include "morgagni/core/folder_lock.h"
#include "morgagni/core/image_png.h"
#include "morgagni/core/pending_folder.h"
#include "morgagni/core/printable_text.h"
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

const Eigen::Vector3d kBoneColor(0.93, 0.89, 0.78);

double seconds_between(Clock::time_point start, Clock::time_point end) {
  return std::chrono::duration<double>(end - start).count();
}

Json to_json(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Json to_json(const std::vector<Eigen::Vector3d>& places) {
  Json list = Json::array();
  for (const auto& place : places) list.push_back(to_json(place));
  return list;
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
            {"gradation", skin.gradation},
            {"keep_mm", to_json(skin.keep_mm)},
            {"cut_mm", to_json(skin.cut_mm)},
            {"take_off_mm", to_json(skin.take_off_mm)}}},
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
          {"series", options.ct.series},
          {"join", options.ct.join},
          {"align_series", options.ct.align}};
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
  return {{"source", printable_text(fs::absolute(source).lexically_normal().filename().string())},
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
      fmt::format("{} holds what was made on another CT ({}, {}): name another folder for this one",
                  folder.string(),
                  fmt::join(kKeptFolders, ", "),
                  kAddedCtsFolder));
}

/// Nobody writes into the case, or a CT that was added to it, while it is exchanged; and the case
/// that a CT is added to stays where it is.
Result<std::vector<FolderLock>> lock_case(const fs::path& folder) {
  const auto busy = [](const fs::path& where) {
    return fmt::format("{} is in use by another Morgagni: stop that one first", where.string());
  };
  std::vector<FolderLock> locks;
  if (const fs::path case_folder = case_of_added_ct(folder); !case_folder.empty()) {
    MOR_TRY(auto lock, FolderLock::take(case_folder, FolderLock::Kind::kShared, busy(case_folder)));
    locks.push_back(std::move(lock));
  }
  std::vector<fs::path> exchanged = {folder};
  for (const auto& name : added_cts(folder)) exchanged.push_back(folder / kAddedCtsFolder / name);
  for (const auto& path : exchanged) {
    std::error_code status;
    if (!fs::is_directory(path, status)) continue;
    MOR_TRY(auto lock, FolderLock::take(path, FolderLock::Kind::kExclusive, busy(path)));
    locks.push_back(std::move(lock));
  }
  return locks;
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

Json to_json(const std::vector<SkinDoubt>& doubts) {
  constexpr std::array<const char*, 4> kWhy = {
      "cover taken off", "layer taken off", "layer taken off on demand", "layer may go on"};
  Json list = Json::array();
  for (const auto& doubt : doubts)
    list.push_back({{"place", doubt.place},
                    {"area_cm2", doubt.area_cm2},
                    {"up_to_mm", doubt.up_to_mm},
                    {"why", kWhy[static_cast<std::size_t>(doubt.why)]},
                    {"middle_mm", to_json(doubt.middle_mm)}});
  return list;
}

struct Prepared {
  TriangleMesh skin;
  TriangleMesh bone;
  std::vector<StructureSurface> structures;  ///< Beside the bone.
  DistanceField field;
  std::vector<std::byte> preview;  ///< PNG.
  Volume body;
};

Result<void> write_case(const fs::path& folder,
                        const Prepared& prepared,
                        Json& document,
                        const Progress& progress) {
  MOR_CHECK(write_ply(folder / internal::kSkinFile, prepared.skin));
  MOR_CHECK(write_file(folder / internal::kPreviewFile, prepared.preview));
  progress("write case", 0.1);
  MOR_CHECK(write_distance_field(folder / internal::kFieldFile, prepared.field));
  progress("write case", 0.3);
  MOR_CHECK(write_volume(folder / internal::kVolumeFile, prepared.body));
  progress("write case", 0.5);
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
  progress("write case", 0.6);
  MOR_TRY(document["files"], hashes(folder));
  // A file's name need not be UTF-8.
  return write_file(folder / kCaseFile,
                    document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

/// Pieces of work side by side, told as one stage.
class SideBySide {
 public:
  explicit SideBySide(const Progress& progress) : progress_(progress) {}

  /// To tell a piece's progress to. @param share  Of the whole.
  [[nodiscard]] Progress part(double share) {
    return [this, share, told = 0.0](std::string_view, double fraction) mutable {
      if (fraction <= told) return;
      const std::lock_guard lock(mutex_);
      done_ += share * (fraction - std::exchange(told, fraction));
      progress_(kStage, std::min(done_, 0.99));
    };
  }
  void end() const { progress_(kStage, 1.0); }

 private:
  static constexpr const char* kStage = "remesh, structures";
  const Progress& progress_;
  std::mutex mutex_;
  double done_ = 0.0;
};

/// Surfaces and voxels of the CT: all that a case holds.
Result<Prepared> made_of(const Volume& volume,
                         const PrepareOptions& options,
                         const Progress& progress,
                         PrepareSummary& summary) {
  Prepared prepared;
  MOR_TRY(auto skin, find_skin(volume, options.skin, progress));
  Result<TriangleMesh> remeshed;
  Result<DistanceField> field;
  Result<TriangleMesh> bone;
  Result<std::vector<StructureSurface>> found;
  SideBySide work(progress);
  tbb::parallel_invoke(  // Most of each keeps one core busy.
      [&] {
        remeshed = remesh_skin(skin.full, options.skin, work.part(0.4));
        if (remeshed) field = DistanceField::build(*remeshed);
      },
      [&] {
        bone = extract_bone(skin.body, options.bone, work.part(0.3));
        found = extract_automatic_structures(skin.body, options.automatic, work.part(0.3));
      });
  MOR_TRY(skin.remeshed, std::move(remeshed));
  MOR_TRY(prepared.field, std::move(field));
  MOR_TRY(prepared.bone, std::move(bone));
  MOR_TRY(auto structures, std::move(found));
  work.end();
  MOR_TRY(prepared.structures,
          internal::all_structures(volume, std::move(structures), options, progress));
  summary.num_skin_vertices = skin.remeshed.vertices.size();
  summary.num_full_skin_vertices = skin.full.vertices.size();
  summary.num_bone_triangles = prepared.bone.triangles.size();
  summary.cut = skin.preview.cut;
  summary.doubts = skin.preview.doubts;
  for (const auto& structure : prepared.structures)
    summary.structure_names.push_back(structure.name);
  prepared.skin = std::move(skin.remeshed);
  prepared.preview = encode_png(skin.preview.picture.view());
  prepared.body = std::move(skin.body);
  return prepared;
}

/// The case in its folder, which the caller has locked.
Result<PrepareSummary> prepare_locked(const Volume& volume,
                                      const fs::path& source,
                                      const fs::path& folder,
                                      const PrepareOptions& options,
                                      const Progress& progress) {
  const auto started = Clock::now();
  const Json ct_identity = identity(volume, source);
  MOR_CHECK(check_kept(folder, ct_identity));
  PrepareSummary summary;
  MOR_TRY(const Prepared prepared, made_of(volume, options, progress, summary));

  progress("write case", 0.0);
  MOR_TRY(auto pending, PendingFolder::create(folder, PendingFolder::WhenKilled::kRemove));
  Json document = {{"format", internal::kCaseFormat},
                   {"name", case_title(folder)},
                   {"made_by", fmt::format("Morgagni {}", kVersion)},
                   {"made_at", utc_text()},
                   {"ct", ct_identity},
                   {"options", to_json(options)},
                   {"cut", to_json(summary.cut)},
                   {"doubtful_skin", to_json(summary.doubts)}};
  MOR_CHECK(write_case(pending.path(), prepared, document, progress));
  progress("write case", 0.8);
  MOR_CHECK(carry_over_kept_folders(folder, pending.path()));
  progress("write case", 0.9);
  MOR_CHECK(pending.commit());
  progress("write case", 1.0);
  summary.seconds = seconds_between(started, Clock::now());
  return summary;
}

}  // namespace

Result<void> PrepareOptions::check() const {
  MOR_CHECK(skin.check());
  MOR_CHECK(bone.check());
  MOR_CHECK(labels.check());
  MOR_CHECK(mesh.check());
  return automatic.check();
}

Result<void> check_case_folder(const fs::path& folder) {
  MOR_CHECK(check_target(folder));
  MOR_TRY(const auto locks, lock_case(folder));
  return {};
}

Result<PrepareSummary> prepare_case(const fs::path& ct,
                                    const fs::path& folder,
                                    const PrepareOptions& options,
                                    const Progress& progress) {
  MOR_CHECK(options.check());
  MOR_CHECK(check_target(folder));
  MOR_TRY(const auto locks, lock_case(folder));
  const auto started = Clock::now();
  MOR_TRY(const Volume volume, import_volume(ct, options.ct, progress));
  const double reading_seconds = seconds_between(started, Clock::now());
  MOR_TRY(auto summary, prepare_locked(volume, ct, folder, options, progress));
  summary.reading_seconds = reading_seconds;
  return summary;
}

Result<PrepareSummary> prepare_case(const Volume& volume,
                                    const fs::path& source,
                                    const fs::path& folder,
                                    const PrepareOptions& options,
                                    const Progress& progress) {
  MOR_CHECK(options.check());
  MOR_CHECK(check_target(folder));
  MOR_TRY(const auto locks, lock_case(folder));
  return prepare_locked(volume, source, folder, options, progress);
}

}  // namespace mor
