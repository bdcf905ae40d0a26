// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/automatic_structures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>

#include "morgagni/ct/internal/components.h"
#include "morgagni/ct/internal/marching_cubes.h"
#include "morgagni/ct/internal/surface_finish.h"

namespace mor {
namespace {

using internal::BitMask;
using internal::Components;

constexpr double kLowestHu = -1024.0;
constexpr double kHighestHu = 32767.0;
constexpr double kMm3PerMl = 1000.0;
/// Folds of the skin are air, but no gas in the body: not so deep, or not so wide (half of it).
constexpr double kSkinDepthMm = 5.0;
constexpr double kFoldMm = 3.5;
/// As SkinSurfaces::body keeps them around the body.
constexpr double kAirVoxels = 2.0;

const Eigen::Vector3f kLungColor(0.86F, 0.58F, 0.60F);
const Eigen::Vector3f kGasColor(0.48F, 0.72F, 0.94F);
const Eigen::Vector3f kMetalColor(0.96F, 0.80F, 0.25F);

struct Found {
  std::string name;
  Eigen::Vector3f color;
  BitMask mask;
  double threshold_hu = 0.0;
};

/// The mask's box of the volume with a margin, so that the surface closes: where the margin leaves
/// the volume, its voxels are as far on the other side of the threshold as voxels there are.
std::pair<Volume, BitMask> cut_out(const Volume& volume, const Found& found) {
  constexpr int kMargin = 2;
  constexpr double kContrastHu = 500.0;
  auto [low, end] = internal::box_of(found.mask);
  Volume box;
  box.spacing_mm = volume.spacing_mm;
  Eigen::Vector3d low_mm;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    low[i] -= kMargin;
    box.size[i] = end[i] + kMargin - low[i];
    low_mm[axis] = low[i] * volume.spacing_mm[axis];
  }
  box.ct_from_grid = volume.ct_from_grid * Eigen::Translation3d(low_mm);
  const bool is_dark = found.threshold_hu < 0.0;
  const auto beyond =
      static_cast<std::int16_t>(found.threshold_hu + (is_dark ? kContrastHu : -kContrastHu));
  BitMask inside(box.size);
  box.hu.resize(box.index(0, 0, box.size[2]));
  tbb::parallel_for(0, box.size[2], [&, low = low](int z) {
    for (int y = 0; y < box.size[1]; ++y) {
      for (int x = 0; x < box.size[0]; ++x) {
        const std::array<int, 3> at = {x + low[0], y + low[1], z + low[2]};
        bool is_there = true;
        for (std::size_t i = 0; i < 3; ++i)
          is_there = is_there && at[i] >= 0 && at[i] < volume.size[i];
        box.hu[box.index(x, y, z)] =
            is_there ? volume.hu[volume.index(at[0], at[1], at[2])] : beyond;
        if (is_there && found.mask.test(at[0], at[1], at[2])) inside.set_run(y, z, x, x + 1);
      }
    }
  });
  return {std::move(box), std::move(inside)};
}

double mean_hu(const Volume& volume, const BitMask& mask, const Components::Part& part) {
  double sum = 0.0;
  for (int z = part.low_z; z <= part.high_z; ++z)
    for (int y = part.low_y; y <= part.high_y; ++y)
      for (int x = part.low_x; x <= part.high_x; ++x)
        if (mask.test(x, y, z)) sum += volume.hu[volume.index(x, y, z)];
  return sum / static_cast<double>(part.num_voxels);
}

/// The body without its skin, and without the air that SkinSurfaces::body keeps around it.
BitMask deep_inside(const Volume& body) {
  auto mask = internal::threshold(body, kOutsideHu + 1.0, kHighestHu);
  mask = internal::eroded(std::move(mask), kAirVoxels, Eigen::Vector3d::Ones());
  return internal::eroded(std::move(mask), kSkinDepthMm, body.spacing_mm);
}

/// The voxels that are more than `margin_mm` from the volume's faces.
BitMask inner_box(const Volume& volume, double margin_mm) {
  std::array<int, 3> margin{};
  for (std::size_t i = 0; i < 3; ++i)
    margin[i] = static_cast<int>(std::ceil(margin_mm / volume.spacing_mm[static_cast<int>(i)]));
  BitMask box(volume.size);
  if (volume.size[0] <= 2 * margin[0]) return box;
  for (int z = margin[2]; z < volume.size[2] - margin[2]; ++z)
    for (int y = margin[1]; y < volume.size[1] - margin[1]; ++y)
      box.set_run(y, z, margin[0], volume.size[0] - margin[0]);
  return box;
}

/// Without what is narrower than two folds. At the volume's faces there is nothing beyond: the thin
/// air that SkinSurfaces::body keeps there goes, and lungs that the scan cuts stay.
BitMask without_folds(const BitMask& air, const Volume& body) {
  auto core = internal::eroded(air, kFoldMm, body.spacing_mm);
  core &= inner_box(body, kFoldMm);
  return internal::dilated(core, kFoldMm, body.spacing_mm);
}

/// Gas and lungs. Air that comes in from outside counts where there is a cavity (airways, sinuses),
/// not in the folds of the skin, which are narrow.
BitMask dark_inside(const Volume& body, double gas_hu) {
  const auto deep = deep_inside(body);
  const Components air(internal::threshold(body, kLowestHu, gas_hu));
  auto beside = internal::threshold(body, kOutsideHu, kOutsideHu);
  const auto touching = air.overlap(internal::dilated(beside, 1.0, Eigen::Vector3d::Ones()));
  const auto is_open = [&](std::size_t i) { return touching[i] > 0 || air.parts()[i].at_side; };
  auto cavities = air.select(is_open);
  cavities &= deep;
  cavities = without_folds(cavities, body);
  auto dark = air.select([&](std::size_t i) { return !is_open(i); });
  dark &= deep;
  dark |= cavities;
  return dark;
}

std::vector<Found> find_dark(const Volume& body, const AutomaticStructureOptions& options) {
  const Components parts(dark_inside(body, options.gas_hu));
  const double voxel_ml = body.spacing_mm.prod() / kMm3PerMl;
  const auto volume_ml = [&](std::size_t i) {
    return static_cast<double>(parts.parts()[i].num_voxels) * voxel_ml;
  };
  std::vector<bool> is_lung(parts.parts().size(), false);
  for (std::size_t i = 0; i < is_lung.size(); ++i) {
    if (volume_ml(i) < options.min_lung_ml) continue;
    const auto alone = parts.select([&](std::size_t part) { return part == i; });
    is_lung[i] = mean_hu(body, alone, parts.parts()[i]) >= options.lung_min_mean_hu;
  }
  return {{"lungs",
           kLungColor,
           parts.select([&](std::size_t i) { return is_lung[i]; }),
           options.gas_hu},
          {"gas",
           kGasColor,
           parts.select(
               [&](std::size_t i) { return volume_ml(i) >= options.min_gas_ml && !is_lung[i]; }),
           options.gas_hu}};
}

Found find_metal(const Volume& body, const AutomaticStructureOptions& options) {
  const Components parts(internal::threshold(body, options.metal_hu, kHighestHu));
  const double voxel_mm3 = body.spacing_mm.prod();
  return {"metal",
          kMetalColor,
          parts.select([&](std::size_t i) {
            return static_cast<double>(parts.parts()[i].num_voxels) * voxel_mm3 >=
                   options.min_metal_mm3;
          }),
          options.metal_hu};
}

}  // namespace

