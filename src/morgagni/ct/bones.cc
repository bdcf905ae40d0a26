// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <string>
#include <utility>

#include "morgagni/ct/internal/bit_mask.h"
#include "morgagni/ct/internal/components.h"
#include "morgagni/ct/internal/marching_cubes.h"
#include "morgagni/ct/internal/surface_finish.h"
#include "morgagni/ct/surfaces.h"

namespace mor {
namespace {

internal::BitMask without_islands(const internal::BitMask& mask,
                                  const Volume& volume,
                                  double min_component_mm3) {
  const internal::Components parts(mask);
  const double voxel_mm3 = volume.spacing_mm.prod();
  return parts.select([&](std::size_t i) {
    return static_cast<double>(parts.parts()[i].num_voxels) * voxel_mm3 >= min_component_mm3;
  });
}

/// Bone with its marrow: the hollows inside are not seen, and would take most of the triangles.
internal::BitMask solid(const internal::BitMask& bone, const Eigen::Vector3d& spacing_mm) {
  constexpr double kClosingMm = 2.0;
  auto hollow = internal::closed(bone, kClosingMm, spacing_mm);
  hollow.invert();
  const internal::Components parts(hollow);
  auto result = parts.select([&](std::size_t i) { return parts.parts()[i].at_side; });
  result.invert();
  return result;
}

}  // namespace

Result<void> BoneOptions::check() const {
  const auto refuse = [](const std::string& sentence) {
    return make_error(ErrorCode::kInvalidArgument, sentence);
  };
  if (!(threshold_hu > -1024.0 && threshold_hu <= 3071.0))
    return refuse("bone threshold_hu must be in (-1024, 3071], got " +
                  std::to_string(threshold_hu));
  if (!(min_component_mm3 >= 0.0))
    return refuse("min_component_mm3 must be 0 or more, got " + std::to_string(min_component_mm3));
  if (num_triangles < 100 || num_triangles > 5000000)
    return refuse("num_triangles must be in [100, 5000000], got " + std::to_string(num_triangles));
  return {};
}

Result<TriangleMesh> extract_bone(const Volume& body,
                                  const BoneOptions& options,
                                  const Progress& progress) {
  constexpr double kHighestHu = 32767.0;
  constexpr const char* kStage = "bones";
  MOR_CHECK(options.check());
  const auto report = [&](double fraction) {
    if (progress) progress(kStage, fraction);
  };
  report(0.0);
  auto bone = internal::threshold(body, options.threshold_hu, kHighestHu);
  bone = solid(without_islands(bone, body, options.min_component_mm3), body.spacing_mm);
  report(0.3);
  TriangleMesh mesh = internal::marching_cubes(body, bone, options.threshold_hu);
  report(0.5);
  internal::finish_surface(
      mesh, body, {.num_triangles = options.num_triangles, .when_smooth = [&] { report(0.7); }});
  report(1.0);
  return mesh;
}

}  // namespace mor
