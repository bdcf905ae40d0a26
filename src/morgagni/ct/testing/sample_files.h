// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace mor::testing_files {

struct SampleFile {
  std::string name;
  std::string bytes;
};

/// Small whole files of each format that is imported: what mutants and fuzzing begin with.
/// @param format  "dicom", "rtstruct", "nifti", "nrrd", "mha", "ply", "stl", "obj" or "vtp".
/// @return For DICOM: slices at z = 2 of a series of which sample_neighbours() are z = 0 and 1;
///         those with "alone" in their name are whole studies of their own.
[[nodiscard]] std::vector<SampleFile> sample_files(std::string_view format);

/// The other two slices of the series that a DICOM sample belongs to.
[[nodiscard]] std::vector<SampleFile> sample_neighbours();

}  // namespace mor::testing_files
