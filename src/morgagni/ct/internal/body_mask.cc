// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/body_mask.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/ct/internal/components.h"
#include "morgagni/ct/internal/thin_sheet.h"

namespace mor::internal {
namespace {

/// Half the thickness of what is torn off: more than a table's shell, less than a finger.
constexpr double kOpeningMm = 5.0;
/// The opening rounds the skin off; what it took within this distance is skin in any case.
constexpr double kSkinMm = 1.0;
/// A part that stands out farther from the body than an ear or a nose does not belong to it.
constexpr double kFarthestMm = 40.0;
/// ... nor one that is longer than they are (a nose with its inner walls): a tube, a cable, the
/// edge of a blanket.
constexpr double kLongestMm = 84.0;
/// Smaller parts are no headrest's shell.
constexpr double kLeastShellMm3 = 5000.0;
/// A smaller part beside a tube is what was not recognized of it; ears are larger.
constexpr double kLeastBesideTubeMm3 = 4000.0;
constexpr double kOneStepMm = 6.25;
/// A mark names what lies so near: the CT may be looked at coarsely where it is made.
constexpr double kMarkMm = 3.0;

/// The largest connected part; empty when the mask is.
BitMask largest_part(const BitMask& mask) {
  const Components parts(mask);
  if (parts.parts().empty()) return mask;
  const std::size_t largest = parts.largest();
  return parts.select([&](std::size_t i) { return i == largest; });
}

/// The mask's neighbourhood of one voxel.
BitMask grown_by_a_voxel(const BitMask& mask) {
  return dilated(mask, 1.0, Eigen::Vector3d::Ones());
}

BitMask grown_far(BitMask mask, double distance_mm, const Eigen::Vector3d& spacing_mm) {
  for (; distance_mm > 0.0; distance_mm -= kOneStepMm)
    mask = dilated(mask, std::min(distance_mm, kOneStepMm), spacing_mm);
  return mask;
}

/// Bubbles and noise, closed in on all sides: no opening is to break on them.
BitMask small_pockets(const BitMask& mask, const Eigen::Vector3d& spacing_mm) {
  constexpr double kMostMm3 = 100.0;
  BitMask air = mask;
  air.invert();
  const Components pockets(air);
  const auto most_voxels = static_cast<std::size_t>(kMostMm3 / spacing_mm.prod());
  return pockets.select([&](std::size_t i) {
    return !pockets.parts()[i].at_side && pockets.parts()[i].num_voxels <= most_voxels;
  });
}

/// Air that does not reach the sides of the volume and whose walls are the body's (lungs and bowel,
/// but not the hollow of a table top), with the gaps in its walls.
/// @param closed_mask  Without gaps up to `closing_mm`.
BitMask solid_inside(const BitMask& closed_mask,
                     double closing_mm,
                     const Eigen::Vector3d& spacing_mm) {
  const BitMask core = largest_part(opened(closed_mask, kOpeningMm, spacing_mm));
  BitMask air = closed_mask;
  air.invert();
  const Components pockets(air);
  BitMask walls = grown_by_a_voxel(closed_mask);
  const auto wall_voxels = pockets.overlap(walls);
  walls &= dilated(core, kOpeningMm + kSkinMm, spacing_mm);
  const auto body_wall_voxels = pockets.overlap(walls);
  const BitMask inside = pockets.select([&](std::size_t i) {
    return !pockets.parts()[i].at_side && 2 * body_wall_voxels[i] > wall_voxels[i];
  });
  BitMask solid = dilated(inside, closing_mm + spacing_mm.maxCoeff(), spacing_mm);
  solid &= closed_mask;
  solid |= inside;
  return solid;
}

/// What of `rest` stands out from the body as ears, noses and fingers do.
BitMask standing_out(const BitMask& rest,
                     const BitMask& beside_body,
                     const BitMask& near_core,
                     const BitMask& beside_tube,
                     const Eigen::Vector3d& spacing_mm) {
  const Components parts(rest);
  const auto touching = parts.overlap(beside_body);
  const auto near = parts.overlap(near_core);
  const auto of_tube = parts.overlap(beside_tube);
  const auto least_voxels = static_cast<std::size_t>(kLeastBesideTubeMm3 / spacing_mm.prod());
  return parts.select([&](std::size_t i) {
    const auto& part = parts.parts()[i];
    const Eigen::Vector3d size_mm = Eigen::Vector3d(part.high_x - part.low_x + 1,
                                                    part.high_y - part.low_y + 1,
                                                    part.high_z - part.low_z + 1)
                                        .cwiseProduct(spacing_mm);
    return touching[i] > 0 && near[i] == part.num_voxels && size_mm.maxCoeff() <= kLongestMm &&
           (of_tube[i] == 0 || part.num_voxels >= least_voxels);
  });
}

Eigen::Vector3d middle_of(const BitMask& mask) {
  const Components parts(mask);
  const auto& part = parts.parts()[parts.largest()];
  return 0.5 * Eigen::Vector3d(
                   part.low_x + part.high_x, part.low_y + part.high_y, part.low_z + part.high_z);
}

/// Parts that touch the body and are too large for it, without the thin shells in them: what an
/// ear that lies against a headrest leaves.
BitMask freed_of_shells(const BitMask& rest,
                        const BitMask& beside_body,
                        const Eigen::Vector3d& middle,
                        const Eigen::Vector3d& spacing_mm) {
  const Components parts(rest);
  const auto touching = parts.overlap(beside_body);
  const auto least_voxels = static_cast<std::size_t>(kLeastShellMm3 / spacing_mm.prod());
  BitMask freed(rest.size());
  for (std::size_t i = 0; i < parts.parts().size(); ++i) {
    if (touching[i] == 0 || parts.parts()[i].num_voxels < least_voxels) continue;
    BitMask part = parts.select([&](std::size_t k) { return k == i; });
    part.subtract(thin_sheet(part, middle, spacing_mm));
    freed |= part;
  }
  return freed;
}

struct Torn {
  BitMask body;
  BitMask given_back;  ///< Of the body: what the opening had taken away.
};

/// The solid mask without what only leans on the body.
/// @param tube  Where some was taken off, and around it.
Torn without_what_leans_on(const BitMask& solid,
                           const BitMask& tube,
                           const Eigen::Vector3d& spacing_mm) {
  const BitMask core = largest_part(opened(solid, kOpeningMm, spacing_mm));
  // A hollow thing of thin walls, open to the air: nothing about it is thicker than a table.
  if (core.count() == 0) return {solid, BitMask(solid.size())};
  BitMask body = dilated(core, kSkinMm, spacing_mm);
  body &= solid;
  BitMask rest = solid;
  rest.subtract(body);
  const BitMask beside_body = grown_by_a_voxel(body);
  const BitMask near_core = grown_far(core, kFarthestMm, spacing_mm);
  const BitMask beside_tube = grown_by_a_voxel(tube);
  BitMask given_back = standing_out(rest, beside_body, near_core, beside_tube, spacing_mm);
  rest.subtract(given_back);
  rest.subtract(tube);  // Slivers of one hang on an ear that it lay against.
  given_back |= standing_out(rest, beside_body, near_core, beside_tube, spacing_mm);
  rest.subtract(given_back);
  const BitMask freed = freed_of_shells(rest, beside_body, middle_of(core), spacing_mm);
  given_back |= standing_out(freed, beside_body, near_core, beside_tube, spacing_mm);
  body |= given_back;
  return {std::move(body), std::move(given_back)};
}

/// Everything that air from the sides cannot reach.
BitMask filled(const BitMask& mask) {
  BitMask air = mask;
  air.invert();
  const Components pockets(air);
  BitMask result = pockets.select([&](std::size_t i) { return pockets.parts()[i].at_side; });
  result.invert();
  return result;
}

Result<void> check_air(const BitMask& body, const Volume& volume, double threshold_hu) {
  const std::size_t num_inside = body.count();
  if (num_inside > 0 && num_inside < volume.num_voxels()) return {};
  return make_error(ErrorCode::kInvalidArgument,
                    "there is no air around the body at the threshold " +
                        std::to_string(static_cast<int>(threshold_hu)) +
                        " HU: raise the threshold, or use a CT that shows the skin");
}

/// The voxels within `kMarkMm` of a place, the nearest first; those outside the volume too.
std::vector<std::array<int, 3>> voxels_near(const Eigen::Vector3d& place_mm, const Volume& volume) {
  const Eigen::Vector3d middle =
      (volume.ct_from_grid.inverse() * place_mm).cwiseQuotient(volume.spacing_mm);
  if (!(middle.cwiseAbs().maxCoeff() < 1e6)) return {};
  const Eigen::Vector3i at = middle.array().round().cast<int>();
  const Eigen::Vector3i reach = (kMarkMm / volume.spacing_mm.array()).cast<int>();
  std::vector<std::pair<double, std::array<int, 3>>> voxels;
  for (int z = -reach.z(); z <= reach.z(); ++z) {
    for (int y = -reach.y(); y <= reach.y(); ++y) {
      for (int x = -reach.x(); x <= reach.x(); ++x) {
        const double distance_mm = Eigen::Vector3d(x, y, z).cwiseProduct(volume.spacing_mm).norm();
        if (distance_mm <= kMarkMm)
          voxels.push_back({distance_mm, {at.x() + x, at.y() + y, at.z() + z}});
      }
    }
  }
  std::sort(voxels.begin(), voxels.end());
  std::vector<std::array<int, 3>> places;
  for (const auto& voxel : voxels) places.push_back(voxel.second);
  return places;
}

/// The parts of `mask` that the marks lie in.
/// @param settled  A mark in here asks for what is so already.
Result<BitMask> marked_parts(const BitMask& mask,
                             const BitMask& settled,
                             const std::vector<Eigen::Vector3d>& marks_mm,
                             const Volume& volume,
                             const char* what) {
  const Components parts(mask);
  std::vector<char> is_marked(parts.parts().size());
  for (const auto& mark_mm : marks_mm) {
    std::optional<std::size_t> part;
    for (const auto& voxel : voxels_near(mark_mm, volume))
      if (!part) part = parts.part_at(voxel);
    if (part) {
      is_marked[*part] = 1;
    } else if (!is_near(settled, mark_mm, volume)) {
      return make_error(ErrorCode::kInvalidArgument,
                        fmt::format("there is nothing to {} within {} mm of ({:.1f}, {:.1f}, "
                                    "{:.1f}) at these thresholds",
                                    what,
                                    kMarkMm,
                                    mark_mm.x(),
                                    mark_mm.y(),
                                    mark_mm.z()));
    }
  }
  return parts.select([&](std::size_t i) { return is_marked[i] != 0; });
}

/// Closed and without holes: the largest part, and those that hold something of `kept`.
BitMask finished(const BitMask& mask,
                 const BitMask& kept,
                 double closing_mm,
                 const Eigen::Vector3d& spacing_mm) {
  const BitMask whole = closed(mask, closing_mm, spacing_mm);
  const Components parts(whole);
  if (parts.parts().empty()) return whole;
  const std::size_t largest = parts.largest();
  const auto held = parts.overlap(kept);
  return filled(parts.select([&](std::size_t i) { return i == largest || held[i] > 0; }));
}

}  // namespace

bool is_near(const BitMask& mask, const Eigen::Vector3d& place_mm, const Volume& volume) {
  const auto voxels = voxels_near(place_mm, volume);
  return std::any_of(voxels.begin(), voxels.end(), [&](const std::array<int, 3>& at) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (at[axis] < 0 || at[axis] >= mask.size()[axis]) return false;
    return mask.test(at[0], at[1], at[2]);
  });
}

