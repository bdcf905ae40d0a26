// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace mor::internal {

/// A k-d tree without pointers, fit for a device: the points in the order of a complete binary
/// tree, level by level, one a node; the children of node i are 2i + 1 and 2i + 2. What lies on the
/// first child's side has a coordinate <= the node's along the node's axis.
struct BalancedKdTree {
  std::vector<std::uint32_t> order;  ///< Of each node: its point's index.
  std::vector<std::uint8_t> axis;    ///< Of each node: 0, 1 or 2, the widest of what lies below it.

  /// @param points  Finite. @cost O(N log^2 N).
  explicit BalancedKdTree(std::span<const Eigen::Vector3f> points);
};

/// Goes through the nodes that may hold something near, nearest first.
///
/// @param points  Of the nodes, in the tree's order.
/// @param visit  Called with each node's index.
/// @param in_reach  Called with a node and the distance of the query from its plane, mm: whether
///                  anything below the node and beyond that plane can still matter.
template <class Visit, class InReach>
void traverse(const BalancedKdTree& tree,
              std::span<const Eigen::Vector3f> points,
              const Eigen::Vector3f& query,
              Visit&& visit,
              InReach&& in_reach) {
  struct Pending {
    std::size_t node;    ///< The child beyond the plane.
    std::size_t parent;  ///< Whose plane it is.
    float distance_mm;
  };
  std::array<Pending, 64> stack;  // One a level at most.
  std::size_t num_pending = 0;
  std::size_t node = 0;
  while (true) {
    if (node < points.size()) {
      visit(node);
      const std::uint8_t axis = tree.axis[node];
      const float distance_mm = query[axis] - points[node][axis];
      const bool upper = distance_mm > 0.0F;
      stack[num_pending++] = {2 * node + (upper ? 1 : 2), node, distance_mm};
      node = 2 * node + (upper ? 2 : 1);
      continue;
    }
    do {
      if (num_pending == 0) return;
      --num_pending;
    } while (stack[num_pending].node >= points.size() ||
             !in_reach(stack[num_pending].parent, stack[num_pending].distance_mm));
    node = stack[num_pending].node;
  }
}

}  // namespace mor::internal
