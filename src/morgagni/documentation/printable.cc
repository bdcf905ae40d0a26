// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/printable.h"

#include <algorithm>
#include <cmath>

#include <spdlog/fmt/fmt.h>

#include "morgagni/documentation/internal/half_edges.h"
#include "morgagni/geometry/kd_tree.h"

namespace mor {
namespace {

constexpr double kThinnestWallMm = 0.5;
constexpr double kThickestWallMm = 20.0;
/// A wall stays inside of the largest ball that fits into the body there: so it neither comes out
/// on the other side nor folds.
constexpr float kShareOfBall = 0.8F;
constexpr float kThinShare = 0.9F;  ///< A wall below this share of what was asked for is thin.

/// Vertices where more than one fan of triangles ends.
std::size_t count_pinched(const TriangleMesh& mesh) {
  TriangleMesh copy = mesh;
  copy.normals.resize(copy.vertices.size(), Eigen::Vector3f::UnitZ());
  return internal::cut_pinched_vertices(copy);
}

Result<void> check_closable(const SolidCheck& check) {
  if (check.num_crowded_edges + check.num_turned_edges + check.num_empty_triangles == 0) return {};
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format(
          "the skin cannot be made printable: {} of its edges have more than two triangles, "
          "{} lie between triangles that face opposite ways, {} triangles are empty",
          check.num_crowded_edges,
          check.num_turned_edges,
          check.num_empty_triangles));
}

/// Offsets that change gently from vertex to vertex, and nowhere beyond `most`.
void smooth_offsets(const TriangleMesh& mesh, std::vector<float>& offset_mm) {
  constexpr int kRounds = 8;
  const std::vector<float> most_mm = offset_mm;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<float> sum = offset_mm;
    std::vector<float> count(offset_mm.size(), 1.0F);
    for (const auto& t : mesh.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        sum[t[k]] += offset_mm[t[(k + 1) % 3]];
        count[t[k]] += 1.0F;
      }
    }
    for (std::size_t i = 0; i < sum.size(); ++i)
      offset_mm[i] = std::min(most_mm[i], sum[i] / count[i]);
  }
}

/// Adds the inner side of the wall, and joins both along the rims.
void add_inner_wall(PrintableSolid& solid,
                    const std::vector<std::vector<std::uint32_t>>& rims,
                    const std::vector<float>& thickness_mm,
                    float wall_mm) {
  TriangleMesh& mesh = solid.mesh;
  const auto num_outer = static_cast<std::uint32_t>(mesh.vertices.size());
  std::vector<float> offset_mm(num_outer);
  for (std::size_t i = 0; i < num_outer; ++i)
    offset_mm[i] = std::min(wall_mm, kShareOfBall * 0.5F * thickness_mm[i]);
  smooth_offsets(mesh, offset_mm);
  for (std::size_t i = 0; i < num_outer; ++i) {
    const Eigen::Vector3f inner = mesh.vertices[i] - offset_mm[i] * mesh.normals[i];
    const Eigen::Vector3f normal = -mesh.normals[i];
    mesh.vertices.push_back(inner);
    mesh.normals.push_back(normal);
  }
  for (std::size_t t = 0; t < solid.num_skin_triangles; ++t) {
    const auto [a, b, c] = mesh.triangles[t];
    mesh.triangles.push_back({a + num_outer, c + num_outer, b + num_outer});
  }
  for (const auto& rim : rims) {
    for (std::size_t i = 0; i < rim.size(); ++i) {
      const auto a = rim[i];
      const auto b = rim[(i + 1) % rim.size()];
      mesh.triangles.push_back({b, a, a + num_outer});
      mesh.triangles.push_back({b, a + num_outer, b + num_outer});
    }
  }
  const auto num_thin = std::count_if(offset_mm.begin(), offset_mm.end(), [&](float offset) {
    return offset < kThinShare * wall_mm;
  });
  solid.thin_share = static_cast<double>(num_thin) / static_cast<double>(num_outer);
  std::nth_element(offset_mm.begin(),
                   offset_mm.begin() + static_cast<std::ptrdiff_t>(num_outer / 100),
                   offset_mm.end());
  solid.thinnest_mm = offset_mm[num_outer / 100];
}

void add_lids(PrintableSolid& solid, const std::vector<std::vector<std::uint32_t>>& rims) {
  for (const auto& rim : rims) {
    const internal::HalfEdges edges(solid.mesh.triangles);
    const auto lid = internal::lid_of(solid.mesh, rim, edges);
    solid.mesh.triangles.insert(solid.mesh.triangles.end(), lid.begin(), lid.end());
  }
}

