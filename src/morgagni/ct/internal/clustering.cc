// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/clustering.h"

#include <algorithm>
#include <numeric>
#include <random>
#include <utility>

namespace mor::internal {
namespace {

constexpr unsigned kSeed = 2008;
constexpr int kMaxRounds = 300;
constexpr int kMaxRepairs = 5;
/// A patch with less than this share of the wanted weight is a left-over between others.
constexpr double kSmallestPatch = 0.3;
/// At rest: fewer moves a round than this share of the vertices.
constexpr double kRestShare = 2e-5;

}  // namespace

Clustering::Clustering(const TriangleMesh& mesh, const MeshLinks& links, std::vector<float> weights)
    : mesh_(mesh),
      links_(links),
      weights_(std::move(weights)),
      middle_(mesh.bounds().center().cast<double>()),
      queued_at_(links.edges().size()),
      visited_at_(links.edges().size()) {}

void Clustering::start(std::uint32_t num_clusters) {
  cluster_.assign(mesh_.vertices.size(), kNoCluster);
  sums_.clear();
  grow_patches(num_clusters);
  scatter_seeds(num_clusters);
  queue_borders();
}

void Clustering::start(std::vector<std::uint32_t> cluster_of_vertex, std::uint32_t num_clusters) {
  cluster_.assign(mesh_.vertices.size(), kNoCluster);
  sums_.assign(num_clusters, Sum());
  for (std::uint32_t vertex = 0; vertex < cluster_.size(); ++vertex)
    if (cluster_of_vertex[vertex] != kNoCluster) move(vertex, cluster_of_vertex[vertex]);
  queue_borders();
}

void Clustering::grow_patches(std::uint32_t num_clusters) {
  const double total = std::accumulate(weights_.begin(), weights_.end(), 0.0);
  const double target = total / num_clusters;
  std::vector<std::uint32_t> seeds;
  for (std::uint32_t vertex = 0; vertex < cluster_.size(); ++vertex) {
    seeds.push_back(vertex);
    // First in, first out: patches lie against those that are there already.
    for (std::size_t i = 0; i < seeds.size() && sums_.size() < num_clusters; ++i)
      if (cluster_[seeds[i]] == kNoCluster) grow_patch(seeds[i], target, seeds);
    seeds.clear();
  }
}

bool Clustering::grow_patch(std::uint32_t seed, double target, std::vector<std::uint32_t>& seeds) {
  const auto cluster = static_cast<std::uint32_t>(sums_.size());
  sums_.emplace_back();
  std::vector<std::uint32_t> front = {seed};
  std::vector<std::uint32_t> taken;
  for (std::size_t i = 0; i < front.size() && sums_[cluster].weight < target; ++i) {
    const std::uint32_t vertex = front[i];
    if (cluster_[vertex] != kNoCluster) continue;
    move(vertex, cluster);
    taken.push_back(vertex);
    for (const auto edge : links_.edges_at(vertex))
      for (const auto other : links_.edges()[edge])
        if (cluster_[other] == kNoCluster) front.push_back(other);
  }
  if (sums_[cluster].weight < kSmallestPatch * target) {
    for (const auto vertex : taken) cluster_[vertex] = kNoCluster;
    sums_.pop_back();
    return false;
  }
  for (const auto vertex : front)
    if (cluster_[vertex] == kNoCluster) seeds.push_back(vertex);
  return true;
}

void Clustering::scatter_seeds(std::uint32_t num_clusters) {
  std::mt19937 random(kSeed);
  std::uniform_int_distribution<std::uint32_t> any(0,
                                                   static_cast<std::uint32_t>(cluster_.size()) - 1);
  const std::size_t max_tries = 20 * cluster_.size();
  for (std::size_t i = 0; i < max_tries && sums_.size() < num_clusters; ++i) {
    const std::uint32_t vertex = any(random);
    const std::uint32_t old = cluster_[vertex];
    if (old == kNoCluster || sums_[old].num_vertices < 2) continue;
    sums_.emplace_back();
    move(vertex, static_cast<std::uint32_t>(sums_.size() - 1));
  }
}

double Clustering::gain_with(const Sum& sum, std::uint32_t vertex, double sign) const {
  const double share = sign * weights_[vertex];
  const double weight = sum.weight + share;
  if (weight <= 0.0) return 0.0;
  const Eigen::Vector3d place =
      sum.place + share * (mesh_.vertices[vertex].cast<double>() - middle_);
  return place.squaredNorm() / weight;
}

void Clustering::move(std::uint32_t vertex, std::uint32_t to) {
  const std::uint32_t from = cluster_[vertex];
  const Eigen::Vector3d share =
      weights_[vertex] * (mesh_.vertices[vertex].cast<double>() - middle_);
  if (from != kNoCluster) {
    sums_[from].weight -= weights_[vertex];
    sums_[from].place -= share;
    --sums_[from].num_vertices;
    sums_[from].changed_at = round_;
  }
  cluster_[vertex] = to;
  if (to == kNoCluster) return;
  sums_[to].weight += weights_[vertex];
  sums_[to].place += share;
  ++sums_[to].num_vertices;
  sums_[to].changed_at = round_;
}

void Clustering::queue_edge(std::uint32_t edge) {
  if (queued_at_[edge] == round_) return;
  queued_at_[edge] = round_;
  next_queue_.push_back(edge);
}

void Clustering::queue_borders() {
  ++round_;
  next_queue_.clear();
  for (std::uint32_t edge = 0; edge < links_.edges().size(); ++edge) {
    const auto [a, b] = links_.edges()[edge];
    if (cluster_[a] != cluster_[b]) queue_edge(edge);
  }
  for (auto& sum : sums_) sum.changed_at = round_;
}

bool Clustering::may_leave(std::uint32_t vertex) const {
  // The vertex's neighbours in its own cluster must hang together without it: then they form one
  // arc of the ring around it, whose ends are the two triangles where the arc stops.
  int num_ends = 0;
  const std::uint32_t own = cluster_[vertex];
  for (const auto triangle : links_.triangles_at(vertex)) {
    int num_own = 0;
    for (const auto corner : mesh_.triangles[triangle])
      if (corner != vertex && cluster_[corner] == own) ++num_own;
    if (num_own == 1) ++num_ends;
  }
  return num_ends <= 2;
}

void Clustering::visit(std::uint32_t edge, bool keep_whole) {
  const auto [a, b] = links_.edges()[edge];
  const std::uint32_t k = cluster_[a];
  const std::uint32_t l = cluster_[b];
  if (k == l) return;
  queue_edge(edge);
  std::uint32_t mover = a;
  std::uint32_t to = l;
  if (k == kNoCluster || l == kNoCluster) {
    mover = k == kNoCluster ? a : b;
    to = k == kNoCluster ? l : k;
  } else {
    const std::uint32_t changed = std::max(sums_[k].changed_at, sums_[l].changed_at);
    if (changed < visited_at_[edge]) return;
    visited_at_[edge] = round_;
    const Sum& in_k = sums_[k];
    const Sum& in_l = sums_[l];
    constexpr double kLeast = 1e-9;
    double best = (in_k.gain() + in_l.gain()) * (1.0 + kLeast);
    to = kNoCluster;
    if (in_k.num_vertices > 1) {
      const double gain = gain_with(in_k, a, -1.0) + gain_with(in_l, a, 1.0);
      if (gain > best && (!keep_whole || may_leave(a))) {
        best = gain;
        to = l;
      }
    }
    if (in_l.num_vertices > 1) {
      const double gain = gain_with(in_k, b, 1.0) + gain_with(in_l, b, -1.0);
      if (gain > best && (!keep_whole || may_leave(b))) {
        mover = b;
        to = k;
      }
    }
    if (to == kNoCluster) return;
  }
  move(mover, to);
  ++num_moves_;
  for (const auto other : links_.edges_at(mover)) queue_edge(other);
}

void Clustering::rest(bool keep_whole, const std::function<void(double)>& report) {
  const auto enough = static_cast<std::size_t>(kRestShare * static_cast<double>(cluster_.size()));
  for (int i = 0; i < kMaxRounds && !next_queue_.empty(); ++i) {
    std::swap(queue_, next_queue_);
    next_queue_.clear();
    ++round_;
    num_moves_ = 0;
    for (const auto edge : queue_) visit(edge, keep_whole);
    if (num_moves_ <= enough) break;
    if (report) report(std::min(0.99, static_cast<double>(i) / kMaxRounds));
  }
}

bool Clustering::free_loose_pieces() {
  struct Piece {
    std::uint32_t first = kNoCluster;
    double weight = 0.0;
  };
  std::vector<Piece> heaviest(sums_.size());
  std::vector<std::uint32_t> piece_of(cluster_.size(), kNoCluster);
  std::vector<std::uint32_t> piece;
  for (std::uint32_t first = 0; first < cluster_.size(); ++first) {
    if (cluster_[first] == kNoCluster || piece_of[first] != kNoCluster) continue;
    piece.assign(1, first);
    piece_of[first] = first;
    double weight = 0.0;
    for (std::size_t i = 0; i < piece.size(); ++i) {
      weight += weights_[piece[i]];
      for (const auto edge : links_.edges_at(piece[i])) {
        for (const auto other : links_.edges()[edge]) {
          if (piece_of[other] != kNoCluster || cluster_[other] != cluster_[first]) continue;
          piece_of[other] = first;
          piece.push_back(other);
        }
      }
    }
    Piece& best = heaviest[cluster_[first]];
    if (best.first == kNoCluster || weight > best.weight) best = {first, weight};
  }
  bool freed = false;
  for (std::uint32_t vertex = 0; vertex < cluster_.size(); ++vertex) {
    if (cluster_[vertex] == kNoCluster || heaviest[cluster_[vertex]].first == piece_of[vertex])
      continue;
    move(vertex, kNoCluster);
    freed = true;
  }
  return freed;
}

void Clustering::minimize(const std::function<void(double)>& report) {
  rest(false, report);
  if (free_loose_pieces()) settle();
}

void Clustering::settle() {
  queue_borders();
  rest(true, {});
  for (int i = 0; i < kMaxRepairs && free_loose_pieces(); ++i) {
    queue_borders();
    rest(true, {});
  }
}

void Clustering::split(std::uint32_t cluster) {
  std::uint32_t farthest = kNoCluster;
  double farthest_sq = -1.0;
  const Eigen::Vector3d center = sums_[cluster].place / sums_[cluster].weight + middle_;
  for (std::uint32_t vertex = 0; vertex < cluster_.size(); ++vertex) {
    if (cluster_[vertex] != cluster) continue;
    const double distance_sq = (mesh_.vertices[vertex].cast<double>() - center).squaredNorm();
    if (distance_sq > farthest_sq) {
      farthest_sq = distance_sq;
      farthest = vertex;
    }
  }
  if (sums_[cluster].num_vertices < 2) return;
  sums_.emplace_back();
  move(farthest, static_cast<std::uint32_t>(sums_.size() - 1));
}

}  // namespace mor::internal
