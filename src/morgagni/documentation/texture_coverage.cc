// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/texture_coverage.h"

#include <cmath>
#include <utility>

#include "morgagni/documentation/internal/far_view.h"
#include "morgagni/documentation/internal/skin_charts.h"
#include "morgagni/documentation/internal/texel_map.h"
#include "morgagni/geometry/depth_raster.h"

namespace mor {
namespace {

constexpr float kLeastCosine = 0.342F;  ///< 70 degrees.
constexpr int kViewPx = 384;

std::vector<bool> reachable_triangles(const TriangleMesh& mesh) {
  std::vector<bool> is_reachable(mesh.triangles.size(), false);
  const auto normals = internal::triangle_normals(mesh);
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const Eigen::Vector3d from = Eigen::Vector3d(x, y, z).normalized();
        const internal::FarView view(mesh.bounds(), from, kViewPx, kViewPx);
        const auto raster = rasterize_depth(mesh, view.camera, view.view_from_ct);
        const Eigen::Vector3f towards = from.cast<float>();
        for (std::size_t i = 0; i < raster.triangle_idx.size(); ++i) {
          const auto triangle = raster.triangle_idx.data()[i];
          if (triangle == DepthRaster::kNothing) continue;
          if (normals[triangle].dot(towards) >= kLeastCosine) is_reachable[triangle] = true;
        }
      }
    }
  }
  return is_reachable;
}

}  // namespace

SkinCoverage::SkinCoverage(std::shared_ptr<const SkinAtlas> atlas)
    : atlas_(std::move(atlas)), is_reachable_(reachable_triangles(atlas_->mesh)) {
  const auto& mesh = atlas_->mesh;
  const auto texels = internal::texels_of(*atlas_);
  std::vector<std::uint32_t> count(mesh.triangles.size(), 0);
  for (const auto& texel : texels) ++count[texel.triangle];
  for (const auto& texel : texels) {
    if (!is_reachable_[texel.triangle]) continue;
    const auto& [a, b, c] = mesh.triangles[texel.triangle];
    const float area_mm2 =
        0.5F *
        (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]).norm();
    places_.push_back({texel.pixel, area_mm2 / static_cast<float>(count[texel.triangle])});
    area_mm2_ += static_cast<double>(places_.back().area_mm2);
  }
}

double SkinCoverage::share(const SkinTexture& texture) const {
  if (area_mm2_ <= 0.0) return 0.0;
  double seen_mm2 = 0.0;
  for (const auto& place : places_) {
    if (texture.sources.data()[place.pixel].frame == TexelSource::kNeverSeen) continue;
    seen_mm2 += static_cast<double>(place.area_mm2);
  }
  return seen_mm2 / area_mm2_;
}

}  // namespace mor
