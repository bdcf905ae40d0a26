// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "morgagni/core/image.h"

namespace mor {

/// The depths that a sensor can tell. One that measures disparity knows steps of it only, so its
/// depths are 1 / (step i + offset) with whole i (Khoshelham & Elberink, "Accuracy and resolution
/// of Kinect depth data", Sensors 12, 2012), 1.8 mm apart at 0.8 m; a picture in whole millimetres
/// rounds each of them, always alike, by up to 0.5 mm, or cuts its fraction off. No number of
/// readings averages that out. The values that occur in a picture give step and offset away, and
/// with them the depths before rounding.
///
/// Until such steps are found, and for a sensor that has none, each value stands for itself.
class DepthLevels {
 public:
  DepthLevels();

  /// Looks for steps in a picture, unless they are known or many pictures had none.
  /// @param depth_mm  0 = no reading.
  /// @cost About 1 ms until steps are found, most often in the first picture; then nothing.
  void learn(ImageView<const std::uint16_t> depth_mm);

  [[nodiscard]] bool has_steps() const { return has_steps_; }
  /// The depth that a value stands for; within 0.5 mm of it, 1 mm where fractions are cut off.
  [[nodiscard]] float mm(std::uint16_t value) const { return mm_[value]; }

 private:
  std::vector<float> mm_;  ///< Of every value.
  bool has_steps_ = false;
  int num_pictures_ = 0;
};

}  // namespace mor
