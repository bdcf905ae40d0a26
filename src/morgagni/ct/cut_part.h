// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace mor {

/// Something that is no part of the trunk or head itself. Cut off, as table, blanket, headrest and
/// tubes are; or standing out from the body and kept, as ears and noses are.
struct CutPart {
  std::string
      place;  ///< "behind", "in front of", "left of", "right of", "above", "below" the body.
  double volume_ml = 0.0;
  Eigen::Vector3d size_mm = Eigen::Vector3d::Zero();  ///< Along the CT's grid.
  /// Places in it, frame ct: SkinOptions::keep_mm and cut_mm name it by them.
  std::vector<Eigen::Vector3d> marks_mm = {};
};

}  // namespace mor
