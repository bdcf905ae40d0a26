// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dicom_header.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include <gdcmReader.h>
#include <gdcmStringFilter.h>
#include <gdcmTag.h>

namespace mor::import {
namespace {

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
