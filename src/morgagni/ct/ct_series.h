// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace mor {

/// A CT series of a study, as people choose one.
struct CtSeries {
  std::string uid;
  std::string description;
  std::string patient_id;
  std::string patient_position;  ///< "HFS", "FFP" ...
  int num_slices = 0;
  int columns = 0;
  int rows = 0;
  double min_gap_mm = 0.0;  ///< Between neighbouring slices.
  double max_gap_mm = 0.0;
  std::string frame_of_reference_uid;  ///< Series of one share their coordinates.
};

}  // namespace mor
