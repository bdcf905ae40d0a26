// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/normal_equations.h"

#include <algorithm>
#include <vector>

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

/// A moving point in the CT with what the field says there.
struct Pair {
  Eigen::Vector3f p;
  FieldSample sample;
  float weight = 0.0F;  ///< 0: not a pair.
};

/// Neighbours on either side whose distances are averaged, and how far apart they may be.
constexpr std::size_t kRowReach = 3;
constexpr float kRowReachMm = 30.0F;

float tukey_weight(float distance_mm, float per_scale) {
  const float ratio = distance_mm * per_scale;
  const float rest = std::max(0.0F, 1.0F - ratio * ratio);
  return rest * rest;
}

/// The mean distance of point `i` and its neighbours.
float row_distance_mm(std::span<const SensorPoint> points,
                      std::span<const float> distances_mm,
                      std::size_t i) {
  const std::size_t end = std::min(points.size(), i + kRowReach + 1);
  float sum = 0.0F;
  float count = 0.0F;
  for (std::size_t j = i - std::min(i, kRowReach); j < end; ++j) {
    const float near =
        (points[j].point - points[i].point).squaredNorm() < kRowReachMm * kRowReachMm ? 1.0F : 0.0F;
    sum += near * distances_mm[j];
    count += near;
  }
  return sum / count;
}

}  // namespace

NormalEquations linearize(const FieldLevel& level,
                          std::span<const SensorPoint> points,
                          const Eigen::Isometry3d& fixed_from_moving,
                          const Eigen::Vector3d& pivot,
                          const PairingRule& rule) {
  const Eigen::Matrix3f rotation = fixed_from_moving.linear().cast<float>();
  const Eigen::Vector3f camera = fixed_from_moving.translation().cast<float>();
  const Eigen::Vector3f pivot_f = pivot.cast<float>();
  const float per_above = 1.0F / rule.above_scale_mm;
  const float per_below = 1.0F / rule.below_scale_mm;
  const bool by_rows = rule.row_scale_mm > 0.0F;
  std::vector<Pair> pairs;
  std::vector<float> distances_mm(by_rows ? points.size() : 0, rule.above_scale_mm);
  BlockSums sums;
  const auto pair_up = [&](const SensorPoint& moving, Pair& pair, float* row_distance) {
    const Eigen::Vector3f ray = rotation * moving.point;
    pair.p = ray + camera;
    pair.weight = 0.0F;
    if (!DistanceField::look_up(level, pair.p, pair.sample)) return;
    const float distance_mm = pair.sample.distance_mm;
    if (row_distance != nullptr) {
      *row_distance = std::clamp(distance_mm, -rule.below_scale_mm, rule.above_scale_mm);
    }
    // The camera sees only what faces it: not the far side of a hand or head.
    if (pair.sample.normal.dot(ray) >= 0.0F ||
        pair.sample.normal.dot(rotation * moving.normal) < rule.min_normal_cosine) {
      return;
    }
    pair.weight =
        moving.weight * tukey_weight(distance_mm, distance_mm > 0.0F ? per_above : per_below);
  };
  const auto add = [&](const Pair& pair, float weight) {
    if (weight > 0.0F) {
      sums.add(pair.p - pivot_f, pair.sample.normal, pair.sample.distance_mm, weight);
    }
  };
  if (!by_rows) {
    Pair pair;
    for (const SensorPoint& moving : points) {
      pair_up(moving, pair, nullptr);
      add(pair, pair.weight);
    }
    return sums.finish();
  }
  pairs.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) pair_up(points[i], pairs[i], &distances_mm[i]);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (pairs[i].weight <= 0.0F) continue;
    add(pairs[i],
        pairs[i].weight *
            tukey_weight(row_distance_mm(points, distances_mm, i), 1.0F / rule.row_scale_mm));
  }
  return sums.finish();
}

}  // namespace mor::internal
