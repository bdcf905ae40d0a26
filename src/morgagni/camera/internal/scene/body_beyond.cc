// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/scene/body_beyond.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>
#include <unordered_set>

#include "morgagni/camera/internal/scene/sweep.h"

namespace mor::internal {
namespace {

using Eigen::Vector3f;

/// Holes shorter around than this are gaps in the skin, not cuts.
constexpr float kLeastCutMm = 60.0F;
constexpr float kBroadMm = 280.0F;
constexpr float kHalfTurnRad = std::numbers::pi_v<float>;

float between(Draws& draw, double least, double most) {
  return static_cast<float>(draw(least, most));
}

float eased(float share) {
  const float s = std::clamp(share, 0.0F, 1.0F);
  return s * s * (3.0F - 2.0F * s);
}

BoundaryLoop measured(std::vector<Vector3f> points) {
  BoundaryLoop loop{std::move(points), 0.0F, Vector3f::Zero(), Vector3f::Zero()};
  for (const auto& p : loop.points) loop.center += p / static_cast<float>(loop.points.size());
  Vector3f area = Vector3f::Zero();
  for (std::size_t i = 0; i < loop.points.size(); ++i) {
    const Vector3f& a = loop.points[i];
    const Vector3f& b = loop.points[(i + 1) % loop.points.size()];
    loop.length_mm += (b - a).norm();
    area += (a - loop.center).cross(b - loop.center);
  }
  loop.outward = -area.normalized();
  return loop;
}

std::uint64_t edge_key(std::uint32_t from, std::uint32_t to) {
  return static_cast<std::uint64_t>(from) << 32U | to;
}

/// Half of the loop's extent along a direction.
float half_size_mm(const BoundaryLoop& loop, const Vector3f& direction) {
  float least = 0.0F;
  float most = 0.0F;
  for (const auto& p : loop.points) {
    const float at = (p - loop.center).dot(direction);
    least = std::min(least, at);
    most = std::max(most, at);
  }
  return 0.5F * (most - least);
}

/// A width and depth at a share of the way; between these it changes smoothly.
struct Waist {
  float way_mm;
  float half_u_mm;
  float half_v_mm;
};

/// Sections from the loop's own shape through the waists to a rounded end.
std::vector<Station> through_waists(const Vector3f& begin,
                                    const Vector3f& way,
                                    float blend_over_mm,
                                    const std::vector<Waist>& waists) {
  constexpr float kStepMm = 12.0F;
  std::vector<Station> stations;
  for (std::size_t i = 1; i < waists.size(); ++i) {
    const auto& from = waists[i - 1];
    const auto& to = waists[i];
    const int count = std::max(1, static_cast<int>((to.way_mm - from.way_mm) / kStepMm));
    for (int k = 1; k <= count; ++k) {
      const float share = static_cast<float>(k) / static_cast<float>(count);
      const float way_mm = std::lerp(from.way_mm, to.way_mm, share);
      stations.push_back({begin + way_mm * way,
                          std::lerp(from.half_u_mm, to.half_u_mm, eased(share)),
                          std::lerp(from.half_v_mm, to.half_v_mm, eased(share)),
                          eased(way_mm / blend_over_mm)});
    }
  }
  const auto& last = waists.back();
  constexpr int kCapRings = 8;
  const float cap_mm = std::min(last.half_u_mm, last.half_v_mm);
  for (int k = 1; k <= kCapRings; ++k) {
    const float angle_rad = 0.5F * kHalfTurnRad * static_cast<float>(k) / kCapRings;
    stations.push_back({begin + (last.way_mm + cap_mm * std::sin(angle_rad)) * way,
                        last.half_u_mm * std::cos(angle_rad),
                        last.half_v_mm * std::cos(angle_rad),
                        1.0F});
  }
  return stations;
}

void append(TriangleMesh& mesh, const TriangleMesh& other) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& [a, b, c] : other.triangles) {
    mesh.triangles.push_back({first + a, first + b, first + c});
  }
}

