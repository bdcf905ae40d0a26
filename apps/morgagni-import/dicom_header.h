// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <Eigen/Core>

namespace mor::import {

/// What one DICOM file says of itself, without its pixels.
struct DicomHeader {
  std::filesystem::path path;
  std::string series_uid;
  std::string series_description;
  std::string patient_id;
  std::string modality;
  std::string image_type;  ///< "ORIGINAL\PRIMARY\AXIAL" and the like.
  int columns = 0;
  int rows = 0;
  int samples_per_pixel = 1;
  int num_frames = 1;
  bool has_pixels = false;
  bool pixels_cut_short = false;                    ///< The file ends before they do.
  std::optional<Eigen::Vector3d> position_mm;       ///< Image Position (Patient).
  std::optional<Eigen::Matrix<double, 3, 2>> axes;  ///< Unit vectors along a row, down a column.
  Eigen::Vector2d spacing_mm = Eigen::Vector2d::Zero();  ///< Along a row, down a column.
};

/// None where the file is no DICOM at all.
[[nodiscard]] std::optional<DicomHeader> read_dicom_header(const std::filesystem::path& path);

}  // namespace mor::import
