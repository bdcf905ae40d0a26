// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "morgagni/ct/testing/dicom_writer.h"

namespace mor::testing_dicom {

struct ContourText {
  std::vector<Eigen::Vector3d> places;
  std::string type = "CLOSED_PLANAR";
};

struct RoiText {
  std::string name;
  std::vector<ContourText> contours;
};

/// A DICOM RT Structure Set. @param other_data  What every contour has for its places, where not
/// empty.
[[nodiscard]] std::string structure_set_file(const std::vector<RoiText>& rois,
                                             const std::string& other_data = {},
                                             const char* transfer_syntax = kExplicit);

}  // namespace mor::testing_dicom
