// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include <Eigen/Core>

namespace mor {

/// Nearest points in 3-D (nanoflann). Copies nothing: the points must outlive the tree.
class KdTree {
 public:
  struct Neighbor {
    std::uint32_t index = 0;
    float distance_sq_mm2 = std::numeric_limits<float>::infinity();
  };

  /// @param points  N >= 1 finite points in mm. @cost O(N log N).
  explicit KdTree(std::span<const Eigen::Vector3f> points);
  KdTree(KdTree&&) noexcept;
  KdTree& operator=(KdTree&&) noexcept;
  ~KdTree();

  /// The nearest point. @threads Safe to call from many at once. @cost O(log N).
  [[nodiscard]] Neighbor nearest(const Eigen::Vector3f& query) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mor