/// A cut that is none of the known ones: it goes on for a while and closes.
TriangleMesh stump(const BoundaryLoop& loop, Draws& draw) {
  const Vector3f u = loop.outward.unitOrthogonal();
  const Vector3f v = loop.outward.cross(u);
  const float half_u_mm = half_size_mm(loop, u);
  const float half_v_mm = half_size_mm(loop, v);
  const float size_mm = std::min(half_u_mm, half_v_mm);
  const float scale = between(draw, 0.75, 0.95);
  return sweep(loop.points,
               u,
               v,
               through_waists(loop.center,
                              loop.outward,
                              0.5F * size_mm,
                              {{0.0F, half_u_mm, half_v_mm},
                               {0.3F * size_mm, scale * half_u_mm, scale * half_v_mm}}));
}

}  // namespace

std::vector<BoundaryLoop> boundary_loops(const TriangleMesh& mesh, float least_length_mm) {
  std::unordered_set<std::uint64_t> edges;
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) edges.insert(edge_key(triangle[i], triangle[(i + 1) % 3]));
  }
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> next;
  std::vector<std::uint32_t> starts;
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto from = triangle[i];
      const auto to = triangle[(i + 1) % 3];
      if (edges.contains(edge_key(to, from))) continue;
      next[from].push_back(to);
      starts.push_back(from);
    }
  }
  std::vector<BoundaryLoop> loops;
  for (const auto start : starts) {
    std::vector<Vector3f> points;
    for (auto at = start; !next[at].empty();) {
      points.push_back(mesh.vertices[at]);
      const auto to = next[at].back();
      next[at].pop_back();
      at = to;
    }
    if (points.size() < 3) continue;
    auto loop = measured(std::move(points));
    if (loop.length_mm >= least_length_mm) loops.push_back(std::move(loop));
  }
  std::stable_sort(loops.begin(), loops.end(), [](const auto& a, const auto& b) {
    return a.length_mm > b.length_mm;
  });
  return loops;
}

BodyBeyond::BodyBeyond(const TriangleMesh& skin, float table_top_mm)
    : loops_(boundary_loops(skin, kLeastCutMm)),
      bounds_(skin.bounds()),
      table_top_mm_(table_top_mm) {}

/// Shoulders that narrow to a neck, a head, and the arms: raised, or as the seed has it.
TriangleMesh BodyBeyond::above_broad(const BoundaryLoop& loop, Draws& draw) const {
  const Vector3f way =
      Vector3f(between(draw, -0.15, 0.15), between(draw, -0.1, 0.15), 1.0F).normalized();
  const float half_u_mm = half_size_mm(loop, Vector3f::UnitX());
  const float half_v_mm = half_size_mm(loop, Vector3f::UnitY());
  const float neck_mm = between(draw, 55.0, 68.0);
  const float neck_way_mm = between(draw, 90.0, 130.0);
  const float head_u_mm = between(draw, 70.0, 82.0);
  const float head_v_mm = between(draw, 90.0, 104.0);
  TriangleMesh mesh = sweep(loop.points,
                            Vector3f::UnitX(),
                            Vector3f::UnitY(),
                            through_waists(loop.center,
                                           way,
                                           0.9F * neck_way_mm,
                                           {{0.0F, half_u_mm, half_v_mm},
                                            {neck_way_mm, neck_mm, neck_mm},
                                            {neck_way_mm + 35.0F, neck_mm, neck_mm},
                                            {neck_way_mm + 120.0F, head_u_mm, head_v_mm},
                                            {neck_way_mm + 190.0F, head_u_mm, head_v_mm}}));
  for (const float side : {-1.0F, 1.0F}) {
    const Vector3f shoulder =
        loop.center + Vector3f(0.62F * side * half_u_mm, between(draw, -20.0, 30.0), -25.0F);
    const float spread_rad = between(draw, 0.1, 0.9);
    const Vector3f out(side * std::sin(spread_rad), between(draw, 0.0, 0.25), std::cos(spread_rad));
    const Vector3f elbow = shoulder + between(draw, 230.0, 290.0) * out.normalized();
    const float radius_mm = between(draw, 46.0, 58.0);
    append(mesh, tube(shoulder, elbow, radius_mm, 0.75F * radius_mm));
    const Vector3f inward(-0.6F * side, between(draw, -0.1, 0.2), between(draw, 0.2, 0.9));
    const Vector3f wrist = elbow + between(draw, 200.0, 250.0) * inward.normalized();
    append(mesh, tube(elbow, wrist, 0.75F * radius_mm, 0.5F * radius_mm));
  }
  return mesh;
}

