// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/distance_field.h"

#include <algorithm>

#include <spdlog/fmt/fmt.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include "morgagni/registration/internal/closest_point.h"
#include "morgagni/registration/internal/nearest_triangles.h"

namespace mor {
namespace {

constexpr float kCoarseSpacingMm = 6.0F;
constexpr float kCoarseBandMm = 90.0F;
constexpr float kFineSpacingMm = 2.0F;
constexpr float kFineBandMm = 12.0F;
/// Very large bodies get a wider spacing, so that building stays below 200 MB.
constexpr double kMaxGridNodes = 16e6;
constexpr float kMaxBodySideMm = 4000.0F;
/// Beyond an open border the nearest point of the surface lies on it, sideways: less than this
/// cosine between the surface's normal and the way there tells such points from those above it.
constexpr float kBorderCosine = 0.8F;

/// Edge i of a triangle lies opposite its corner i. Bit i: that edge belongs to one triangle only.
std::vector<std::uint8_t> find_border_edges(const TriangleMesh& mesh) {
  struct Edge {
    std::uint64_t key;
    std::uint32_t triangle;
    std::uint8_t bit;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint64_t a = mesh.triangles[t][(i + 1) % 3];
      const std::uint64_t b = mesh.triangles[t][(i + 2) % 3];
      edges.push_back(
          {(std::min(a, b) << 32U) | std::max(a, b), t, static_cast<std::uint8_t>(1U << i)});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.key < b.key; });
  std::vector<std::uint8_t> border(mesh.triangles.size(), 0);
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].key == edges[i].key) ++end;
    if (end == i + 1) border[edges[i].triangle] |= edges[i].bit;
    i = end;
  }
  return border;
}

class LevelBuilder {
 public:
  LevelBuilder(const TriangleMesh& mesh,
               const std::vector<std::uint8_t>& border_edges,
               float spacing_mm,
               float band_mm)
      : mesh_(mesh), border_edges_(border_edges), border_vertex_(mesh.vertices.size(), 0) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (std::size_t i = 0; i < 3; ++i) {
        if ((border_edges[t] >> i & 1U) == 0) continue;
        border_vertex_[mesh.triangles[t][(i + 1) % 3]] = 1;
        border_vertex_[mesh.triangles[t][(i + 2) % 3]] = 1;
      }
    }
    lay_out(spacing_mm, band_mm);
  }

  [[nodiscard]] FieldLevel build();

 private:
  void lay_out(float spacing_mm, float band_mm);
  void fill_brick(const internal::NearestTriangles& nearest,
                  std::size_t brick,
                  FieldNode* nodes) const;
  [[nodiscard]] FieldNode make_node(const Eigen::Vector3f& p, std::uint32_t triangle) const;
  [[nodiscard]] bool on_border(std::uint32_t triangle, const Eigen::Vector3f& weights) const;
  [[nodiscard]] std::array<int, 3> brick_corner(std::size_t brick) const;

  const TriangleMesh& mesh_;
  const std::vector<std::uint8_t>& border_edges_;
  std::vector<std::uint8_t> border_vertex_;
  FieldLevel level_;
};

void LevelBuilder::lay_out(float spacing_mm, float band_mm) {
  const Eigen::AlignedBox3f bounds = mesh_.bounds();
  const Eigen::Vector3f size_mm = bounds.sizes() + Eigen::Vector3f::Constant(2.0F * band_mm);
  const double num_nodes =
      size_mm.cast<double>().prod() / std::pow(static_cast<double>(spacing_mm), 3.0);
  level_.spacing_mm =
      spacing_mm * static_cast<float>(std::cbrt(std::max(1.0, num_nodes / kMaxGridNodes)));
  level_.band_mm = band_mm;
  level_.origin_mm = bounds.min() - Eigen::Vector3f::Constant(band_mm);
  for (int axis = 0; axis < 3; ++axis) {
    const int num_steps = static_cast<int>(std::ceil(size_mm[axis] / level_.spacing_mm)) + 1;
    level_.bricks[static_cast<std::size_t>(axis)] =
        (num_steps + FieldLevel::kBrickSide - 1) / FieldLevel::kBrickSide;
  }
}

std::array<int, 3> LevelBuilder::brick_corner(std::size_t brick) const {
  const int b = static_cast<int>(brick);
  return {b % level_.bricks[0] * FieldLevel::kBrickSide,
          b / level_.bricks[0] % level_.bricks[1] * FieldLevel::kBrickSide,
          b / (level_.bricks[0] * level_.bricks[1]) * FieldLevel::kBrickSide};
}

/// Whether the point with these weights lies on an edge or corner of the mesh's open border.
bool LevelBuilder::on_border(std::uint32_t triangle, const Eigen::Vector3f& weights) const {
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (weights[i] == 0.0F && (border_edges_[triangle] >> k & 1U) != 0) return true;
    if (weights[i] == 1.0F && border_vertex_[mesh_.triangles[triangle][k]] != 0) return true;
  }
  return false;
}

