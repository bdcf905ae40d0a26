// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/internal/half_edges.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace mor::internal {
namespace {

/// The triangles at a vertex: (triangle, which of its corners).
using Fan = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

std::vector<Fan> fans_of(const TriangleMesh& mesh) {
  std::vector<Fan> fans(mesh.vertices.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t k = 0; k < 3; ++k) fans[mesh.triangles[t][k]].push_back({t, k});
  }
  return fans;
}

/// Which of a vertex's triangles hang together over edges: a number for each.
std::vector<std::size_t> groups_of(const TriangleMesh& mesh, const Fan& fan) {
  std::vector<std::size_t> group(fan.size());
  std::iota(group.begin(), group.end(), 0);
  const auto neighbors = [&](std::size_t i) {
    const auto [t, k] = fan[i];
    return std::pair{mesh.triangles[t][(k + 1) % 3], mesh.triangles[t][(k + 2) % 3]};
  };
  for (std::size_t i = 0; i < fan.size(); ++i) {
    for (std::size_t j = i + 1; j < fan.size(); ++j) {
      const auto [a, b] = neighbors(i);
      const auto [c, d] = neighbors(j);
      if (a != c && a != d && b != c && b != d) continue;
      const std::size_t from = std::max(group[i], group[j]);
      const std::size_t to = std::min(group[i], group[j]);
      std::replace(group.begin(), group.end(), from, to);
    }
  }
  return group;
}

float cross(const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// A rim laid into its mean plane, counter-clockwise.
class EarCutter {
 public:
  EarCutter(const TriangleMesh& mesh, std::vector<std::uint32_t> ring, const HalfEdges& edges)
      : ring_(std::move(ring)), edges_(edges) {
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // Newell's.
    for (std::size_t i = 0; i < ring_.size(); ++i)
      normal += mesh.vertices[ring_[i]].cross(mesh.vertices[ring_[(i + 1) % ring_.size()]]);
    normal.stableNormalize();
    const Eigen::Vector3f across = normal.unitOrthogonal();
    const Eigen::Vector3f up = normal.cross(across);
    for (const auto vertex : ring_)
      places_.emplace_back(mesh.vertices[vertex].dot(across), mesh.vertices[vertex].dot(up));
  }

  std::vector<Triangle> cut() {
    std::vector<Triangle> lid;
    while (ring_.size() > 3) {
      const std::size_t ear = best_ear();
      lid.push_back({ring_[before(ear)], ring_[ear], ring_[after(ear)]});
      ring_.erase(ring_.begin() + static_cast<std::ptrdiff_t>(ear));
      places_.erase(places_.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    lid.push_back({ring_[0], ring_[1], ring_[2]});
    return lid;
  }

 private:
  std::size_t before(std::size_t i) const { return (i + ring_.size() - 1) % ring_.size(); }
  std::size_t after(std::size_t i) const { return (i + 1) % ring_.size(); }

  /// Twice the area over the squared longest side: 0 for none, larger for better triangles.
  float shape(std::size_t i) const {
    const auto& a = places_[before(i)];
    const auto& b = places_[i];
    const auto& c = places_[after(i)];
    const float longest =
        std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    return longest > 0.0F ? cross(b - a, c - b) / longest : 0.0F;
  }

  bool is_free(std::size_t i) const {
    const auto& a = places_[before(i)];
    const auto& b = places_[i];
    const auto& c = places_[after(i)];
    for (std::size_t j = 0; j < ring_.size(); ++j) {
      if (j == i || j == before(i) || j == after(i)) continue;
      const auto& p = places_[j];
      if (cross(b - a, p - a) >= 0.0F && cross(c - b, p - b) >= 0.0F && cross(a - c, p - c) >= 0.0F)
        return false;
    }
    return true;
  }

  /// The best shaped ear; where the rim crosses itself in its plane, the best corner there is.
  std::size_t best_ear() const {
    std::size_t best = 0;
    std::array<float, 2> best_score{-2.0F, -2.0F};
    for (std::size_t i = 0; i < ring_.size(); ++i) {
      const float quality = shape(i);
      const bool makes_new_edge = !edges_.has_edge(ring_[before(i)], ring_[after(i)]);
      const float rank = makes_new_edge && quality > 0.0F && is_free(i) ? 2.0F
                         : makes_new_edge                               ? 1.0F
                                                                        : 0.0F;
      if (std::array<float, 2> score{rank, quality}; score > best_score) {
        best_score = score;
        best = i;
      }
    }
    return best;
  }

  std::vector<std::uint32_t> ring_;
  std::vector<Eigen::Vector2f> places_;
  const HalfEdges& edges_;
};

}  // namespace

HalfEdges::HalfEdges(const std::vector<Triangle>& triangles) {
  counts_.reserve(triangles.size() * 3);
  for (const auto& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++counts_[key(t[k], t[(k + 1) % 3])];
  }
}

std::size_t cut_pinched_vertices(TriangleMesh& mesh) {
  const std::size_t before = mesh.vertices.size();
  const auto fans = fans_of(mesh);
  for (std::size_t vertex = 0; vertex < before; ++vertex) {
    const auto groups = groups_of(mesh, fans[vertex]);
    std::unordered_map<std::size_t, std::uint32_t> vertex_of_group;
    for (std::size_t i = 0; i < groups.size(); ++i) {
      if (groups[i] == groups.front()) continue;
      const auto [found, is_new] =
          vertex_of_group.try_emplace(groups[i], static_cast<std::uint32_t>(mesh.vertices.size()));
      if (is_new) {
        const Eigen::Vector3f place = mesh.vertices[vertex];
        const Eigen::Vector3f normal = mesh.normals[vertex];
        mesh.vertices.push_back(place);
        mesh.normals.push_back(normal);
      }
      mesh.triangles[fans[vertex][i].first][fans[vertex][i].second] = found->second;
    }
  }
  return mesh.vertices.size() - before;
}

std::vector<std::vector<std::uint32_t>> find_rims(const TriangleMesh& mesh) {
  const HalfEdges edges(mesh.triangles);
  std::unordered_map<std::uint32_t, std::uint32_t> next;
  std::vector<std::uint32_t> starts;
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = t[k];
      const auto b = t[(k + 1) % 3];
      if (edges.count(b, a) > 0) continue;
      next[a] = b;
      starts.push_back(a);
    }
  }
  std::vector<std::vector<std::uint32_t>> rims;
  for (const auto start : starts) {
    std::vector<std::uint32_t> rim;
    for (auto found = next.find(start); found != next.end(); found = next.find(rim.back())) {
      if (rim.empty()) rim.push_back(start);
      rim.push_back(found->second);
      next.erase(found);
    }
    if (rim.size() > 3 && rim.front() == rim.back()) {
      rim.pop_back();
      rims.push_back(std::move(rim));
    }
  }
  return rims;
}

std::vector<Triangle> lid_of(const TriangleMesh& mesh,
                             const std::vector<std::uint32_t>& rim,
                             const HalfEdges& edges) {
  // The lid runs against the triangles at the rim.
  return EarCutter(mesh, {rim.rbegin(), rim.rend()}, edges).cut();
}

}  // namespace mor::internal
