// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <Eigen/Geometry>

#include "morgagni/camera/internal/random.h"
#include "morgagni/camera/internal/scene/height_map.h"
#include "morgagni/camera/internal/scene/painted_mesh.h"

namespace mor::internal {

/// A gloved hand with its forearm in a sleeve: rests on what lies on the table or hovers over it.
class WorkingHand {
 public:
  explicit WorkingHand(std::uint64_t seed);

  /// Where it is: on what lies within an ellipse in `area` (x, z of the frame ct), the arm coming
  /// from outside; and how it moves there.
  struct Placement {
    Eigen::Isometry3f ct_from_hand = Eigen::Isometry3f::Identity();
    Eigen::Vector3f motion_phase_rad = Eigen::Vector3f::Zero();
    float period_s = 8.0F;
  };
  [[nodiscard]] Placement placed(const Eigen::AlignedBox2f& area,
                                 const HeightMap& ground,
                                 Draws& draw) const;

  /// The hand's frame at a moment: it glides some centimetres to and fro, lifts and turns a little.
  [[nodiscard]] static Eigen::Isometry3f moved(const Placement& placement, double time_s);

  /// Frame hand: x to the finger tips, y to the thumb (of the seed's side), z out of its back, the
  /// origin below the palm where its lowest point is.
  [[nodiscard]] const PaintedMesh& surface() const { return surface_; }

 private:
  PaintedMesh surface_;
};

}  // namespace mor::internal