FieldNode LevelBuilder::make_node(const Eigen::Vector3f& p, std::uint32_t triangle) const {
  const auto& [a, b, c] = mesh_.triangles[triangle];
  const auto closest = internal::closest_point_on_triangle(
      p, mesh_.vertices[a], mesh_.vertices[b], mesh_.vertices[c]);
  const Eigen::Vector3f way = p - closest.point;
  const float distance_mm = way.norm();
  const Eigen::Vector3f smooth = closest.weights[0] * mesh_.normals[a] +
                                 closest.weights[1] * mesh_.normals[b] +
                                 closest.weights[2] * mesh_.normals[c];
  const float smooth_norm = smooth.norm();
  if (distance_mm > level_.band_mm || !(smooth_norm > 1e-6F)) return {};
  const Eigen::Vector3f normal = smooth / smooth_norm;
  // Inside a face its own normal tells the side exactly; on edges and corners that of the vertices
  // does (Baerentzen & Aanaes 2005).
  const Eigen::Vector3f face =
      (mesh_.vertices[b] - mesh_.vertices[a]).cross(mesh_.vertices[c] - mesh_.vertices[a]);
  const bool in_face = closest.weights.minCoeff() > 0.0F;
  const float side = way.dot(in_face ? face : normal);
  if (on_border(triangle, closest.weights) &&
      std::abs(way.dot(normal)) < kBorderCosine * distance_mm) {
    return {};
  }
  FieldNode node;
  node.distance = static_cast<std::int16_t>(
      std::lround(std::copysign(distance_mm, side) * FieldNode::kUnitsPerMm));
  for (int axis = 0; axis < 3; ++axis) {
    node.normal[static_cast<std::size_t>(axis)] =
        static_cast<std::int16_t>(std::lround(normal[axis] * FieldNode::kUnitsPerNormal));
  }
  return node;
}

void LevelBuilder::fill_brick(const internal::NearestTriangles& nearest,
                              std::size_t brick,
                              FieldNode* nodes) const {
  const auto [x0, y0, z0] = brick_corner(brick);
  for (int z = z0; z < z0 + FieldLevel::kBrickSide; ++z) {
    for (int y = y0; y < y0 + FieldLevel::kBrickSide; ++y) {
      for (int x = x0; x < x0 + FieldLevel::kBrickSide; ++x, ++nodes) {
        const std::uint32_t triangle = nearest.triangle(x, y, z);
        if (triangle == internal::NearestTriangles::kNone) continue;
        *nodes = make_node(nearest.position_mm(x, y, z), triangle);
      }
    }
  }
}

FieldLevel LevelBuilder::build() {
  const std::array<int, 3> size = {level_.bricks[0] * FieldLevel::kBrickSide,
                                   level_.bricks[1] * FieldLevel::kBrickSide,
                                   level_.bricks[2] * FieldLevel::kBrickSide};
  const internal::NearestTriangles nearest(
      mesh_, level_.origin_mm, size, level_.spacing_mm, level_.band_mm);
  const std::size_t num_bricks = static_cast<std::size_t>(level_.bricks[0]) *
                                 static_cast<std::size_t>(level_.bricks[1]) *
                                 static_cast<std::size_t>(level_.bricks[2]);
  std::vector<std::vector<FieldNode>> filled(num_bricks);
  tbb::parallel_for(std::size_t{0}, num_bricks, [&](std::size_t brick) {
    std::vector<FieldNode> nodes(FieldLevel::kBrickNodes);
    fill_brick(nearest, brick, nodes.data());
    const bool known = std::any_of(nodes.begin(), nodes.end(), [](const FieldNode& node) {
      return node.distance != FieldNode::kNoSurface;
    });
    if (known) filled[brick] = std::move(nodes);
  });
  level_.index.assign(num_bricks, 0);
  level_.nodes.assign(FieldLevel::kBrickNodes, FieldNode{});
  for (std::size_t brick = 0; brick < num_bricks; ++brick) {
    if (filled[brick].empty()) continue;
    level_.index[brick] = static_cast<std::uint32_t>(level_.nodes.size() / FieldLevel::kBrickNodes);
    level_.nodes.insert(level_.nodes.end(), filled[brick].begin(), filled[brick].end());
  }
  return std::move(level_);
}

Result<void> check_mesh(const TriangleMesh& mesh) {
  const auto bad = [](std::string message) {
    return make_error(ErrorCode::kInvalidArgument, std::move(message));
  };
  if (mesh.empty()) return bad("a distance field needs a surface, but the mesh has no triangles");
  if (mesh.normals.size() != mesh.vertices.size()) {
    return bad(fmt::format("a distance field needs a normal for each of the {} vertices, got {}",
                           mesh.vertices.size(),
                           mesh.normals.size()));
  }
  for (const auto& vertex : mesh.vertices) {
    if (!vertex.allFinite()) return bad("a distance field needs finite vertices");
  }
  for (const auto& triangle : mesh.triangles) {
    if (*std::max_element(triangle.begin(), triangle.end()) >= mesh.vertices.size()) {
      return bad("a triangle of the mesh names a vertex that does not exist");
    }
  }
  const float side_mm = mesh.bounds().sizes().maxCoeff();
  if (side_mm > kMaxBodySideMm) {
    return bad(fmt::format(
        "a distance field is for bodies up to {} mm, got {} mm", kMaxBodySideMm, side_mm));
  }
  return {};
}

}  // namespace

Result<DistanceField> DistanceField::build(const TriangleMesh& mesh) {
  MOR_CHECK(check_mesh(mesh));
  const std::vector<std::uint8_t> border_edges = find_border_edges(mesh);
  DistanceField field;
  tbb::parallel_invoke(
      [&] {
        field.coarse_ = LevelBuilder(mesh, border_edges, kCoarseSpacingMm, kCoarseBandMm).build();
      },
      [&] { field.fine_ = LevelBuilder(mesh, border_edges, kFineSpacingMm, kFineBandMm).build(); });
  return field;
}

}  // namespace mor
