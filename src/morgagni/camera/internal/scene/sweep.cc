// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/scene/sweep.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>

#include <Eigen/Geometry>

namespace mor::internal {
namespace {

using Eigen::Vector3f;

constexpr std::size_t kAround = 96;
constexpr float kTurnRad = 2.0F * std::numbers::pi_v<float>;

/// `kAround` points at even steps along a closed line.
std::vector<Vector3f> resampled(const std::vector<Vector3f>& line) {
  std::vector<float> way_mm = {0.0F};
  for (std::size_t i = 0; i < line.size(); ++i) {
    way_mm.push_back(way_mm.back() + (line[(i + 1) % line.size()] - line[i]).norm());
  }
  std::vector<Vector3f> even;
  std::size_t segment = 0;
  for (std::size_t i = 0; i < kAround; ++i) {
    const float at_mm = way_mm.back() * static_cast<float>(i) / static_cast<float>(kAround);
    while (segment + 1 < line.size() && way_mm[segment + 1] <= at_mm) ++segment;
    const float length_mm = std::max(way_mm[segment + 1] - way_mm[segment], 1e-6F);
    const float share = (at_mm - way_mm[segment]) / length_mm;
    even.emplace_back(line[segment] + share * (line[(segment + 1) % line.size()] - line[segment]));
  }
  return even;
}

/// The angle at which the first point should sit on the ellipse so that the others twist least.
/// `turn` is +1 or -1, the way the line runs.
float first_angle_rad(const std::vector<Vector3f>& line,
                      const Vector3f& center,
                      const Vector3f& u,
                      const Vector3f& v,
                      float turn) {
  std::complex<float> sum = 0.0F;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vector3f p = line[i] - center;
    const float even_rad = turn * kTurnRad * static_cast<float>(i) / static_cast<float>(kAround);
    sum += std::complex<float>(p.dot(u), p.dot(v)) * std::polar(1.0F, -even_rad);
  }
  return std::arg(sum);
}

float signed_area(const std::vector<Vector3f>& line, const Vector3f& u, const Vector3f& v) {
  float area = 0.0F;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vector3f& a = line[i];
    const Vector3f& b = line[(i + 1) % line.size()];
    area += a.dot(u) * b.dot(v) - a.dot(v) * b.dot(u);
  }
  return area;
}

}  // namespace

TriangleMesh sweep(const std::vector<Vector3f>& start,
                   const Vector3f& u,
                   const Vector3f& v,
                   const std::vector<Station>& stations) {
  TriangleMesh mesh;
  mesh.vertices = resampled(start);
  const std::vector<Vector3f> first = mesh.vertices;
  Vector3f center = Vector3f::Zero();
  for (const auto& p : first) center += p / static_cast<float>(kAround);
  const float turn = signed_area(first, u, v) < 0.0F ? -1.0F : 1.0F;
  const float begin_rad = first_angle_rad(first, center, u, v, turn);
  for (const auto& station : stations) {
    const auto before = static_cast<std::uint32_t>(mesh.vertices.size() - kAround);
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const float angle_rad =
          begin_rad + turn * kTurnRad * static_cast<float>(i) / static_cast<float>(kAround);
      const Vector3f on_ellipse = station.center + station.half_u_mm * std::cos(angle_rad) * u +
                                  station.half_v_mm * std::sin(angle_rad) * v;
      const Vector3f as_first = first[i] - center + station.center;
      mesh.vertices.emplace_back(as_first + station.blend * (on_ellipse - as_first));
      const std::uint32_t next = (i + 1) % kAround;
      const auto after = before + static_cast<std::uint32_t>(kAround);
      mesh.triangles.push_back({before + next, before + i, after + i});
      mesh.triangles.push_back({before + next, after + i, after + next});
    }
  }
  return mesh;
}

TriangleMesh tube(const Vector3f& begin,
                  const Vector3f& end,
                  float begin_radius_mm,
                  float end_radius_mm) {
  constexpr int kRings = 16;
  constexpr int kCapRings = 6;
  const Vector3f along = (end - begin).normalized();
  const Vector3f u = along.unitOrthogonal();
  const Vector3f v = along.cross(u);
  std::vector<Vector3f> start;
  for (std::size_t i = 0; i < kAround; ++i) {
    const float angle_rad = -kTurnRad * static_cast<float>(i) / static_cast<float>(kAround);
    start.emplace_back(begin +
                       begin_radius_mm * (std::cos(angle_rad) * u + std::sin(angle_rad) * v));
  }
  std::vector<Station> stations;
  for (int i = 1; i <= kRings; ++i) {
    const float share = static_cast<float>(i) / kRings;
    const float radius_mm = std::lerp(begin_radius_mm, end_radius_mm, share);
    stations.push_back({begin + share * (end - begin), radius_mm, radius_mm, 1.0F});
  }
  for (int i = 1; i <= kCapRings; ++i) {
    const float angle_rad = 0.25F * kTurnRad * static_cast<float>(i) / kCapRings;
    const float radius_mm = end_radius_mm * std::cos(angle_rad);
    stations.push_back(
        {end + end_radius_mm * std::sin(angle_rad) * along, radius_mm, radius_mm, 1.0F});
  }
  return sweep(start, u, v, stations);
}

}  // namespace mor::internal
