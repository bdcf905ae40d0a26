// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cassert>

#include <Eigen/Core>

namespace mor::internal {

/// The slopes of one equation: few of the unknowns have any.
struct SlopeRow {
  static constexpr std::size_t kMost = 40;

  void put(int at, double slope) {
    assert(count < kMost);
    index[count] = at;
    value[count++] = slope;
  }
  template <class Vector>
  void put_all(int first, const Eigen::MatrixBase<Vector>& slopes) {
    for (Eigen::Index i = 0; i < slopes.size(); ++i) put(first + static_cast<int>(i), slopes(i));
  }

  std::array<int, kMost> index{};
  std::array<double, kMost> value{};
  std::size_t count = 0;
};

/// The normal equations of a Gauss-Newton step: rows that say `off + slopes * step = 0`.
class Equations {
 public:
  explicit Equations(int size)
      : matrix_(Eigen::MatrixXd::Zero(size, size)), right_(Eigen::VectorXd::Zero(size)) {}

  /// @param weight  1 over the row's variance.
  void add(const SlopeRow& row, double off, double weight) {
    for (std::size_t i = 0; i < row.count; ++i) {
      const double weighted = weight * row.value[i];
      right_[row.index[i]] -= weighted * off;
      for (std::size_t k = 0; k < row.count; ++k) {
        matrix_(row.index[k], row.index[i]) += weighted * row.value[k];
      }
    }
  }

  /// One unknown is off by `off`, and believed to be within `sd`.
  void believe(int index, double off, double sd) {
    SlopeRow row;
    row.put(index, 1.0);
    add(row, off, 1.0 / (sd * sd));
  }

  [[nodiscard]] const Eigen::MatrixXd& matrix() const { return matrix_; }
  [[nodiscard]] const Eigen::VectorXd& right() const { return right_; }

 private:
  Eigen::MatrixXd matrix_;
  Eigen::VectorXd right_;
};

}  // namespace mor::internal
