// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/normal_equations.h"

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

}  // namespace

NormalEquations linearize(const FieldLevel& level,
                          std::span<const SensorPoint> points,
                          const Eigen::Isometry3d& fixed_from_moving,
                          const Eigen::Vector3d& pivot,
                          const PairingRule& rule) {
  const Eigen::Matrix3f rotation = fixed_from_moving.linear().cast<float>();
  const Eigen::Vector3f camera = fixed_from_moving.translation().cast<float>();
  const Eigen::Vector3f pivot_f = pivot.cast<float>();
  const float per_outside = 1.0F / rule.outside_scale_mm;
  const float per_inside = 1.0F / rule.inside_scale_mm;
  BlockSums sums;
  FieldSample sample;
  for (const SensorPoint& moving : points) {
    const Eigen::Vector3f ray = rotation * moving.point;
    const Eigen::Vector3f p = ray + camera;
    if (!DistanceField::look_up(level, p, sample)) continue;
    const float ratio = sample.distance_mm * (sample.distance_mm > 0.0F ? per_outside : per_inside);
    const float rest = 1.0F - ratio * ratio;
    if (rest <= 0.0F) continue;
    const float cosine = sample.normal.dot(rotation * moving.normal);
    // The camera sees only what faces it: not the far side of a hand or head.
    if (cosine < rule.min_normal_cosine || sample.normal.dot(ray) >= 0.0F) continue;
    sums.add(p - pivot_f, sample.normal, sample.distance_mm, moving.weight * rest * rest);
  }
  return sums.finish();
}

}  // namespace mor::internal
