// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/internal/skin_model.h"

#include <cmath>

namespace mor::internal {
namespace {

constexpr std::int32_t kNone = -1;
/// Readings of the skin lie no farther from it.
constexpr double kMarginMm = 20.0;

}  // namespace

SkinModel::SkinModel(const Eigen::AlignedBox3d& bounds_mm, double spacing_mm)
    : origin_mm_(bounds_mm.min() - Eigen::Vector3d::Constant(kMarginMm)), spacing_mm_(spacing_mm) {
  const Eigen::Vector3d size_mm = bounds_mm.sizes() + Eigen::Vector3d::Constant(2.0 * kMarginMm);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    count_[axis] =
        static_cast<int>(std::ceil(size_mm[static_cast<Eigen::Index>(axis)] / spacing_mm_)) + 2;
  }
  number_.assign(static_cast<std::size_t>(count_[0]) * static_cast<std::size_t>(count_[1]) *
                     static_cast<std::size_t>(count_[2]),
                 kNone);
}

std::size_t SkinModel::node_of(int x, int y, int z) const {
  return (static_cast<std::size_t>(z) * static_cast<std::size_t>(count_[1]) +
          static_cast<std::size_t>(y)) *
             static_cast<std::size_t>(count_[0]) +
         static_cast<std::size_t>(x);
}

bool SkinModel::find_cell(const Eigen::Vector3d& ct_mm,
                          std::array<int, 3>& cell,
                          Eigen::Vector3d& in_cell) const {
  const Eigen::Vector3d at = (ct_mm - origin_mm_) / spacing_mm_;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double value = at[static_cast<Eigen::Index>(axis)];
    // Written so that NaN is outside.
    if (!(value >= 0.0 && value < count_[axis] - 1)) return false;
    cell[axis] = static_cast<int>(value);
    in_cell[static_cast<Eigen::Index>(axis)] = value - cell[axis];
  }
  return true;
}

void SkinModel::touch(const Eigen::Vector3d& ct_mm) {
  std::array<int, 3> cell{};
  Eigen::Vector3d in_cell;
  if (!find_cell(ct_mm, cell, in_cell)) return;
  for (int corner = 0; corner < 8; ++corner) {
    number_[node_of(
        cell[0] + (corner & 1), cell[1] + ((corner >> 1) & 1), cell[2] + (corner >> 2))] = 0;
  }
}

void SkinModel::settle() {
  places_mm_.clear();
  for (int z = 0; z < count_[2]; ++z) {
    for (int y = 0; y < count_[1]; ++y) {
      for (int x = 0; x < count_[0]; ++x) {
        auto& number = number_[node_of(x, y, z)];
        if (number == kNone) continue;
        number = static_cast<std::int32_t>(places_mm_.size());
        places_mm_.emplace_back(origin_mm_ + spacing_mm_ * Eigen::Vector3d(x, y, z));
      }
    }
  }
}

Eigen::MatrixXd SkinModel::prior_covariance(double reach_mm) const {
  const auto nodes = static_cast<Eigen::Index>(size());
  Eigen::MatrixXd covariance(nodes, nodes);
  for (Eigen::Index i = 0; i < nodes; ++i) {
    for (Eigen::Index k = 0; k < nodes; ++k) {
      const double apart_sq =
          (places_mm_[static_cast<std::size_t>(i)] - places_mm_[static_cast<std::size_t>(k)])
              .squaredNorm();
      covariance(i, k) = std::exp(-0.5 * apart_sq / (reach_mm * reach_mm));
    }
  }
  covariance.diagonal().array() += 1e-3;
  return covariance;
}

bool SkinModel::weights(const Eigen::Vector3d& ct_mm,
                        std::array<std::uint16_t, kNumTouched>& index,
                        std::array<float, kNumTouched>& share) const {
  std::array<int, 3> cell{};
  Eigen::Vector3d in_cell;
  if (!find_cell(ct_mm, cell, in_cell)) return false;
  for (int corner = 0; corner < 8; ++corner) {
    const int x = corner & 1;
    const int y = (corner >> 1) & 1;
    const int z = corner >> 2;
    const std::int32_t number = number_[node_of(cell[0] + x, cell[1] + y, cell[2] + z)];
    if (number == kNone) return false;
    const auto i = static_cast<std::size_t>(corner);
    index[i] = static_cast<std::uint16_t>(number);
    share[i] = static_cast<float>((x == 1 ? in_cell.x() : 1.0 - in_cell.x()) *
                                  (y == 1 ? in_cell.y() : 1.0 - in_cell.y()) *
                                  (z == 1 ? in_cell.z() : 1.0 - in_cell.z()));
  }
  return true;
}

}  // namespace mor::internal
