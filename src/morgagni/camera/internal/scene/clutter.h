// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Geometry>

#include "morgagni/camera/internal/scene/body_beyond.h"
#include "morgagni/camera/internal/scene/height_map.h"
#include "morgagni/camera/internal/scene/painted_mesh.h"
#include "morgagni/camera/internal/scene/working_hand.h"
#include "morgagni/camera/simulated_camera.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// What the camera sees and the CT does not have: see SimulatedClutter. Frame ct.
class Clutter {
 public:
  /// @param kind  Not kNone.
  /// @param rearranges  Every frame is an arrangement of its own (path=views); else there is one,
  ///        in which the hand moves.
  Clutter(const TriangleMesh& skin,
          float table_top_mm,
          SimulatedClutter kind,
          bool rearranges,
          std::uint64_t seed);

  /// The same for the same (seed, frame_id). @threads Safe to call from many at once.
  /// @cost About 1 ms, of a new arrangement 10 ms.
  [[nodiscard]] PaintedMesh at(std::uint64_t frame_id, double time_s) const;

 private:
  struct Arrangement {
    PaintedMesh still;
    std::optional<WorkingHand::Placement> hand;
  };
  [[nodiscard]] Arrangement arranged(std::uint64_t number) const;
  [[nodiscard]] bool has(SimulatedClutter part) const {
    return kind_ == part || kind_ == SimulatedClutter::kAll;
  }

  SimulatedClutter kind_;
  bool rearranges_;
  std::uint64_t seed_;
  Eigen::AlignedBox3f body_;
  float table_top_mm_;
  HeightMap ground_;  ///< Of the skin alone.
  BodyBeyond beyond_;
  std::optional<WorkingHand> hand_;
  Arrangement first_;
};

}  // namespace mor::internal
