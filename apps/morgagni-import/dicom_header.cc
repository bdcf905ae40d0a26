// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dicom_header.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <vector>

#include <gdcmReader.h>
#include <gdcmStringFilter.h>
#include <gdcmTag.h>

namespace mor::import {
namespace {

using namespace std::string_literals;

const gdcm::Tag kImageType(0x0008, 0x0008);
const gdcm::Tag kModality(0x0008, 0x0060);
const gdcm::Tag kSeriesDescription(0x0008, 0x103e);
const gdcm::Tag kPatientId(0x0010, 0x0020);
const gdcm::Tag kSeriesUid(0x0020, 0x000e);
const gdcm::Tag kPosition(0x0020, 0x0032);
const gdcm::Tag kOrientation(0x0020, 0x0037);
const gdcm::Tag kSamplesPerPixel(0x0028, 0x0002);
const gdcm::Tag kNumFrames(0x0028, 0x0008);
const gdcm::Tag kRows(0x0028, 0x0010);
const gdcm::Tag kColumns(0x0028, 0x0011);
const gdcm::Tag kPixelSpacing(0x0028, 0x0030);
const gdcm::Tag kBitsAllocated(0x0028, 0x0100);
const gdcm::Tag kPixelData(0x7fe0, 0x0010);

std::string trimmed(std::string text) {
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.pop_back();
  const auto start = text.find_first_not_of(' ');
  return start == std::string::npos ? std::string() : text.substr(start);
}

/// The numbers of "1.5\-2\3"; empty when one of them is none.
std::vector<double> numbers_of(const std::string& text) {
  std::vector<double> numbers;
  std::size_t start = 0;
  while (start <= text.size()) {
    const auto end = std::min(text.find('\\', start), text.size());
    const std::string word = trimmed(text.substr(start, end - start));
    char* stop = nullptr;
    const double number = std::strtod(word.c_str(), &stop);
    if (word.empty() || *stop != '\0' || !std::isfinite(number)) return {};
    numbers.push_back(number);
    start = end + 1;
  }
  return numbers;
}

int count_of(const std::string& text, int otherwise) {
  const auto numbers = numbers_of(text);
  const bool usable = !numbers.empty() && numbers[0] >= 0.0 && numbers[0] <= 1e6;
  return usable ? static_cast<int>(numbers[0]) : otherwise;
}

std::optional<Eigen::Matrix<double, 3, 2>> axes_of(const std::string& text) {
  const auto numbers = numbers_of(text);
  if (numbers.size() != 6) return std::nullopt;
  Eigen::Matrix<double, 3, 2> axes;
  axes << numbers[0], numbers[3], numbers[1], numbers[4], numbers[2], numbers[5];
  constexpr double kTolerance = 1e-3;
  const Eigen::Matrix2d gram = axes.transpose() * axes;
  if ((gram - Eigen::Matrix2d::Identity()).cwiseAbs().maxCoeff() > kTolerance) return std::nullopt;
  axes.col(0).normalize();
  axes.col(1) = (axes.col(1) - axes.col(0) * axes.col(0).dot(axes.col(1))).normalized();
  return axes;
}

/// GDCM reads pixels beyond a file's end as if they were there. Compressed ones have no length to
/// compare with; their decoder complains instead.
bool lacks_pixels(const gdcm::Reader& reader,
                  const std::filesystem::path& path,
                  const DicomHeader& header,
                  int bits_allocated) {
  if (reader.GetFile().GetHeader().GetDataSetTransferSyntax().IsEncapsulated()) return false;
  const auto num_pixel_bytes = static_cast<std::uintmax_t>(header.columns) *
                               static_cast<std::uintmax_t>(header.rows) *
                               static_cast<std::uintmax_t>(bits_allocated) / 8;
  std::error_code failure;
  const auto num_bytes = std::filesystem::file_size(path, failure);
  constexpr std::uintmax_t kMaxHeaderBytes = 64 << 20;
  if (failure || num_bytes < num_pixel_bytes) return true;
  // The pixels' tag and length must end in what the file has beside as many bytes.
  std::string start(std::min(num_bytes - num_pixel_bytes, kMaxHeaderBytes), '\0');
  std::ifstream(path, std::ios::binary)
      .read(start.data(), static_cast<std::streamsize>(start.size()));
  constexpr std::size_t kTagAndLength = 8;
  constexpr std::size_t kTagTypeAndLength = 12;
  const auto little = start.rfind("\xe0\x7f\x10\x00"s);
  const auto big = start.rfind("\x7f\xe0\x00\x10"s);
  const auto at = little != std::string::npos ? little : big;
  if (at == std::string::npos || at + kTagAndLength > start.size()) return true;
  const bool has_type = start[at + 4] == 'O';
  return at + (has_type ? kTagTypeAndLength : kTagAndLength) > start.size();
}

}  // namespace

std::optional<DicomHeader> read_dicom_header(const std::filesystem::path& path) {
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  if (!reader.CanRead()) return std::nullopt;
  if (!reader.ReadUpToTag(kPixelData)) return std::nullopt;
  gdcm::StringFilter filter;
  filter.SetFile(reader.GetFile());
  const auto& data_set = reader.GetFile().GetDataSet();
  const auto text = [&](const gdcm::Tag& tag) {
    return data_set.FindDataElement(tag) ? trimmed(filter.ToString(tag)) : std::string();
  };
  DicomHeader header;
  header.path = path;
  header.series_uid = text(kSeriesUid);
  header.series_description = text(kSeriesDescription);
  header.patient_id = text(kPatientId);
  header.modality = text(kModality);
  header.image_type = text(kImageType);
  header.columns = count_of(text(kColumns), 0);
  header.rows = count_of(text(kRows), 0);
  header.pixels_cut_short = lacks_pixels(reader, path, header, count_of(text(kBitsAllocated), 16));
  header.samples_per_pixel = count_of(text(kSamplesPerPixel), 1);
  header.num_frames = count_of(text(kNumFrames), 1);
  header.has_pixels = header.columns > 0 && header.rows > 0;
  if (const auto position = numbers_of(text(kPosition)); position.size() == 3)
    header.position_mm = Eigen::Vector3d(position[0], position[1], position[2]);
  header.axes = axes_of(text(kOrientation));
  // Pixel Spacing comes as rows' distance first, that is down a column.
  if (const auto spacing = numbers_of(text(kPixelSpacing)); spacing.size() == 2)
    header.spacing_mm = {spacing[1], spacing[0]};
  return header;
}

}  // namespace mor::import
