// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/balanced_kd_tree.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include <Eigen/Geometry>

namespace mor::internal {
namespace {

/// Nodes below the first child of the root of a complete tree with `count` >= 1 nodes.
std::size_t first_child_size(std::size_t count) {
  const std::size_t last_level = std::bit_floor(count);  // Room on the level of the last node.
  const std::size_t above = last_level - 1;
  const std::size_t on_last_level = count - above;
  return above / 2 + std::min(on_last_level, last_level / 2);
}

class Builder {
 public:
  Builder(std::span<const Eigen::Vector3f> points, BalancedKdTree& tree)
      : points_(points), tree_(tree), indices_(points.size()) {
    std::iota(indices_.begin(), indices_.end(), std::uint32_t{0});
    place(0, indices_);
  }

 private:
  void place(std::size_t node, std::span<std::uint32_t> below) {
    if (below.empty()) return;
    const std::uint8_t axis = widest_axis(below);
    const std::size_t middle = first_child_size(below.size());
    std::nth_element(
        below.begin(),
        below.begin() + static_cast<std::ptrdiff_t>(middle),
        below.end(),
        [&](std::uint32_t a, std::uint32_t b) { return points_[a][axis] < points_[b][axis]; });
    tree_.order[node] = below[middle];
    tree_.axis[node] = axis;
    place(2 * node + 1, below.first(middle));
    place(2 * node + 2, below.subspan(middle + 1));
  }

  [[nodiscard]] std::uint8_t widest_axis(std::span<const std::uint32_t> below) const {
    Eigen::AlignedBox3f box;
    for (const auto idx : below) box.extend(points_[idx]);
    Eigen::Index axis = 0;
    box.sizes().maxCoeff(&axis);
    return static_cast<std::uint8_t>(axis);
  }

  std::span<const Eigen::Vector3f> points_;
  BalancedKdTree& tree_;
  std::vector<std::uint32_t> indices_;
};

}  // namespace

BalancedKdTree::BalancedKdTree(std::span<const Eigen::Vector3f> points)
    : order(points.size()), axis(points.size()) {
  Builder(points, *this);
}

}  // namespace mor::internal
