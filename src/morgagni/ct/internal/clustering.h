// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "morgagni/ct/internal/mesh_links.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

inline constexpr std::uint32_t kNoCluster = std::numeric_limits<std::uint32_t>::max();

/// Parts a mesh's vertices into clusters that minimise
///   E = sum over clusters k, over vertices i of k: w_i |p_i - c_k|^2,  c_k = weighted mean of k
/// (Valette, Chassery, Prost 2008, equations 4 to 7). Only vertices at the border of two clusters
/// can lower it, so edges between clusters are visited until none gives anything.
class Clustering {
 public:
  /// @param weights  Of each vertex: its area times the wanted density.
  /// Keeps references: mesh and links must outlive it.
  Clustering(const TriangleMesh& mesh, const MeshLinks& links, std::vector<float> weights);

  /// Starts from `num_clusters` patches of about equal weight.
  void start(std::uint32_t num_clusters);
  /// Starts from what a coarser mesh's clustering gave each vertex.
  void start(std::vector<std::uint32_t> cluster_of_vertex, std::uint32_t num_clusters);

  /// Lowers the energy until it rests, with every cluster in one piece in the end.
  void minimize(const std::function<void(double)>& report);
  /// The same after split(), from where it stands.
  void settle();
  /// Makes a cluster of its own from the vertex of `cluster` farthest from its middle.
  void split(std::uint32_t cluster);

  [[nodiscard]] const std::vector<std::uint32_t>& cluster_of_vertex() const { return cluster_; }
  [[nodiscard]] std::uint32_t num_clusters() const {
    return static_cast<std::uint32_t>(sums_.size());
  }

 private:
  /// Sum of weights and of weighted places.
  struct Sum {
    double weight = 0.0;
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    std::uint32_t num_vertices = 0;
    std::uint32_t changed_at = 0;  ///< The round of its last change.

    /// What the cluster takes off the energy of all vertices about the origin.
    [[nodiscard]] double gain() const { return place.squaredNorm() / weight; }
  };

  void grow_patches(std::uint32_t num_clusters);
  bool grow_patch(std::uint32_t seed, double target, std::vector<std::uint32_t>& seeds);
  void scatter_seeds(std::uint32_t num_clusters);
  void rest(bool keep_whole, const std::function<void(double)>& report);
  void visit(std::uint32_t edge, bool keep_whole);
  void move(std::uint32_t vertex, std::uint32_t to);
  bool may_leave(std::uint32_t vertex) const;
  bool free_loose_pieces();
  void queue_borders();
  void queue_edge(std::uint32_t edge);
  [[nodiscard]] double gain_with(const Sum& sum, std::uint32_t vertex, double sign) const;

  const TriangleMesh& mesh_;
  const MeshLinks& links_;
  std::vector<float> weights_;
  Eigen::Vector3d middle_;  ///< Places are taken from here: small numbers keep their digits.
  std::vector<std::uint32_t> cluster_;
  std::vector<Sum> sums_;
  std::vector<std::uint32_t> queue_, next_queue_;
  std::vector<std::uint32_t> queued_at_, visited_at_;  ///< Rounds, per edge.
  std::uint32_t round_ = 1;
  std::size_t num_moves_ = 0;
};

}  // namespace mor::internal
