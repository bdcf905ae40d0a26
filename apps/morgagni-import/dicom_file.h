// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "morgagni/core/result.h"

namespace mor::import {

/// The tags that Morgagni asks for: group << 16 | element. Everything else is passed over.
enum class Tag : std::uint32_t {
  kReferencedFileId = 0x0004'1500,
  kDirectoryRecords = 0x0004'1220,
  kImageType = 0x0008'0008,
  kSopInstanceUid = 0x0008'0018,
  kModality = 0x0008'0060,
  kSeriesDescription = 0x0008'103e,
  kPatientId = 0x0010'0020,
  kSliceThickness = 0x0018'0050,
  kPatientPosition = 0x0018'5100,
  kFrameTypes = 0x0018'9329,
  kFrameType = 0x0008'9007,
  kSeriesUid = 0x0020'000e,
  kSeriesNumber = 0x0020'0011,
  kAcquisitionNumber = 0x0020'0012,
  kPosition = 0x0020'0032,
  kOrientation = 0x0020'0037,
  kPlanePositions = 0x0020'9113,
  kPlaneOrientations = 0x0020'9116,
  kFrameOfReferenceUid = 0x0020'0052,
  kSamplesPerPixel = 0x0028'0002,
  kNumFrames = 0x0028'0008,
  kRows = 0x0028'0010,
  kColumns = 0x0028'0011,
  kPixelSpacing = 0x0028'0030,
  kBitsAllocated = 0x0028'0100,
  kBitsStored = 0x0028'0101,
  kHighBit = 0x0028'0102,
  kPixelRepresentation = 0x0028'0103,
  kPaddingValue = 0x0028'0120,
  kPaddingLimit = 0x0028'0121,
  kRescaleIntercept = 0x0028'1052,
  kRescaleSlope = 0x0028'1053,
  kLossy = 0x0028'2110,
  kPixelMeasures = 0x0028'9110,
  kPixelValues = 0x0028'9145,
  kStructureRois = 0x3006'0020,
  kRoiNumber = 0x3006'0022,
  kRoiName = 0x3006'0026,
  kRoiColor = 0x3006'002a,
  kRoiContours = 0x3006'0039,
  kContours = 0x3006'0040,
  kContourType = 0x3006'0042,
  kContourData = 0x3006'0050,
  kReferencedRoi = 0x3006'0084,
  kSegmentationType = 0x0062'0001,
  kSegments = 0x0062'0002,
  kSegmentNumber = 0x0062'0004,
  kSegmentLabel = 0x0062'0005,
  kSegmentIdentification = 0x0062'000a,
  kReferencedSegment = 0x0062'000b,
  kSegmentColor = 0x0062'000d,
  kMaxFraction = 0x0062'000e,
  kSharedGroups = 0x5200'9229,
  kFrameGroups = 0x5200'9230,
  kPixelData = 0x7fe0'0010,
};

struct DicomDataSet;

/// One element; what it holds still lies in the file's bytes.
struct DicomElement {
  Tag tag{};
  std::span<const std::byte> value;
  std::vector<DicomDataSet> items;                    ///< Of a sequence.
  std::vector<std::span<const std::byte>> fragments;  ///< Of compressed pixels, offsets first.
};

struct DicomDataSet {
  bool big_endian = false;
  std::vector<DicomElement> elements;

  [[nodiscard]] const DicomElement* find(Tag tag) const;
  /// The first item of a sequence; none where there is no such item.
  [[nodiscard]] const DicomDataSet* item(Tag sequence) const;
  /// Without the spaces around it; empty where there is none.
  [[nodiscard]] std::string text(Tag tag) const;
  /// "1.5\-2\3" as numbers; empty where there is none or one of them is no finite number.
  [[nodiscard]] std::vector<double> numbers(Tag tag) const;
  /// Of an element that holds a binary 16-bit number.
  [[nodiscard]] std::optional<std::uint16_t> uint16(Tag tag) const;
  /// Of an element that holds several: one of them.
  [[nodiscard]] std::optional<std::uint16_t> uint16_at(Tag tag, std::size_t index) const;
};

/// A parsed DICOM file. Spans point into the bytes it was parsed from, or into `inflated`.
struct DicomFile {
  std::string transfer_syntax;
  bool is_encapsulated = false;
  DicomDataSet data;
  std::vector<std::byte> inflated;  ///< The data set of a deflated file.
};

inline constexpr int kMaxDicomNesting = 64;

/// Parses a file up to its pixels, believing no length: what it holds must lie within `bytes`.
/// @errors kUnsupported: it is no DICOM file. kIo: it is cut short or damaged.
///         kInvalidArgument: sequences nested deeper than kMaxDicomNesting; a deflated one that
///         swells beyond reason.
[[nodiscard]] Result<DicomFile> parse_dicom(std::span<const std::byte> bytes);

/// The Series Instance UID of a file that is cut short behind it; empty where it is not to be
/// found.
[[nodiscard]] std::string series_uid_of_damaged(std::span<const std::byte> bytes);

}  // namespace mor::import
