// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/casefile/internal/structures.h"

#include <set>
#include <string>

#include <Eigen/Geometry>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/log.h"

namespace mor::internal {
namespace {

namespace fs = std::filesystem;

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
    MOR_TRY(auto maps, import_label_maps(path, progress));
    for (auto& labels : maps) {
      MOR_CHECK(check_place(box_of(labels.voxels), volume_, path, "it was made from another scan"));
      if (labels.names.empty() && options.total_segmentator)
        labels.names = total_segmentator_names();
      auto surfaces = extract_labels(labels, options.labels, progress);
      if (!surfaces && maps.size() > 1) {
        log::warn("a structure of {} is left out: {}", path.string(), surfaces.error().message);
        continue;
      }
      if (!surfaces)
        return make_error(surfaces.error().code, path.string() + ": " + surfaces.error().message);
      for (auto& surface : *surfaces) add(std::move(surface));
    }
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

}  // namespace

Result<std::vector<StructureSurface>> all_structures(const Volume& volume,
                                                     std::vector<StructureSurface> found,
                                                     const PrepareOptions& options,
                                                     const Progress& progress) {
  GivenStructures given(volume, std::move(found));
  for (const auto& path : options.label_maps)
    MOR_CHECK(given.add_label_map(path, options, progress));
  for (const auto& path : options.meshes) MOR_CHECK(given.add_mesh(path, options, progress));
  return given.take();
}

}  // namespace mor::internal
