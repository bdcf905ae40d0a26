// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dicom_slice.h"

#include <algorithm>
#include <utility>

#include "morgagni/ct/import_protocol.h"

namespace mor::import {
namespace {

int count_of(const DicomDataSet& data, Tag tag, int otherwise) {
  const auto numbers = data.numbers(tag);
  const bool usable = !numbers.empty() && numbers[0] >= -1e6 && numbers[0] <= 1e6;
  return usable ? static_cast<int>(numbers[0]) : otherwise;
}

std::optional<Eigen::Matrix<double, 3, 2>> axes_of(const std::vector<double>& numbers) {
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

/// Padding is written in the pixels' own representation, whatever its type says.
std::optional<std::int32_t> padding_of(const DicomDataSet& data, Tag tag, bool is_signed) {
  const auto value = data.uint16(tag);
  if (!value) return std::nullopt;
  return is_signed ? static_cast<std::int16_t>(*value) : static_cast<std::int32_t>(*value);
}

PixelMeaning meaning_of(const DicomDataSet& data) {
  PixelMeaning meaning;
  meaning.bits_allocated = data.uint16(Tag::kBitsAllocated).value_or(16);
  meaning.bits_stored =
      data.uint16(Tag::kBitsStored).value_or(static_cast<std::uint16_t>(meaning.bits_allocated));
  meaning.high_bit =
      data.uint16(Tag::kHighBit).value_or(static_cast<std::uint16_t>(meaning.bits_stored - 1));
  meaning.is_signed = data.uint16(Tag::kPixelRepresentation).value_or(0) == 1;
  meaning.padding_low = padding_of(data, Tag::kPaddingValue, meaning.is_signed);
  meaning.padding_high = padding_of(data, Tag::kPaddingLimit, meaning.is_signed)
                             .value_or(meaning.padding_low.value_or(0));
  if (meaning.padding_low && *meaning.padding_low > meaning.padding_high)
    std::swap(*meaning.padding_low, meaning.padding_high);
  return meaning;
}

/// What a data set, or one of the groups that a multi-frame file has for all or for one frame, says
/// of a slice's place and numbers.
void take_geometry(const DicomDataSet& data, DicomSlice& slice) {
  if (const auto position = data.numbers(Tag::kPosition); position.size() == 3)
    slice.position_mm = Eigen::Vector3d(position[0], position[1], position[2]);
  if (data.find(Tag::kOrientation) != nullptr)
    slice.axes = axes_of(data.numbers(Tag::kOrientation));
  // Pixel Spacing comes as rows' distance first, that is down a column.
  if (const auto spacing = data.numbers(Tag::kPixelSpacing); spacing.size() == 2)
    slice.spacing_mm = {spacing[1], spacing[0]};
  if (const auto slope = data.numbers(Tag::kRescaleSlope); slope.size() == 1)
    slice.meaning.slope = slope[0];
  if (const auto intercept = data.numbers(Tag::kRescaleIntercept); intercept.size() == 1)
    slice.meaning.intercept = intercept[0];
}

void take_groups(const DicomDataSet& groups, DicomSlice& slice) {
  for (const Tag tag :
       {Tag::kPlanePositions, Tag::kPlaneOrientations, Tag::kPixelMeasures, Tag::kPixelValues}) {
    if (const auto* item = groups.item(tag)) take_geometry(*item, slice);
  }
  if (const auto* item = groups.item(Tag::kFrameTypes)) {
    if (const auto type = item->text(Tag::kFrameType); !type.empty()) slice.image_type = type;
  }
}

std::string flaw_of(const DicomSlice& slice) {
  if (slice.modality.empty()) return "it names no modality, so it is no CT slice";
  if (slice.modality != "CT") return "its modality is " + slice.modality + ", not CT";
  if (slice.image_type.find("LOCALIZER") != std::string::npos) return "it is a localizer";
  if (!slice.has_pixels) return "it has no pixels";
  if (!slice.position_mm || !slice.axes) return "it has no position in space";
  if (slice.samples_per_pixel != 1) return "it is a colour picture, a CT slice is grey";
  if (!(slice.spacing_mm.minCoeff() > 0.0))
    return "it has no pixel spacing above 0 mm and cannot be measured";
  if (std::max(slice.columns, slice.rows) > kMaxVolumeSide)
    return "it has " + std::to_string(slice.columns) + " x " + std::to_string(slice.rows) +
           " pixels, the limit is " + std::to_string(kMaxVolumeSide) + " a side";
  const auto& bits = slice.meaning;
  const bool is_read = (bits.bits_allocated == 8 || bits.bits_allocated == 16) &&
                       bits.bits_stored >= 1 && bits.bits_stored <= bits.high_bit + 1 &&
                       bits.high_bit < bits.bits_allocated;
  if (!is_read)
    return "it stores " + std::to_string(bits.bits_stored) + " of " +
           std::to_string(bits.bits_allocated) + " bits a pixel, which is not read";
  return {};
}

DicomSlice what_all_share(const DicomDataSet& data) {
  DicomSlice slice;
  slice.sop_instance_uid = data.text(Tag::kSopInstanceUid);
  slice.series_uid = data.text(Tag::kSeriesUid);
  slice.frame_of_reference_uid = data.text(Tag::kFrameOfReferenceUid);
  slice.series_description = data.text(Tag::kSeriesDescription);
  slice.patient_id = data.text(Tag::kPatientId);
  slice.patient_position = data.text(Tag::kPatientPosition);
  slice.modality = data.text(Tag::kModality);
  slice.image_type = data.text(Tag::kImageType);
  slice.series_number = count_of(data, Tag::kSeriesNumber, 0);
  slice.acquisition_number = count_of(data, Tag::kAcquisitionNumber, 0);
  slice.is_lossy = data.text(Tag::kLossy) == "01";
  slice.columns = data.uint16(Tag::kColumns).value_or(0);
  slice.rows = data.uint16(Tag::kRows).value_or(0);
  slice.samples_per_pixel = data.uint16(Tag::kSamplesPerPixel).value_or(1);
  slice.has_pixels = data.find(Tag::kPixelData) != nullptr && slice.columns > 0 && slice.rows > 0;
  slice.meaning = meaning_of(data);
  take_geometry(data, slice);
  if (const auto* shared = data.item(Tag::kSharedGroups)) take_groups(*shared, slice);
  return slice;
}

}  // namespace

std::vector<DicomSlice> slices_of(const DicomFile& file,
                                  std::size_t file_index,
                                  const std::string& name) {
  DicomSlice slice = what_all_share(file.data);
  slice.file = file_index;
  slice.name = name;
  const auto* frames = file.data.find(Tag::kFrameGroups);
  const int num_frames = count_of(file.data, Tag::kNumFrames, 1);
  if (frames == nullptr && num_frames == 1) {
    slice.flaw = flaw_of(slice);
    return {slice};
  }
  if (frames == nullptr || num_frames != static_cast<int>(frames->items.size())) {
    slice.flaw = "it holds several frames without saying where each lies";
    return {slice};
  }
  slice.num_frames = num_frames;
  std::vector<DicomSlice> slices(frames->items.size(), slice);
  for (std::size_t i = 0; i < slices.size(); ++i) {
    slices[i].frame = static_cast<int>(i);
    slices[i].name = name + " frame " + std::to_string(i + 1);
    take_groups(frames->items[i], slices[i]);
    slices[i].flaw = flaw_of(slices[i]);
  }
  return slices;
}

}  // namespace mor::import
