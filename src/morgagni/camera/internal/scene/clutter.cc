// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/scene/clutter.h"

#include "morgagni/camera/internal/scene/table_things.h"
#include "morgagni/camera/internal/scene/towel.h"

namespace mor::internal {
namespace {

constexpr float kMarginMm = 350.0F;

Eigen::AlignedBox2f from_above(const Eigen::AlignedBox3f& box) {
  return {Eigen::Vector2f(box.min().x(), box.min().z()),
          Eigen::Vector2f(box.max().x(), box.max().z())};
}

}  // namespace

Clutter::Clutter(const TriangleMesh& skin,
                 float table_top_mm,
                 SimulatedClutter kind,
                 bool rearranges,
                 std::uint64_t seed)
    : kind_(kind),
      rearranges_(rearranges),
      seed_(seed),
      body_(skin.bounds()),
      table_top_mm_(table_top_mm),
      ground_(body_, kMarginMm, table_top_mm),
      beyond_(skin, table_top_mm) {
  ground_.add(skin);
  if (has(SimulatedClutter::kHand)) hand_.emplace(seed);
  if (!rearranges_) first_ = arranged(0);
}

/// Each part draws from a counter of its own: another kind of clutter leaves the rest where it is,
/// but for what lies upon it.
Clutter::Arrangement Clutter::arranged(std::uint64_t number) const {
  const std::uint64_t counter = scramble(scramble(seed_ ^ 0x434C5554U) ^ number);
  Arrangement result;
  HeightMap ground = ground_;
  if (has(SimulatedClutter::kParts)) {
    Draws draw(scramble(counter + 1));
    result.still = beyond_.continued(draw);
    result.still.append(table_things(body_, table_top_mm_, draw));
    ground.add(result.still.mesh);
  }
  if (has(SimulatedClutter::kTowel)) {
    Draws draw(scramble(counter + 2));
    const auto towel = draped_towel(from_above(body_), ground, table_top_mm_, draw);
    ground.add(towel.mesh);
    result.still.append(towel);
  }
  if (has(SimulatedClutter::kHand)) {
    Draws draw(scramble(counter + 3));
    result.hand = hand_->placed(from_above(body_), ground, draw);
  }
  return result;
}

PaintedMesh Clutter::at(std::uint64_t frame_id, double time_s) const {
  Arrangement arrangement = rearranges_ ? arranged(frame_id) : first_;
  PaintedMesh result = std::move(arrangement.still);
  if (arrangement.hand) {
    const auto& placement = *arrangement.hand;
    result.append(hand_->surface(),
                  rearranges_ ? placement.ct_from_hand : WorkingHand::moved(placement, time_s));
  }
  return result;
}

}  // namespace mor::internal
