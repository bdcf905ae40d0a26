// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace mor::internal {

/// The point of a triangle that is nearest to a query, as weights of the corners (>= 0, sum 1).
struct ClosestPoint {
  Eigen::Vector3f point = Eigen::Vector3f::Zero();
  Eigen::Vector3f weights = Eigen::Vector3f::Zero();
};

/// By the Voronoi regions of corners, edges and face (Ericson, "Real-Time Collision Detection",
/// 2005, section 5.1.5). A triangle without area gives a point of its longest part.
[[nodiscard]] inline ClosestPoint closest_point_on_triangle(const Eigen::Vector3f& p,
                                                            const Eigen::Vector3f& a,
                                                            const Eigen::Vector3f& b,
                                                            const Eigen::Vector3f& c) {
  const Eigen::Vector3f ab = b - a;
  const Eigen::Vector3f ac = c - a;
  const Eigen::Vector3f ap = p - a;
  const float d1 = ab.dot(ap);
  const float d2 = ac.dot(ap);
  if (d1 <= 0.0F && d2 <= 0.0F) return {a, {1.0F, 0.0F, 0.0F}};
  const Eigen::Vector3f bp = p - b;
  const float d3 = ab.dot(bp);
  const float d4 = ac.dot(bp);
  if (d3 >= 0.0F && d4 <= d3) return {b, {0.0F, 1.0F, 0.0F}};
  const Eigen::Vector3f cp = p - c;
  const float d5 = ab.dot(cp);
  const float d6 = ac.dot(cp);
  if (d6 >= 0.0F && d5 <= d6) return {c, {0.0F, 0.0F, 1.0F}};
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0F && d1 >= 0.0F && d3 <= 0.0F) {
    const float t = d1 / (d1 - d3);
    return {a + t * ab, {1.0F - t, t, 0.0F}};
  }
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0F && d2 >= 0.0F && d6 <= 0.0F) {
    const float t = d2 / (d2 - d6);
    return {a + t * ac, {1.0F - t, 0.0F, t}};
  }
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0.0F && d4 >= d3 && d5 >= d6) {
    const float t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {b + t * (c - b), {0.0F, 1.0F - t, t}};
  }
  const float scale = 1.0F / (va + vb + vc);
  const float v = vb * scale;
  const float w = vc * scale;
  return {a + v * ab + w * ac, {1.0F - v - w, v, w}};
}

}  // namespace mor::internal
