// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/geometry/kd_tree.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace mor {
namespace {

TEST(KdTree, FindsTheDistanceThatBruteForceFinds) {
  for (const int count : {1, 2, 3, 7, 100, 4097}) {
    std::mt19937 random(static_cast<unsigned>(count));
    std::uniform_real_distribution<float> anywhere(-100.0F, 100.0F);
    std::vector<Eigen::Vector3f> points(static_cast<std::size_t>(count));
    for (auto& point : points) point = {anywhere(random), anywhere(random), anywhere(random)};
    const KdTree tree(points);
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector3f query(anywhere(random), anywhere(random), anywhere(random));
      float best = std::numeric_limits<float>::infinity();
      for (const auto& point : points) best = std::min(best, (point - query).squaredNorm());
      const auto found = tree.nearest(query);
      EXPECT_FLOAT_EQ(found.distance_sq_mm2, best);
      EXPECT_FLOAT_EQ((points[found.index] - query).squaredNorm(), best);
    }
  }
}

}  // namespace
}  // namespace mor
