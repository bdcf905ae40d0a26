// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dicom_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <utility>

#include "inflate.h"

namespace mor::import {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::uint32_t kUndefinedLength = 0xffff'ffff;
constexpr std::uint32_t kItem = 0xfffe'e000;
constexpr std::uint32_t kItemEnd = 0xfffe'e00d;
constexpr std::uint32_t kSequenceEnd = 0xfffe'e0dd;
constexpr std::size_t kPreambleBytes = 128;
constexpr std::size_t kMaxItems = 200000;  ///< Ten times the frames of the largest CT.

constexpr std::array kWanted = {Tag::kStructureRois,
                                Tag::kRoiNumber,
                                Tag::kRoiName,
                                Tag::kRoiColor,
                                Tag::kRoiContours,
                                Tag::kContours,
                                Tag::kContourType,
                                Tag::kContourData,
                                Tag::kReferencedRoi,
                                Tag::kReferencedFileId,
                                Tag::kFrameOfReferenceUid,
                                Tag::kDirectoryRecords,
                                Tag::kImageType,
                                Tag::kSopInstanceUid,
                                Tag::kModality,
                                Tag::kSeriesDescription,
                                Tag::kPatientId,
                                Tag::kSliceThickness,
                                Tag::kPatientPosition,
                                Tag::kFrameTypes,
                                Tag::kFrameType,
                                Tag::kSeriesUid,
                                Tag::kSeriesNumber,
                                Tag::kAcquisitionNumber,
                                Tag::kPosition,
                                Tag::kOrientation,
                                Tag::kPlanePositions,
                                Tag::kPlaneOrientations,
                                Tag::kSamplesPerPixel,
                                Tag::kNumFrames,
                                Tag::kRows,
                                Tag::kColumns,
                                Tag::kPixelSpacing,
                                Tag::kBitsAllocated,
                                Tag::kBitsStored,
                                Tag::kHighBit,
                                Tag::kPixelRepresentation,
                                Tag::kPaddingValue,
                                Tag::kPaddingLimit,
                                Tag::kRescaleIntercept,
                                Tag::kRescaleSlope,
                                Tag::kLossy,
                                Tag::kPixelMeasures,
                                Tag::kPixelValues,
                                Tag::kSegmentationType,
                                Tag::kSegments,
                                Tag::kSegmentNumber,
                                Tag::kSegmentLabel,
                                Tag::kSegmentIdentification,
                                Tag::kReferencedSegment,
                                Tag::kSegmentColor,
                                Tag::kMaxFraction,
                                Tag::kSharedGroups,
                                Tag::kFrameGroups,
                                Tag::kPixelData};

bool is_wanted(Tag tag) {
  return std::find(kWanted.begin(), kWanted.end(), tag) != kWanted.end();
}

/// Where the encoding does not say it (implicit VR).
bool is_sequence(Tag tag) {
  return tag == Tag::kDirectoryRecords || tag == Tag::kFrameTypes || tag == Tag::kPlanePositions ||
         tag == Tag::kPlaneOrientations || tag == Tag::kPixelMeasures || tag == Tag::kPixelValues ||
         tag == Tag::kSharedGroups || tag == Tag::kFrameGroups || tag == Tag::kSegments ||
         tag == Tag::kSegmentIdentification || tag == Tag::kStructureRois ||
         tag == Tag::kRoiContours || tag == Tag::kContours;
}

bool has_long_length(std::string_view type) {
  constexpr std::array<std::string_view, 13> kLong = {
      "OB", "OD", "OF", "OL", "OV", "OW", "SQ", "SV", "UC", "UN", "UR", "UT", "UV"};
  return std::find(kLong.begin(), kLong.end(), type) != kLong.end();
}

struct Encoding {
  bool is_explicit = true;
  bool big_endian = false;
};

/// Reads elements one after the other; nothing is read beyond the end of its bytes.
class Parser {
 public:
  Parser(Bytes bytes, Encoding encoding) : bytes_(bytes), encoding_(encoding) {}

