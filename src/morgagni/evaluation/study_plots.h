// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "morgagni/evaluation/studies.h"

namespace mor {

struct StudyPlot {
  std::string file_name;  ///< "accuracy.svg".
  std::string caption;
  std::string svg;
};

/// The report's pictures: errors of tables 1 and 2 pose by pose; error and time against
/// down-sampling; how many of many poses end below an error.
[[nodiscard]] std::vector<StudyPlot> study_plots(const StudiesReport& report);

}  // namespace mor
