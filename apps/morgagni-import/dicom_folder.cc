// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dicom_folder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>

#include <itkGDCMImageIO.h>
#include <itkImage.h>
#include <itkImageFileReader.h>

#include "dicom_header.h"
#include "slice_stack.h"

namespace mor::import {
namespace {

namespace fs = std::filesystem;
using Series = std::vector<DicomHeader>;

constexpr std::size_t kMaxFiles = 20000;
constexpr std::size_t kMinSlices = 3;
constexpr double kScanShare = 0.3;  ///< Of the progress: finding out what is in the folder.

std::string fixed_text(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2f", number);
  return text.data();
}

Result<std::vector<fs::path>> files_of(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry :
       fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied)) {
    if (!entry.is_regular_file()) continue;
    files.push_back(entry.path());
    if (files.size() > kMaxFiles) {
      return make_error(ErrorCode::kInvalidArgument,
                        folder.string() + " holds more than " + std::to_string(kMaxFiles) +
                            " files: give the folder of one series");
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// Why the file is no CT slice; empty when it is one.
std::string flaw_of(const DicomHeader& header) {
  if (header.modality.empty()) return "it names no modality, so it is no CT slice";
  if (header.modality != "CT") return "its modality is " + header.modality + ", not CT";
  if (header.image_type.find("LOCALIZER") != std::string::npos) return "it is a localizer";
  if (!header.has_pixels) return "it has no pixels";
  if (!header.position_mm || !header.axes) return "it has no position in space";
  return {};
}

struct Folder {
  std::map<std::string, Series> series;  ///< By their UID.
  std::map<std::string, int> skipped;    ///< How many files for which reason.
  int num_dicom = 0;
};

/// Whether the file begins as DICOM files do: then it is not passed over like a stray text.
bool says_dicom(const fs::path& path) {
  constexpr std::size_t kPreambleBytes = 128;
  std::array<char, kPreambleBytes + 4> start{};
  std::ifstream file(path, std::ios::binary);
  file.read(start.data(), start.size());
  return std::string_view(start.data() + kPreambleBytes, 4) == "DICM";
}

Result<Folder> look_through(const fs::path& path) {
  MOR_TRY(const auto files, files_of(path));
  Folder folder;
  for (std::size_t i = 0; i < files.size(); ++i) {
    say_file(files[i].string());
    if (i % 8 == 0) say_progress(kScanShare * static_cast<double>(i) / files.size());
    auto header = read_dicom_header(files[i]);
    if (!header && says_dicom(files[i])) {
      return make_error(ErrorCode::kIo,
                        files[i].filename().string() +
                            " is a DICOM file that is cut short or damaged: copy "
                            "the series again");
    }
    if (!header) {
      ++folder.skipped["it is no DICOM file"];
      continue;
    }
    ++folder.num_dicom;
    const std::string flaw = flaw_of(*header);
    if (flaw.empty()) {
      folder.series[header->series_uid].push_back(*std::move(header));
    } else {
      ++folder.skipped[flaw];
    }
  }
  for (const auto& [flaw, count] : folder.skipped)
    say_note(std::to_string(count) + " file(s) of " + path.string() + " skipped: " + flaw);
  return folder;
}

Result<Series> only_series(Folder folder, const fs::path& path) {
  if (folder.num_dicom == 0)
    return make_error(ErrorCode::kUnsupported, path.string() + " holds no DICOM file");
  if (folder.series.empty()) {
    return make_error(ErrorCode::kUnsupported,
                      path.string() + " holds no CT slice: " + folder.skipped.rbegin()->first);
  }
  std::string list;
  Series* found = nullptr;
  int num_found = 0;
  for (auto& [uid, series] : folder.series) {
    list += (list.empty() ? "" : ", ") + ('"' + series.front().series_description) + "\" with " +
            std::to_string(series.size()) + " slices";
    if (series.size() < kMinSlices) continue;
    found = &series;
    ++num_found;
  }
  if (num_found > 1) {
    return make_error(
        ErrorCode::kUnsupported,
        path.string() + " holds several CT series (" + list + "): give a folder with one of them");
  }
  if (num_found == 0) {
    return make_error(ErrorCode::kUnsupported,
                      path.string() + " holds too few CT slices (" + list + "), at least " +
                          std::to_string(kMinSlices) + " are needed");
  }
  return std::move(*found);
}

Result<void> check_alike(const Series& series) {
  const auto refuse = [](ErrorCode code, const DicomHeader& header, const std::string& what) {
    return make_error(code, header.path.filename().string() + " " + what);
  };
  for (const auto& header : series) {
    if (header.pixels_cut_short)
      return refuse(ErrorCode::kIo, header, "is cut short: copy the series again");
    if (header.samples_per_pixel != 1)
      return refuse(ErrorCode::kUnsupported, header, "is a colour picture, a CT slice is grey");
    if (header.num_frames != 1)
      return refuse(ErrorCode::kUnsupported,
                    header,
                    "holds several frames: enhanced (multi-frame) CT is not read, export single "
                    "slices");
    if (!(header.spacing_mm.minCoeff() > 0.0))
      return refuse(ErrorCode::kInvalidArgument,
                    header,
                    "has no pixel spacing above 0 mm: the series cannot be measured");
    const auto& first = series.front();
    if (header.columns != first.columns || header.rows != first.rows ||
        (header.spacing_mm - first.spacing_mm).cwiseAbs().maxCoeff() > 1e-3)
      return refuse(ErrorCode::kUnsupported,
                    header,
                    "has another size or spacing than the other slices of its series");
    if ((*header.axes - *first.axes).cwiseAbs().maxCoeff() > 1e-3)
      return refuse(
          ErrorCode::kUnsupported, header, "is turned against the other slices of its series");
  }
  if (series.front().columns > kMaxVolumeSide || series.front().rows > kMaxVolumeSide)
    return refuse(ErrorCode::kInvalidArgument,
                  series.front(),
                  "is larger than " + std::to_string(kMaxVolumeSide) + " pixels a side");
  return {};
}

SliceStack stack_of(Series& series) {
  SliceStack stack;
  stack.columns = series.front().columns;
  stack.rows = series.front().rows;
  stack.spacing_mm = series.front().spacing_mm;
  stack.axes = *series.front().axes;
  const Eigen::Vector3d normal = stack.normal();
  std::sort(series.begin(), series.end(), [&](const DicomHeader& a, const DicomHeader& b) {
    return normal.dot(*a.position_mm) < normal.dot(*b.position_mm);
  });
  for (const auto& header : series) stack.origins_mm.push_back(*header.position_mm);
  return stack;
}

Result<std::vector<std::int16_t>> pixels_of(const DicomHeader& header) {
  using Image = itk::Image<float, 3>;
  say_file(header.path.string());
  try {
    const auto reader = itk::ImageFileReader<Image>::New();
    reader->SetImageIO(itk::GDCMImageIO::New());
    reader->SetFileName(header.path.string());
    reader->Update();
    const auto size = reader->GetOutput()->GetLargestPossibleRegion().GetSize();
    if (static_cast<int>(size[0]) == header.columns && static_cast<int>(size[1]) == header.rows &&
        size[2] == 1) {
      const float* values = reader->GetOutput()->GetBufferPointer();
      std::vector<std::int16_t> hu(size[0] * size[1]);
      std::transform(values, values + hu.size(), hu.begin(), [](float value) {
        return static_cast<std::int16_t>(std::lround(std::clamp(value, -32768.0F, 32767.0F)));
      });
      return hu;
    }
  } catch (const itk::ExceptionObject&) {
    // ITK's sentence is several lines of its own source; ours names the file.
  }
  return make_error(
      ErrorCode::kIo,
      header.path.filename().string() + " has damaged or missing pixels: copy the series again");
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
}

Result<void> check_limits(const ImportHeader& grid) {
  const std::int64_t num_bytes =
      std::int64_t{2} * grid.size[0] * grid.size[1] * std::int64_t{grid.size[2]};
  if (*std::max_element(grid.size.begin(), grid.size.end()) <= kMaxVolumeSide &&
      num_bytes <= kMaxVolumeBytes)
    return {};
  return make_error(ErrorCode::kInvalidArgument,
                    "the CT would have " + std::to_string(grid.size[0]) + " x " +
                        std::to_string(grid.size[1]) + " x " + std::to_string(grid.size[2]) +
                        " voxels, the limits are " + std::to_string(kMaxVolumeSide) +
                        " a side and " + std::to_string(kMaxVolumeBytes >> 20) + " MiB");
}

}  // namespace

Result<ImportedVolume> read_dicom_folder(const fs::path& path) {
  MOR_TRY(Folder folder, look_through(path));
  MOR_TRY(Series series, only_series(std::move(folder), path));
  MOR_CHECK(check_alike(series));
  const SliceStack stack = stack_of(series);
  ImportedVolume volume;
  MOR_TRY(volume.header, grid_for(stack));
  MOR_CHECK(check_limits(volume.header));
  note_shape(stack, volume.header);
  MOR_TRY(volume.hu, resample(stack, volume.header, [&](std::size_t k) {
            say_progress(kScanShare + (0.99 - kScanShare) * static_cast<double>(k) / series.size());
            return pixels_of(series[k]);
          }));
  set_description(volume.header,
                  "CT, series \"" + series.front().series_description + "\", patient " +
                      series.front().patient_id);
  return volume;
}

}  // namespace mor::import
