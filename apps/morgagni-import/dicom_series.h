// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "morgagni/core/result.h"

#include "dicom_slice.h"
#include "slice_stack.h"
#include "study_files.h"

namespace mor::import {

inline constexpr std::size_t kMinSlices = 3;
inline constexpr double kScanShare = 0.3;  ///< Of the progress: finding out what is in the folder.

/// Slices of one series that are parallel and of one size, in order along their normal.
using DicomSeries = std::vector<DicomSlice>;

/// A file that cannot be read, as it is cut short.
struct DamagedFile {
  std::string name;
  std::string series_uid;  ///< Empty: it cannot be told.
  Error error;             ///< The whole sentence.
};

struct FoundSeries {
  std::vector<DicomSeries> all;
  std::vector<DamagedFile> damaged;
};

/// Finds the CT series among the files. What is no CT slice, is there twice or does not fit the
/// rest of its series is left out, and named in a note. Acquisitions of one series that lie at the
/// same places, or among one another, become a series each.
/// @return With kMinSlices or more, in the order of their series numbers.
/// @errors kUnsupported: there is no CT series; with damaged files what is wrong with the first.
[[nodiscard]] Result<FoundSeries> find_series(const StudyFiles& files, const std::string& where);

/// The series that `wanted` names: its number in the list (from 1), UID or description; with an
/// empty one the only series. @errors kUnsupported, kInvalidArgument: with the list to choose from.
[[nodiscard]] Result<DicomSeries> choose_series(std::vector<DicomSeries> all,
                                                const std::string& wanted,
                                                const std::string& where);

/// Names the damaged files of other series in a note.
/// @errors As the file's: one that is, or may be, a slice of this series.
[[nodiscard]] Result<void> leave_out_damaged(const std::vector<DamagedFile>& damaged,
                                             const DicomSeries& series);

[[nodiscard]] SliceStack stack_of(const DicomSeries& series);

/// Leaves out slices far away from the rest (the end of another scan), and says so.
void leave_out_strays(DicomSeries& series);

}  // namespace mor::import