Result<void> AutomaticStructureOptions::check() const {
  const auto refuse = [](const std::string& sentence) {
    return make_error(ErrorCode::kInvalidArgument, sentence);
  };
  if (!(gas_hu > kLowestHu && gas_hu < 0.0))
    return refuse("gas_hu must be in (-1024, 0), got " + std::to_string(gas_hu));
  if (!(metal_hu > 0.0 && metal_hu <= 3071.0))
    return refuse("metal_hu must be in (0, 3071], got " + std::to_string(metal_hu));
  if (!(min_lung_ml >= 0.0 && min_gas_ml >= 0.0 && min_metal_mm3 >= 0.0))
    return refuse("the least volume of a structure must be 0 or more");
  if (num_triangles < 100 || num_triangles > 1000000)
    return refuse("num_triangles must be in [100, 1000000], got " + std::to_string(num_triangles));
  return {};
}

Result<std::vector<StructureSurface>> extract_automatic_structures(
    const Volume& body, const AutomaticStructureOptions& options, const Progress& progress) {
  constexpr const char* kStage = "lungs, gas, metal";
  MOR_CHECK(options.check());
  const auto report = [&](double fraction) {
    if (progress) progress(kStage, fraction);
  };
  report(0.0);
  auto all = find_dark(body, options);
  report(0.4);
  all.push_back(find_metal(body, options));
  std::vector<StructureSurface> surfaces;
  for (const auto& found : all) {
    const double begin = 0.5 + 0.15 * static_cast<double>(surfaces.size());
    report(begin);
    if (found.mask.count() == 0) continue;
    const auto [box, inside] = cut_out(body, found);
    auto mesh = internal::marching_cubes(box, inside, found.threshold_hu);
    report(begin + 0.05);
    internal::finish_surface(
        mesh, box, {.num_triangles = options.num_triangles, .when_smooth = [&] {
                      report(begin + 0.1);
                    }});
    if (!mesh.empty()) surfaces.push_back({found.name, found.color, std::move(mesh)});
  }
  report(1.0);
  return surfaces;
}

}  // namespace mor