  /// Until the end, or up to and with the pixels.
  Result<void> read_top(DicomDataSet& data) {
    data.big_endian = encoding_.big_endian;
    bool is_last = false;
    while (!is_last && left() > 0) MOR_CHECK(read_element(data, encoding_, 0, is_last));
    return {};
  }

  /// The elements of group 2, which are always explicit little endian.
  Result<std::string> read_meta_group() {
    std::string transfer_syntax;
    while (left() >= 8 && uint16_at(at_, false) == 2) {
      MOR_TRY(const Header header, read_header({}));
      if (header.length > left()) return cut_short();
      constexpr std::uint32_t kTransferSyntax = 0x0002'0010;
      if (header.tag == kTransferSyntax)
        transfer_syntax = text_of(bytes_.subspan(at_, header.length));
      at_ += header.length;
    }
    return transfer_syntax;
  }

  [[nodiscard]] std::size_t at() const { return at_; }

  static std::string text_of(Bytes value) {
    std::string_view text(reinterpret_cast<const char*>(value.data()), value.size());
    const auto end = text.find_last_not_of(std::string_view(" \0", 2));
    if (end == std::string_view::npos) return {};
    text = text.substr(0, end + 1);
    return std::string(text.substr(std::min(text.find_first_not_of(' '), text.size())));
  }

 private:
  struct Header {
    std::uint32_t tag = 0;
    std::uint32_t length = 0;
    bool is_sequence = false;
    bool is_unknown = false;
  };

  [[nodiscard]] tl::unexpected<Error> cut_short() const {
    return make_error(ErrorCode::kIo,
                      "is cut short or damaged (at byte " + std::to_string(at_) + " of " +
                          std::to_string(bytes_.size()) + ")");
  }

  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }
  [[nodiscard]] std::uint32_t byte_at(std::size_t place) const {
    return std::to_integer<std::uint32_t>(bytes_[place]);
  }
  [[nodiscard]] std::uint32_t uint16_at(std::size_t place, bool big) const {
    const std::uint32_t a = byte_at(place);
    const std::uint32_t b = byte_at(place + 1);
    return big ? a << 8 | b : b << 8 | a;
  }
  [[nodiscard]] std::uint32_t uint32_at(std::size_t place, bool big) const {
    const std::uint32_t a = uint16_at(place, big);
    const std::uint32_t b = uint16_at(place + 2, big);
    return big ? a << 16 | b : b << 16 | a;
  }

  /// Tag, type and length; leaves the place at the value.
  Result<Header> read_header(Encoding encoding) {
    const bool big = encoding.big_endian;
    if (left() < 8) return cut_short();
    Header header;
    header.tag = uint16_at(at_, big) << 16 | uint16_at(at_ + 2, big);
    header.is_sequence = is_sequence(static_cast<Tag>(header.tag));
    if (!encoding.is_explicit || header.tag >> 16 == 0xfffe) {
      header.length = uint32_at(at_ + 4, big);
      at_ += 8;
      return header;
    }
    const std::string_view type(reinterpret_cast<const char*>(bytes_.data()) + at_ + 4, 2);
    if (type[0] < 'A' || type[0] > 'Z' || type[1] < 'A' || type[1] > 'Z') return cut_short();
    header.is_sequence = type == "SQ";
    header.is_unknown = type == "UN";
    if (!has_long_length(type)) {
      header.length = uint16_at(at_ + 6, big);
      at_ += 8;
      return header;
    }
    if (left() < 12) return cut_short();
    header.length = uint32_at(at_ + 8, big);
    at_ += 12;
    return header;
  }

  Result<void> read_element(DicomDataSet& data, Encoding encoding, int nesting, bool& is_last) {
    MOR_TRY(const Header header, read_header(encoding));
    const Tag tag = static_cast<Tag>(header.tag);
    DicomElement element{tag, {}, {}, {}};
    const bool is_pixels = tag == Tag::kPixelData && nesting == 0;
    if (is_pixels && header.length == kUndefinedLength) {
      MOR_CHECK(read_fragments(element));
    } else if (header.is_sequence || header.length == kUndefinedLength) {
      // An unknown type of unknown length is a sequence with the types left out.
      if (header.is_unknown) encoding = {false, false};
      MOR_CHECK(read_items(element, header.length, encoding, nesting + 1));
    } else {
      if (header.length > left()) return cut_short();
      element.value = bytes_.subspan(at_, header.length);
      at_ += header.length;
    }
    if (is_wanted(tag)) data.elements.push_back(std::move(element));
    is_last = is_pixels;
    return {};
  }

