// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "morgagni/ct/testing/sample_files.h"

/// What sample_files() is put together from.
namespace mor::testing_files {

template <class T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

[[nodiscard]] std::vector<SampleFile> nifti_samples();
[[nodiscard]] std::vector<SampleFile> nrrd_samples();
[[nodiscard]] std::vector<SampleFile> meta_samples();
[[nodiscard]] std::vector<SampleFile> ply_samples();
[[nodiscard]] std::vector<SampleFile> stl_samples();
[[nodiscard]] std::vector<SampleFile> obj_samples();
[[nodiscard]] std::vector<SampleFile> vtp_samples();
[[nodiscard]] std::vector<SampleFile> dicom_samples();
[[nodiscard]] std::vector<SampleFile> structure_set_samples();

}  // namespace mor::testing_files
