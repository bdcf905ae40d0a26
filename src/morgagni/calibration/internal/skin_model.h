// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

namespace mor::internal {

/// How far the skin lies outside of where the CT has it: a smooth field of displacements along the
/// normal, fixed in the CT, trilinear between control points of a lattice. A body that has changed
/// since its CT errs like this, a sensor does not: its error is fixed in the picture.
class SkinModel {
 public:
  static constexpr std::size_t kNumTouched = 8;

  /// @param bounds_mm  Of the skin, frame ct.
  SkinModel(const Eigen::AlignedBox3d& bounds_mm, double spacing_mm);

  /// Makes the eight control points around a place take part. Before anything else is asked.
  void touch(const Eigen::Vector3d& ct_mm);
  /// Numbers them.
  void settle();

  [[nodiscard]] std::size_t size() const { return places_mm_.size(); }
  [[nodiscard]] const std::vector<Eigen::Vector3d>& places_mm() const { return places_mm_; }

  /// A smooth Gaussian process: of a standard deviation of 1 mm and the reach of its squared
  /// exponential.
  [[nodiscard]] Eigen::MatrixXd prior_covariance(double reach_mm) const;

  /// The control points around a place, in ascending order, and their shares.
  /// @return False where some of them do not take part.
  bool weights(const Eigen::Vector3d& ct_mm,
               std::array<std::uint16_t, kNumTouched>& index,
               std::array<float, kNumTouched>& share) const;

 private:
  [[nodiscard]] bool find_cell(const Eigen::Vector3d& ct_mm,
                               std::array<int, 3>& cell,
                               Eigen::Vector3d& in_cell) const;
  [[nodiscard]] std::size_t node_of(int x, int y, int z) const;

  Eigen::Vector3d origin_mm_;
  double spacing_mm_;
  std::array<int, 3> count_{};
  std::vector<std::int32_t> number_;  ///< Of a lattice node; -1: takes no part.
  std::vector<Eigen::Vector3d> places_mm_;
};

}  // namespace mor::internal