  Result<void> read_items(DicomElement& sequence,
                          std::uint32_t length,
                          Encoding encoding,
                          int nesting) {
    if (nesting > kMaxDicomNesting) {
      return make_error(
          ErrorCode::kInvalidArgument,
          "nests sequences deeper than " + std::to_string(kMaxDicomNesting) + " levels");
    }
    if (length != kUndefinedLength && length > left()) return cut_short();
    const std::size_t end = length == kUndefinedLength ? bytes_.size() : at_ + length;
    const bool keep = is_wanted(sequence.tag);
    while (at_ < end) {
      MOR_TRY(const Header item, read_header(encoding));
      if (item.tag == kSequenceEnd) return {};
      if (item.tag != kItem) return cut_short();
      if (++num_items_ > kMaxItems) return cut_short();
      DicomDataSet data;
      MOR_CHECK(read_item(data, item.length, encoding, nesting));
      if (keep) sequence.items.push_back(std::move(data));
    }
    return length == kUndefinedLength ? Result<void>(cut_short()) : Result<void>();
  }

  Result<void> read_item(DicomDataSet& data, std::uint32_t length, Encoding encoding, int nesting) {
    data.big_endian = encoding.big_endian;
    if (length != kUndefinedLength && length > left()) return cut_short();
    const std::size_t end = length == kUndefinedLength ? bytes_.size() : at_ + length;
    bool is_last = false;
    while (at_ < end) {
      if (left() < 8) return cut_short();
      const bool big = encoding.big_endian;
      if ((uint16_at(at_, big) << 16 | uint16_at(at_ + 2, big)) == kItemEnd) {
        at_ += 8;
        return {};
      }
      MOR_CHECK(read_element(data, encoding, nesting, is_last));
    }
    return length == kUndefinedLength ? Result<void>(cut_short()) : Result<void>();
  }

  Result<void> read_fragments(DicomElement& pixels) {
    for (;;) {
      MOR_TRY(const Header header, read_header(encoding_));
      if (header.tag == kSequenceEnd) return {};
      if (header.tag != kItem || header.length > left()) return cut_short();
      if (++num_items_ > kMaxItems) return cut_short();
      pixels.fragments.push_back(bytes_.subspan(at_, header.length));
      at_ += header.length;
    }
  }

  Bytes bytes_;
  Encoding encoding_;
  std::size_t at_ = 0;
  std::size_t num_items_ = 0;
};

bool says_dicom(Bytes bytes) {
  return bytes.size() >= kPreambleBytes + 4 &&
         std::memcmp(bytes.data() + kPreambleBytes, "DICM", 4) == 0;
}

/// Old files have neither preamble nor group 2: they begin with a small element of group 8.
std::optional<Encoding> encoding_without_preamble(Bytes bytes) {
  if (bytes.size() < 16) return std::nullopt;
  const auto at = [&](std::size_t i) { return std::to_integer<unsigned>(bytes[i]); };
  if (at(0) != 8 || at(1) != 0 || at(3) != 0 || at(2) > 0x70) return std::nullopt;
  const auto is_letter = [](unsigned c) { return c >= 'A' && c <= 'Z'; };
  if (is_letter(at(4)) && is_letter(at(5))) return Encoding{true, false};
  if (at(6) != 0 || at(7) != 0) return std::nullopt;
  return Encoding{false, false};
}

constexpr std::string_view kDeflated = "1.2.840.10008.1.2.1.99";

/// Everything but the oldest two is explicit little endian, the compressed ones too.
Encoding encoding_of(const std::string& transfer_syntax) {
  return {!(transfer_syntax == "1.2.840.10008.1.2" || transfer_syntax.empty()),
          transfer_syntax == "1.2.840.10008.1.2.2"};
}

