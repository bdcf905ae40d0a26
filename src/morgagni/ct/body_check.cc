// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/body_check.h"

#include <algorithm>
#include <array>
#include <utility>

#include <tbb/parallel_for.h>

#include "morgagni/ct/internal/body_mask.h"
#include "morgagni/ct/internal/body_parts.h"
#include "morgagni/ct/internal/check_slice.h"
#include "morgagni/ct/internal/coarse_volume.h"
#include "morgagni/ct/internal/components.h"
#include "morgagni/ct/internal/doubtful_skin.h"
#include "morgagni/ct/internal/marching_cubes.h"
#include "morgagni/ct/internal/uncovering.h"

namespace mor {
namespace {

constexpr double kSmallMm = 1.25;

/// As far apart as colours can be that are neither grey nor the outline's green and orange.
constexpr std::array<Rgb8, 9> kColors = {Rgb8{232, 72, 60},
                                         Rgb8{186, 104, 255},
                                         Rgb8{64, 156, 255},
                                         Rgb8{255, 105, 180},
                                         Rgb8{240, 220, 70},
                                         Rgb8{0, 200, 200},
                                         Rgb8{176, 124, 88},
                                         Rgb8{255, 190, 160},
                                         Rgb8{140, 150, 255}};

std::vector<std::uint8_t> labels_of(const std::vector<internal::BitMask>& parts,
                                    const Volume& grid) {
  std::vector<std::uint8_t> labels(grid.num_voxels());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    tbb::parallel_for(0, grid.size[2], [&](int z) {
      for (int y = 0; y < grid.size[1]; ++y)
        for (int x = 0; x < grid.size[0]; ++x)
          if (parts[i].test(x, y, z))
            labels[grid.index(x, y, z)] = static_cast<std::uint8_t>(i + 1);
    });
  }
  return labels;
}

}  // namespace

struct BodyCheck::Found {
  internal::BodyMask mask;
  SkinOptions options;
  std::vector<BodyPart> parts;
  std::vector<internal::BitMask> voxels;  ///< Of each part.
  internal::DoubtfulSkin doubtful;
  std::vector<std::uint8_t> labels;  ///< The same, as CheckedBody has it.
};

BodyCheck::BodyCheck(std::shared_ptr<const Volume> volume)
    : volume_(std::move(volume)),
      coarse_(internal::coarse_volume(*volume_, kSmallMm)),
      bare_(std::make_unique<const internal::BareCt>(internal::bare_ct(coarse_))) {}

BodyCheck::~BodyCheck() = default;

Result<void> BodyCheck::find(const SkinOptions& options) {
  MOR_CHECK(options.check());
  auto bare = options.take_off_mm == taken_off_mm_
                  ? nullptr
                  : std::make_unique<const internal::BareCt>(
                        internal::bare_ct(coarse_, options.take_off_mm));
  const internal::BareCt& seen = bare ? *bare : *bare_;
  auto found = std::make_unique<Found>();
  internal::BodyMaskOptions mask_options = {
      options.threshold_hu, options.upper_hu, options.closing_mm};
  const auto matter = internal::threshold(coarse_, options.threshold_hu, options.upper_hu);
  for (const auto& mark : options.keep_mm)
    if (internal::is_near(matter, mark, coarse_)) mask_options.keep_mm.push_back(mark);
  MOR_TRY(found->mask, internal::body_mask(coarse_, seen, mask_options, {}));
  // A mark may have lost its part to the body: that can only be told once the body is found.
  for (const auto& mark : options.cut_mm)
    if (internal::is_near(found->mask.found_standing_out, mark, coarse_))
      mask_options.cut_mm.push_back(mark);
  if (!mask_options.cut_mm.empty()) {
    MOR_TRY(found->mask, internal::body_mask(coarse_, seen, mask_options, {}));
  }
  found->options = options;

  const auto& mask = found->mask;
  for (const bool stands_out : {false, true}) {
    const auto& where = stands_out ? mask.found_standing_out : mask.found_cut;
    const internal::Components components(where);
    for (auto& what : internal::parts_of(where, mask.body, coarse_)) {
      const Eigen::Vector3i at =
          coarse_.nearest_voxel(coarse_.ct_from_grid.inverse() * what.marks_mm.front());
      const auto component = components.part_at({at.x(), at.y(), at.z()});
      found->voxels.push_back(
          components.select([&](std::size_t i) { return component && i == *component; }));
      found->parts.push_back({.what = std::move(what),
                              .stands_out = stands_out,
                              .is_kept = mask.body.test(at.x(), at.y(), at.z()),
                              .color = kColors[found->parts.size() % kColors.size()]});
    }
  }
  found->doubtful = internal::doubtful_skin(seen, mask.body, coarse_);
  found->labels = labels_of(found->voxels, coarse_);
  found_ = std::move(found);
  if (bare) bare_ = std::move(bare);
  taken_off_mm_ = options.take_off_mm;
  return {};
}

