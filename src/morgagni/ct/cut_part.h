// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <Eigen/Core>

namespace mor {

/// Something in the CT that was not taken for the body: table, blanket, headrest, tube.
struct CutPart {
  std::string
      place;  ///< "behind", "in front of", "left of", "right of", "above", "below" the body.
  double volume_ml = 0.0;
  Eigen::Vector3d size_mm = Eigen::Vector3d::Zero();  ///< Along the CT's grid.
};

}  // namespace mor