Result<DicomFile> parse_without_preamble(Bytes bytes) {
  const auto no_dicom = make_error(ErrorCode::kUnsupported, "is no DICOM file");
  const auto encoding = encoding_without_preamble(bytes);
  if (!encoding) return no_dicom;
  DicomFile file;
  file.transfer_syntax = encoding->is_explicit ? "1.2.840.10008.1.2.1" : "1.2.840.10008.1.2";
  if (!Parser(bytes, *encoding).read_top(file.data)) return no_dicom;
  return file;
}

}  // namespace

const DicomElement* DicomDataSet::find(Tag tag) const {
  const auto found = std::find_if(
      elements.begin(), elements.end(), [&](const DicomElement& e) { return e.tag == tag; });
  return found == elements.end() ? nullptr : &*found;
}

const DicomDataSet* DicomDataSet::item(Tag sequence) const {
  const auto* element = find(sequence);
  return element == nullptr || element->items.empty() ? nullptr : &element->items.front();
}

std::string DicomDataSet::text(Tag tag) const {
  const auto* element = find(tag);
  return element == nullptr ? std::string() : Parser::text_of(element->value);
}

std::vector<double> DicomDataSet::numbers(Tag tag) const {
  const std::string all = text(tag);
  std::vector<double> numbers;
  for (std::size_t start = 0; start <= all.size() && !all.empty();) {
    const auto end = std::min(all.find('\\', start), all.size());
    const std::string word = all.substr(start, end - start);
    char* stop = nullptr;
    const double number = std::strtod(word.c_str(), &stop);
    const bool is_whole =
        stop != word.c_str() &&
        word.find_first_not_of(' ', static_cast<std::size_t>(stop - word.c_str())) ==
            std::string::npos;
    if (!is_whole || !std::isfinite(number)) return {};
    numbers.push_back(number);
    start = end + 1;
  }
  return numbers;
}

std::optional<std::uint16_t> DicomDataSet::uint16(Tag tag) const {
  const auto* element = find(tag);
  if (element == nullptr || element->value.size() != 2) return std::nullopt;
  return uint16_at(tag, 0);
}

std::optional<std::uint16_t> DicomDataSet::uint16_at(Tag tag, std::size_t index) const {
  const auto* element = find(tag);
  if (element == nullptr || element->value.size() < 2 * (index + 1)) return std::nullopt;
  const auto a = std::to_integer<unsigned>(element->value[2 * index]);
  const auto b = std::to_integer<unsigned>(element->value[2 * index + 1]);
  return static_cast<std::uint16_t>(big_endian ? a << 8 | b : b << 8 | a);
}

Result<DicomFile> parse_dicom(Bytes bytes) {
  if (!says_dicom(bytes)) return parse_without_preamble(bytes);
  Bytes rest = bytes.subspan(kPreambleBytes + 4);
  Parser meta(rest, {});
  DicomFile file;
  MOR_TRY(file.transfer_syntax, meta.read_meta_group());
  rest = rest.subspan(meta.at());
  const std::string& syntax = file.transfer_syntax;
  if (syntax == kDeflated) {
    MOR_TRY(file.inflated, inflate_raw(rest));
    rest = file.inflated;
  }
  MOR_CHECK(Parser(rest, encoding_of(syntax)).read_top(file.data));
  const auto* pixels = file.data.find(Tag::kPixelData);
  file.is_encapsulated = pixels != nullptr && !pixels->fragments.empty();
  return file;
}

std::string series_uid_of_damaged(Bytes bytes) {
  if (!says_dicom(bytes)) return {};
  const Bytes rest = bytes.subspan(kPreambleBytes + 4);
  Parser meta(rest, {});
  const auto syntax = meta.read_meta_group();
  if (!syntax || *syntax == kDeflated) return {};
  DicomDataSet data;
  (void)Parser(rest.subspan(meta.at()), encoding_of(*syntax)).read_top(data);
  return data.text(Tag::kSeriesUid);
}

}  // namespace mor::import