const std::vector<BodyPart>& BodyCheck::parts() const {
  static const std::vector<BodyPart> kNone;
  return found_ ? found_->parts : kNone;
}

bool BodyCheck::holds(std::size_t part, const Eigen::Vector3d& mark_mm) const {
  return found_ && part < found_->voxels.size() &&
         internal::is_near(found_->voxels[part], mark_mm, coarse_);
}

const std::vector<SkinDoubt>& BodyCheck::doubts() const {
  static const std::vector<SkinDoubt> kNone;
  return found_ ? found_->doubtful.stretches : kNone;
}

double BodyCheck::body_ml() const {
  if (!found_) return 0.0;
  return static_cast<double>(found_->mask.body.count()) * coarse_.spacing_mm.prod() / 1000.0;
}

Eigen::Vector3d BodyCheck::size_mm(BodyPlane plane) const {
  return internal::SliceFrame(*volume_, plane).size_mm();
}

double BodyCheck::position(BodyPlane plane, const Eigen::Vector3d& place_mm) const {
  return internal::SliceFrame(*volume_, plane)
      .share_through(volume_->ct_from_grid.inverse() * place_mm);
}

Image<Rgb8> BodyCheck::slice(BodyPlane plane, double position, int height_px) const {
  if (!found_) return internal::draw_check_slice(*volume_, plane, position, height_px, nullptr);
  const internal::CheckedBody body = {coarse_,
                                      found_->mask.body,
                                      found_->doubtful.where,
                                      found_->labels,
                                      found_->parts,
                                      found_->options.threshold_hu,
                                      found_->options.upper_hu};
  return internal::draw_check_slice(*volume_, plane, position, height_px, &body);
}

TriangleMesh BodyCheck::skin() const {
  if (!found_) return {};
  return internal::marching_cubes(
      bare_->volume ? *bare_->volume : coarse_, found_->mask.body, found_->options.threshold_hu);
}

TriangleMesh BodyCheck::doubtful_skin() const {
  TriangleMesh mesh = skin();
  const Eigen::Isometry3d grid_from_ct = coarse_.ct_from_grid.inverse();
  const auto is_doubtful = [&](std::uint32_t vertex) {
    const Eigen::Vector3i at =
        coarse_.nearest_voxel(grid_from_ct * mesh.vertices[vertex].cast<double>());
    return found_->doubtful.where.test(at.x(), at.y(), at.z());
  };
  std::erase_if(mesh.triangles, [&](const Triangle& triangle) {
    return !std::all_of(triangle.begin(), triangle.end(), is_doubtful);
  });
  return mesh;
}

TriangleMesh BodyCheck::part_surface(std::size_t part) const {
  if (!found_ || part >= found_->voxels.size()) return {};
  return internal::marching_cubes(coarse_, found_->voxels[part], found_->options.threshold_hu);
}

}  // namespace mor