TriangleMesh BodyBeyond::below_broad(const BoundaryLoop& loop, Draws& draw) const {
  const float half_u_mm = half_size_mm(loop, Vector3f::UnitX());
  const float half_v_mm = half_size_mm(loop, Vector3f::UnitY());
  const float waist = between(draw, 0.88, 1.0);
  const float belly = between(draw, 0.75, 1.05);
  const float hip = between(draw, 1.0, 1.15);
  const float length_mm = between(draw, 260.0, 340.0);
  const Vector3f way(0.0F, 0.0F, -1.0F);
  TriangleMesh mesh =
      sweep(loop.points,
            Vector3f::UnitX(),
            Vector3f::UnitY(),
            through_waists(loop.center,
                           way,
                           140.0F,
                           {{0.0F, half_u_mm, half_v_mm},
                            {0.4F * length_mm, waist * half_u_mm, belly * half_v_mm},
                            {0.9F * length_mm, hip * half_u_mm, 0.85F * half_v_mm},
                            {length_mm, 0.95F * half_u_mm, 0.75F * half_v_mm}}));
  for (const float side : {-1.0F, 1.0F}) {
    const Vector3f groin =
        loop.center + Vector3f(0.5F * side * half_u_mm, 0.1F * half_v_mm, -length_mm);
    const Vector3f out(side * between(draw, 0.0, 0.25), 0.1F, -1.0F);
    const float radius_mm = 0.48F * half_u_mm;
    append(mesh,
           tube(groin,
                groin + between(draw, 300.0, 380.0) * out.normalized(),
                radius_mm,
                0.65F * radius_mm));
  }
  return mesh;
}

TriangleMesh BodyBeyond::below_head(const BoundaryLoop& loop, Draws& draw) const {
  const float half_u_mm = half_size_mm(loop, Vector3f::UnitX());
  const float half_v_mm = half_size_mm(loop, Vector3f::UnitY());
  const float jaw_mm = between(draw, 40.0, 70.0);
  const float neck_mm = between(draw, 52.0, 66.0);
  const float shoulder_mm = between(draw, 190.0, 225.0);
  const float chest_mm = between(draw, 95.0, 120.0);
  const Vector3f way =
      Vector3f(between(draw, -0.12, 0.12), between(draw, 0.0, 0.12), -1.0F).normalized();
  const float throat_mm = jaw_mm + between(draw, 45.0, 70.0);
  return sweep(loop.points,
               Vector3f::UnitX(),
               Vector3f::UnitY(),
               through_waists(loop.center,
                              way,
                              90.0F,
                              {{0.0F, half_u_mm, half_v_mm},
                               {jaw_mm, 0.92F * half_u_mm, 0.82F * half_v_mm},
                               {throat_mm, neck_mm, neck_mm},
                               {throat_mm + 40.0F, neck_mm + 4.0F, neck_mm},
                               {throat_mm + 120.0F, shoulder_mm, chest_mm},
                               {throat_mm + 330.0F, 0.92F * shoulder_mm, 1.1F * chest_mm}}));
}

PaintedMesh BodyBeyond::continued(Draws& draw) const {
  TriangleMesh mesh;
  const bool is_broad = bounds_.sizes().x() > kBroadMm;
  for (const auto& loop : loops_) {
    constexpr float kMostly = 0.8F;
    const bool is_large = loop.length_mm > 0.8F * (bounds_.sizes().x() + bounds_.sizes().y());
    const bool is_above = loop.outward.z() > kMostly;
    const bool is_below = loop.outward.z() < -kMostly;
    if (is_large && is_below) {
      append(mesh, is_broad ? below_broad(loop, draw) : below_head(loop, draw));
    } else if (is_large && is_above && is_broad) {
      append(mesh, above_broad(loop, draw));
    } else {
      append(mesh, stump(loop, draw));
    }
  }
  for (auto& p : mesh.vertices) p.y() = std::min(p.y(), table_top_mm_ - 0.5F);
  return painted_as_skin(std::move(mesh), static_cast<std::uint64_t>(draw(0.0, 1e9)));
}

}  // namespace mor::internal
