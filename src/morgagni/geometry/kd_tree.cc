// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/geometry/kd_tree.h"

#include <nanoflann.hpp>

namespace mor {
namespace {

/// nanoflann's view of the points; the names are its interface.
struct Points {
  std::span<const Eigen::Vector3f> values;

  [[nodiscard]] std::size_t kdtree_get_point_count() const { return values.size(); }
  [[nodiscard]] float kdtree_get_pt(std::size_t index, std::size_t axis) const {
    return values[index][static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;
  }
};

using Tree = nanoflann::
    KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Points>, Points, 3, std::uint32_t>;

}  // namespace

struct KdTree::Impl {
  explicit Impl(std::span<const Eigen::Vector3f> values) : points{values}, tree(3, points) {
    tree.buildIndex();
  }
  Points points;
  Tree tree;
};

KdTree::KdTree(std::span<const Eigen::Vector3f> points) : impl_(std::make_unique<Impl>(points)) {}
KdTree::KdTree(KdTree&&) noexcept = default;
KdTree& KdTree::operator=(KdTree&&) noexcept = default;
KdTree::~KdTree() = default;

KdTree::Neighbor KdTree::nearest(const Eigen::Vector3f& query) const {
  Neighbor neighbor;
  impl_->tree.knnSearch(query.data(), 1, &neighbor.index, &neighbor.distance_sq_mm2);
  return neighbor;
}

}  // namespace mor
