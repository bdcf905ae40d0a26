// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dicom_study.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <numbers>
#include <vector>

#include "dicom_series.h"
#include "messages.h"
#include "sandbox.h"
#include "slice_reader.h"
#include "slice_stack.h"
#include "study_files.h"

namespace mor::import {
namespace {

namespace fs = std::filesystem;

std::string fixed_text(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2f", number);
  return text.data();
}

void note_shape(const SliceStack& stack, const ImportHeader& grid) {
  const StackShape shape = shape_of(stack);
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  if (grid.size[0] != stack.columns || grid.size[1] != stack.rows) {
    say_note("the slices are tilted by " + fixed_text(shape.tilt_rad * kDegrees) +
             " degrees: resampled onto a right-angled grid");
  }
  if (grid.size[2] != static_cast<int>(stack.origins_mm.size())) {
    say_note("the slices lie " + fixed_text(shape.min_gap_mm) + " to " +
             fixed_text(shape.max_gap_mm) + " mm apart: resampled every " +
             fixed_text(grid.spacing_mm[2]) + " mm");
  }
  for (const std::size_t k : wide_gaps(stack)) {
    const double gap_mm = stack.normal().dot(stack.origins_mm[k + 1] - stack.origins_mm[k]);
    say_note("slices may be missing: " + fixed_text(gap_mm) + " mm between " + stack.names[k] +
             " and " + stack.names[k + 1] + ", more than beside them");
  }
}

void note_pixels(const DicomSeries& series) {
  const auto lossy = std::find_if(
      series.begin(), series.end(), [](const DicomSlice& slice) { return slice.is_lossy; });
  if (lossy != series.end())
    say_note("the pixels were compressed with a loss: the skin may lie a little off");
}

std::string description_of(const DicomSlice& slice) {
  return "CT, series \"" + slice.series_description + "\", patient " + slice.patient_id;
}

}  // namespace

Result<void> import_dicom(const fs::path& path, const std::string& wanted) {
  MOR_TRY(const auto files, open_study(path));
  MOR_TRY(auto found, find_series(*files, path.string()));
  MOR_TRY(DicomSeries series, choose_series(std::move(found.all), wanted, path.string()));
  MOR_CHECK(leave_out_damaged(found.damaged, series));
  leave_out_strays(series);
  const SliceStack stack = stack_of(series);
  MOR_TRY(ImportHeader header, grid_for(stack));
  note_shape(stack, header);
  note_pixels(series);
  set_description(header, description_of(series.front()));
  MOR_TRY(const auto hu, open_voxels(header));
  allow_memory(hu.size_bytes());
  SliceReader reader(*files);
  return resample(stack, header, hu, [&](std::size_t k) {
    const double share = static_cast<double>(k) / static_cast<double>(series.size());
    say_progress(kScanShare + (0.99 - kScanShare) * share);
    return reader.read_hu(series[k]);
  });
}

Result<void> list_dicom_series(const fs::path& path) {
  MOR_TRY(const auto files, open_study(path));
  MOR_TRY(const auto found, find_series(*files, path.string()));
  for (const auto& file : found.damaged) say_note(file.error.message);
  for (const auto& series : found.all) {
    const auto& first = series.front();
    const StackShape shape = shape_of(stack_of(series));
    say_series({.uid = first.series_uid,
                .description = first.series_description,
                .patient_id = first.patient_id,
                .patient_position = first.patient_position,
                .num_slices = static_cast<int>(series.size()),
                .columns = first.columns,
                .rows = first.rows,
                .min_gap_mm = shape.min_gap_mm,
                .max_gap_mm = shape.max_gap_mm,
                .frame_of_reference_uid = first.frame_of_reference_uid});
  }
  return {};
}

}  // namespace mor::import
