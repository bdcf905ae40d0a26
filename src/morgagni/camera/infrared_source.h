// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stop_token>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"

namespace mor {

/// A range camera that can show what its depth camera sees in infrared, for calibrations. Colour
/// and infrared need not run together: what is before the camera holds still meanwhile.
class InfraredSource {
 public:
  virtual ~InfraredSource() = default;

  /// Of the place that the last frame showed, grey, of the depth pictures' size and lens.
  /// @errors kDevice: none could be had.
  [[nodiscard]] virtual Result<Image<Rgb8>> infrared_picture(std::stop_token stop) = 0;
};

}  // namespace mor
