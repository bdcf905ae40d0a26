// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/skin_change.h"

#include <cmath>
#include <utility>

namespace mor {

double SkinChange::at_mm(const Eigen::Vector3d& ct_mm) const {
  double sum_mm = 0.0;
  for (std::size_t i = 0; i < places_mm.size(); ++i) {
    const double apart_sq = (places_mm[i] - ct_mm).squaredNorm() / (reach_mm * reach_mm);
    sum_mm += weights_mm[i] * std::exp(-0.5 * apart_sq);
  }
  return sum_mm;
}

TriangleMesh SkinChange::applied_to(TriangleMesh skin) const {
  for (std::size_t i = 0; i < skin.vertices.size(); ++i) {
    const double out_mm = at_mm(skin.vertices[i].cast<double>());
    skin.vertices[i] += static_cast<float>(out_mm) * skin.normals[i];
  }
  skin.normals = vertex_normals(skin);
  return skin;
}

Result<std::shared_ptr<const FixedSurface>> skin_as_found(TriangleMesh skin, std::string words) {
  MOR_TRY(auto field, DistanceField::build(skin));
  return std::make_shared<const FixedSurface>(
      FixedSurface{std::move(skin), std::move(field), std::move(words)});
}

}  // namespace mor
