// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace mor::testing_dicom {

inline constexpr const char* kImplicit = "1.2.840.10008.1.2";
inline constexpr const char* kExplicit = "1.2.840.10008.1.2.1";
inline constexpr const char* kDeflated = "1.2.840.10008.1.2.1.99";
inline constexpr const char* kBigEndian = "1.2.840.10008.1.2.2";

/// A data set under construction, in one of the encodings.
class DicomWriter {
 public:
  explicit DicomWriter(std::string transfer_syntax = kExplicit);

  void text(std::uint32_t tag, const char* type, const std::string& value);
  void number(std::uint32_t tag, std::uint16_t value);
  void words(std::uint32_t tag, const std::vector<std::uint16_t>& values);
  /// Any bytes with any length, true or not.
  void raw(std::uint32_t tag, const char* type, std::uint32_t length, const std::string& bytes);
  /// A sequence whose items are data sets of the same encoding.
  void sequence(std::uint32_t tag, const std::vector<std::string>& items);

  /// What was written so far, without preamble.
  [[nodiscard]] const std::string& data() const { return data_; }
  /// As a file: preamble, group 2, data set.
  [[nodiscard]] std::string file() const;

 private:
  void put16(std::uint32_t value);
  void put32(std::uint32_t value);
  void head(std::uint32_t tag, const char* type, std::uint32_t length);

  std::string transfer_syntax_;
  bool is_explicit_;
  bool big_endian_;
  std::string data_;
};

/// One slice of a made CT, and how it is stored.
struct SliceText {
  std::string transfer_syntax = kExplicit;
  std::string modality = "CT";
  std::string image_type = "ORIGINAL\\PRIMARY\\AXIAL";
  std::string series_uid = "1.2.3";
  std::string series_description = "made";
  std::string frame_of_reference_uid = "1.2.840.99";
  std::string sop_instance_uid = {};  ///< Empty: of its own place.
  std::string patient_position = "HFS";
  int series_number = 1;
  int acquisition_number = 1;
  int columns = 6;
  int rows = 5;
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d along_row = Eigen::Vector3d::UnitX();
  Eigen::Vector3d down_column = Eigen::Vector3d::UnitY();
  double column_spacing_mm = 0.5;  ///< Along a row.
  double row_spacing_mm = 1.0;     ///< Down a column.
  std::string slope = "1";
  std::string intercept = "-1024";
  bool is_signed = false;
  int bits_stored = 16;
  int padding = -1;  ///< None below 0.
  bool has_position = true;
  std::vector<std::uint16_t> stored = {};  ///< columns * rows; empty: no pixels.
};

/// The whole file.
[[nodiscard]] std::string slice_file(const SliceText& slice);

}  // namespace mor::testing_dicom
