// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/normal_equations.h"

#include <algorithm>
#include <array>

namespace mor::internal {
namespace {

/// Pairs are gathered in blocks, whose products are one small matrix multiplication each: sums in
/// float stay short, and their order is fixed.
constexpr int kBlock = 64;
/// Rows of a block: the six derivatives, the distance, 1.
using Block = Eigen::Matrix<float, 8, kBlock>;

class BlockSums {
 public:
  void add(const Eigen::Vector3f& lever,
           const Eigen::Vector3f& normal,
           float distance_mm,
           float weight) {
    auto column = rows_.col(count_);
    column.head<3>() = lever.cross(normal);
    column.segment<3>(3) = normal;
    column[6] = distance_mm;
    column[7] = 1.0F;
    weighted_.col(count_) = weight * column;
    ++num_pairs_;
    if (++count_ == kBlock) flush();
  }

  [[nodiscard]] NormalEquations finish() {
    rows_.rightCols(kBlock - count_).setZero();
    weighted_.rightCols(kBlock - count_).setZero();
    flush();
    NormalEquations equations;
    equations.information = sums_.topLeftCorner<6, 6>();
    equations.gradient = sums_.block<6, 1>(0, 6);
    equations.sum_weighted_sq = sums_(6, 6);
    equations.sum_weights = sums_(7, 7);
    equations.num_pairs = num_pairs_;
    return equations;
  }

 private:
  void flush() {
    const Eigen::Matrix<float, 8, 8> products = rows_.lazyProduct(weighted_.transpose());
    sums_ += products.cast<double>();
    count_ = 0;
  }

  Block rows_ = Block::Zero();
  Block weighted_ = Block::Zero();
  Eigen::Matrix<double, 8, 8> sums_ = Eigen::Matrix<double, 8, 8>::Zero();
  int count_ = 0;
  int num_pairs_ = 0;
};

/// Neighbours on either side whose distances are averaged, and how far apart they may be.
constexpr std::size_t kRowReach = 3;
constexpr float kRowReachMm = 30.0F;
/// Points whose nodes are asked of memory together, ahead of their use.
constexpr std::size_t kPrefetch = 32;

float tukey_weight(float distance_mm, float per_scale) {
  const float ratio = distance_mm * per_scale;
  const float rest = std::max(0.0F, 1.0F - ratio * ratio);
  return rest * rest;
}

}  // namespace

void Linearizer::find_pairs(const FieldLevel& level,
                            std::span<const SensorPoint> points,
                            const Eigen::Isometry3f& fixed_from_moving,
                            const PairingRule& rule) {
  const Eigen::Matrix3f rotation = fixed_from_moving.linear();
  const Eigen::Vector3f camera = fixed_from_moving.translation();
  const float per_above = 1.0F / rule.above_scale_mm;
  const float per_below = 1.0F / rule.below_scale_mm;
  pairs_.resize(points.size());
  distances_mm_.resize(points.size());
  std::array<const FieldNode*, kPrefetch> nodes{};
  std::array<Eigen::Vector3f, kPrefetch> offsets_mm;
  for (std::size_t first = 0; first < points.size(); first += kPrefetch) {
    const std::size_t count = std::min(kPrefetch, points.size() - first);
    for (std::size_t k = 0; k < count; ++k) {
      Pair& pair = pairs_[first + k];
      pair.p = rotation * points[first + k].point + camera;
      nodes[k] = level.nearest_node(pair.p, offsets_mm[k]);
      __builtin_prefetch(nodes[k]);
    }
    for (std::size_t k = 0; k < count; ++k) {
      const SensorPoint& moving = points[first + k];
      Pair& pair = pairs_[first + k];
      pair.weight = 0.0F;
      distances_mm_[first + k] = rule.above_scale_mm;
      if (nodes[k] == nullptr || nodes[k]->distance == FieldNode::kNoSurface) continue;
      pair.sample = nodes[k]->extended_by(offsets_mm[k]);
      const float distance_mm = pair.sample.distance_mm;
      distances_mm_[first + k] = std::clamp(distance_mm, -rule.below_scale_mm, rule.above_scale_mm);
      // The camera sees only what faces it: not the far side of a hand or head.
      const bool compatible =
          pair.sample.normal.dot(pair.p - camera) < 0.0F &&
          pair.sample.normal.dot(rotation * moving.normal) >= rule.min_normal_cosine;
      if (!compatible) continue;
      pair.weight =
          moving.weight * tukey_weight(distance_mm, distance_mm > 0.0F ? per_above : per_below);
    }
  }
}

void Linearizer::weigh_by_rows(std::span<const SensorPoint> points, float scale_mm) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (pairs_[i].weight <= 0.0F) continue;
    const std::size_t end = std::min(points.size(), i + kRowReach + 1);
    float sum = 0.0F;
    float count = 0.0F;
    for (std::size_t j = i - std::min(i, kRowReach); j < end; ++j) {
      const float apart_sq_mm2 = (points[j].point - points[i].point).squaredNorm();
      const float near = apart_sq_mm2 < kRowReachMm * kRowReachMm ? 1.0F : 0.0F;
      sum += near * distances_mm_[j];
      count += near;
    }
    pairs_[i].weight *= tukey_weight(sum / count, 1.0F / scale_mm);
  }
}

NormalEquations Linearizer::linearize(const FieldLevel& level,
                                      std::span<const SensorPoint> points,
                                      const Eigen::Isometry3d& fixed_from_moving,
                                      const Eigen::Vector3d& pivot,
                                      const PairingRule& rule) {
  find_pairs(level, points, fixed_from_moving.cast<float>(), rule);
  if (rule.row_scale_mm > 0.0F) weigh_by_rows(points, rule.row_scale_mm);
  const Eigen::Vector3f pivot_f = pivot.cast<float>();
  BlockSums sums;
  for (const Pair& pair : pairs_) {
    if (pair.weight <= 0.0F) continue;
    sums.add(pair.p - pivot_f, pair.sample.normal, pair.sample.distance_mm, pair.weight);
  }
  return sums.finish();
}

}  // namespace mor::internal
