// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "dicom_file.h"

namespace mor::import {

/// How the numbers in a slice's pixels become HU.
struct PixelMeaning {
  int bits_allocated = 16;
  int bits_stored = 16;
  int high_bit = 15;
  bool is_signed = false;
  double slope = 1.0;
  double intercept = 0.0;
  std::optional<std::int32_t> padding_low;  ///< Stored numbers from here ...
  std::int32_t padding_high = 0;            ///< ... to here are no measurement but air.
  bool operator==(const PixelMeaning&) const = default;
};

/// What one slice says of itself: a file, or one frame of a multi-frame file.
struct DicomSlice {
  std::size_t file = 0;  ///< In the StudyFiles.
  std::string name;      ///< For people: the file's, with the frame's number where it has several.
  int frame = 0;
  int num_frames = 1;
  std::string sop_instance_uid;
  std::string series_uid;
  std::string frame_of_reference_uid;
  std::string series_description;
  std::string patient_id;
  std::string patient_position;  ///< "HFS", "FFP" ...: told to people, never reckoned with.
  std::string modality;
  std::string image_type;  ///< "ORIGINAL\PRIMARY\AXIAL" and the like.
  int series_number = 0;
  int acquisition_number = 0;
  bool is_lossy = false;
  int columns = 0;
  int rows = 0;
  int samples_per_pixel = 1;
  bool has_pixels = false;
  std::optional<Eigen::Vector3d> position_mm;            ///< Image Position (Patient).
  std::optional<Eigen::Matrix<double, 3, 2>> axes;       ///< Unit, along a row, down a column.
  Eigen::Vector2d spacing_mm = Eigen::Vector2d::Zero();  ///< Along a row, down a column.
  PixelMeaning meaning;
  std::string flaw;  ///< Why this is no slice of a CT; empty when it is one.

  [[nodiscard]] Eigen::Vector3d normal() const { return axes->col(0).cross(axes->col(1)); }
};

/// The slices of a parsed file: one, or one a frame.
[[nodiscard]] std::vector<DicomSlice> slices_of(const DicomFile& file,
                                                std::size_t file_index,
                                                const std::string& name);

}  // namespace mor::import