Result<BodyMask> body_mask(const Volume& volume,
                           const BareCt& bare,
                           const BodyMaskOptions& options,
                           const Progress& progress) {
  const auto report = [&](const char* stage, double fraction) {
    if (progress) progress(stage, fraction);
  };
  report("threshold", 0.0);
  BodyMask result;
  result.matter = threshold(volume, options.threshold_hu, options.upper_hu);
  BitMask mask = result.matter;
  if (mask.count() == 0) {
    return make_error(ErrorCode::kInvalidArgument,
                      "no voxel lies between " +
                          std::to_string(static_cast<int>(options.threshold_hu)) + " and " +
                          std::to_string(static_cast<int>(options.upper_hu)) +
                          " HU: widen the thresholds, or check that the file is a CT");
  }
  MOR_CHECK(check_air(mask, volume, options.threshold_hu));
  if (bare.volume) mask = threshold(*bare.volume, options.threshold_hu, options.upper_hu);
  report("threshold", 1.0);

  report("closing", 0.0);
  const BitMask whole = closed(mask, options.closing_mm, volume.spacing_mm);
  report("closing", 1.0);

  report("body", 0.0);
  // What leans on the body is cut off before gaps are closed: closing would weld it on.
  mask |= small_pockets(mask, volume.spacing_mm);
  mask |= solid_inside(whole, options.closing_mm, volume.spacing_mm);
  report("body", 0.5);
  const BitMask nothing(volume.size);
  Torn torn = without_what_leans_on(mask, bare.volume ? bare.tube : nothing, volume.spacing_mm);
  report("body", 0.8);
  result.body = finished(torn.body, nothing, options.closing_mm, volume.spacing_mm);
  result.found_cut = result.matter;
  result.found_cut.subtract(result.body);
  result.found_standing_out = std::move(torn.given_back);
  result.found_standing_out &= result.body;
  if (!options.keep_mm.empty() || !options.cut_mm.empty()) {
    MOR_TRY(const BitMask kept,
            marked_parts(result.found_cut, result.body, options.keep_mm, volume, "keep"));
    MOR_TRY(
        const BitMask cut,
        marked_parts(result.found_standing_out, result.found_cut, options.cut_mm, volume, "cut"));
    torn.body.subtract(cut);
    torn.body |= kept;
    result.body = finished(torn.body, kept, options.closing_mm, volume.spacing_mm);
    result.body.subtract(cut);
  }
  MOR_CHECK(check_air(result.body, volume, options.threshold_hu));
  report("body", 1.0);
  return result;
}

}  // namespace mor::internal
