// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "morgagni/core/result.h"

#include "dicom_slice.h"
#include "study_files.h"

namespace mor::import {

/// Reads the pixels of slices as HU. Remembers the file it read last: frames come one by one.
class SliceReader {
 public:
  explicit SliceReader(const StudyFiles& files) : files_(files) {}

  /// @return columns * rows values; padding has become air.
  /// @errors kIo: pixels cut short or damaged. kUnsupported: a transfer syntax that is not read.
  [[nodiscard]] Result<std::vector<std::int16_t>> read_hu(const DicomSlice& slice);

 private:
  Result<void> open(const DicomSlice& slice);
  [[nodiscard]] Result<std::vector<std::byte>> stored_pixels(const DicomSlice& slice) const;
  void make_table(const PixelMeaning& meaning);

  const StudyFiles& files_;
  std::optional<std::size_t> open_file_;
  FileBytes bytes_;
  DicomFile file_;
  std::optional<PixelMeaning> table_of_;
  std::vector<std::int16_t> table_;  ///< HU of every stored number.
};

}  // namespace mor::import