float percentile_1(std::vector<float> values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 100);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

SolidCheck check_solid(const TriangleMesh& mesh) {
  SolidCheck check;
  const internal::HalfEdges edges(mesh.triangles);
  for (const auto& t : mesh.triangles) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) ++check.num_empty_triangles;
    for (std::size_t k = 0; k < 3; ++k) {
      const int same = edges.count(t[k], t[(k + 1) % 3]);
      const int opposite = edges.count(t[(k + 1) % 3], t[k]);
      if (same + opposite == 1) ++check.num_open_edges;
      if (same + opposite > 2) ++check.num_crowded_edges;
      if (same == 2 && opposite == 0) ++check.num_turned_edges;
    }
    const Eigen::Vector3d a = mesh.vertices[t[0]].cast<double>();
    const Eigen::Vector3d b = mesh.vertices[t[1]].cast<double>();
    const Eigen::Vector3d c = mesh.vertices[t[2]].cast<double>();
    check.volume_mm3 += a.dot(b.cross(c)) / 6.0;
  }
  check.num_pinched_vertices = count_pinched(mesh);
  return check;
}

Result<void> PrintOptions::check() const {
  if (wall_mm >= kThinnestWallMm && wall_mm <= kThickestWallMm) return {};
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format("wall_mm must be {} to {}, got {}", kThinnestWallMm, kThickestWallMm, wall_mm));
}

std::vector<float> local_thickness_mm(const TriangleMesh& skin, double most_mm) {
  constexpr int kMaxSteps = 20;
  constexpr float kCloseEnoughMm = 0.01F;
  const KdTree tree(skin.vertices);
  std::vector<float> thickness_mm(skin.vertices.size());
  for (std::size_t i = 0; i < skin.vertices.size(); ++i) {
    const Eigen::Vector3f& place = skin.vertices[i];
    const Eigen::Vector3f inward = -skin.normals[i];
    float radius_mm = 0.5F * static_cast<float>(most_mm);
    for (int step = 0; step < kMaxSteps; ++step) {
      const Eigen::Vector3f center = place + radius_mm * inward;
      const auto nearest = tree.nearest(center);
      if (std::sqrt(nearest.distance_sq_mm2) >= radius_mm - kCloseEnoughMm) break;
      // The ball that touches here and goes through the nearest place.
      const Eigen::Vector3f chord = skin.vertices[nearest.index] - place;
      const float across = 2.0F * chord.dot(inward);
      const float smaller = across > 0.0F ? chord.squaredNorm() / across : radius_mm;
      if (!(smaller < radius_mm - kCloseEnoughMm)) break;
      radius_mm = smaller;
    }
    thickness_mm[i] = 2.0F * radius_mm;
  }
  return thickness_mm;
}

Result<PrintableSolid> make_printable(const TriangleMesh& skin, const PrintOptions& options) {
  MOR_CHECK(options.check());
  PrintableSolid solid;
  solid.mesh = skin;
  solid.num_skin_triangles = skin.triangles.size();
  if (solid.mesh.normals.size() != solid.mesh.vertices.size())
    solid.mesh.normals = vertex_normals(solid.mesh);
  MOR_CHECK(check_closable(check_solid(solid.mesh)));
  internal::cut_pinched_vertices(solid.mesh);
  const auto rims = internal::find_rims(solid.mesh);
  solid.num_open_ends = rims.size();
  constexpr double kThickEnoughMm = 60.0;  // Thicker than any wall; keeps the search short.
  const auto thickness_mm = local_thickness_mm(solid.mesh, kThickEnoughMm);
  if (options.form == PrintForm::kShell) {
    add_inner_wall(solid, rims, thickness_mm, static_cast<float>(options.wall_mm));
  } else {
    add_lids(solid, rims);
    solid.thinnest_mm = percentile_1(thickness_mm);
  }
  const auto check = check_solid(solid.mesh);
  if (check.is_solid()) return solid;
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("the skin could not be closed for printing: {} edges stay open, {} "
                                "have more than two triangles, {} vertices are pinched, the volume "
                                "is {:.0f} mm^3",
                                check.num_open_edges,
                                check.num_crowded_edges,
                                check.num_pinched_vertices,
                                check.volume_mm3));
}

}  // namespace mor
