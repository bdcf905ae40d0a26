// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "slice_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <optional>
#include <string_view>
#include <utility>

#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>

#include "byte_order.h"
#include "jpeg_stream.h"
#include "messages.h"
#include "rle_pixels.h"

namespace mor::import {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::int16_t kAirHu = -1024;

std::size_t num_bytes_of(const DicomSlice& slice) {
  return static_cast<std::size_t>(slice.columns) * static_cast<std::size_t>(slice.rows) *
         static_cast<std::size_t>(slice.meaning.bits_allocated / 8);
}

tl::unexpected<Error> damaged(const DicomSlice& slice) {
  return make_error(ErrorCode::kIo,
                    slice.name + " has damaged or missing pixels: copy the series again");
}

constexpr std::string_view kRle = "1.2.840.10008.1.2.5";
constexpr std::array<std::string_view, 4> kJpeg = {"1.2.840.10008.1.2.4.50",
                                                   "1.2.840.10008.1.2.4.51",
                                                   "1.2.840.10008.1.2.4.57",
                                                   "1.2.840.10008.1.2.4.70"};
constexpr std::array<std::string_view, 4> kJpegLsAnd2000 = {"1.2.840.10008.1.2.4.80",
                                                            "1.2.840.10008.1.2.4.81",
                                                            "1.2.840.10008.1.2.4.90",
                                                            "1.2.840.10008.1.2.4.91"};

bool is_one_of(std::string_view transfer_syntax, std::span<const std::string_view> some) {
  return std::find(some.begin(), some.end(), transfer_syntax) != some.end();
}

bool is_read(std::string_view transfer_syntax) {
  return transfer_syntax == kRle || is_one_of(transfer_syntax, kJpeg) ||
         is_one_of(transfer_syntax, kJpegLsAnd2000);
}

/// The fragments of one frame: each frame has one, or the offset table says where each begins.
/// None: damaged.
std::vector<Bytes> fragments_of(const DicomElement& pixels, const DicomSlice& slice) {
  if (pixels.fragments.size() < 2) return {};
  const std::vector<Bytes> all(pixels.fragments.begin() + 1, pixels.fragments.end());
  const auto frame = static_cast<std::size_t>(slice.frame);
  const auto num_frames = static_cast<std::size_t>(slice.num_frames);
  if (num_frames == 1) return all;
  if (all.size() == num_frames) return {all[frame]};
  const Bytes offsets = pixels.fragments.front();
  if (offsets.size() != 4 * num_frames) return {};
  const std::uint32_t begin = little_uint32(offsets.subspan(4 * frame));
  const std::uint32_t end =
      frame + 1 < num_frames ? little_uint32(offsets.subspan(4 * frame + 4)) : UINT32_MAX;
  std::vector<Bytes> some;
  std::uint64_t at = 0;
  for (const Bytes& fragment : all) {
    if (at >= begin && at < end) some.push_back(fragment);
    constexpr std::uint64_t kTagAndLength = 8;
    at += kTagAndLength + fragment.size();
  }
  return some;
}

/// Through GDCM's decoders, which get nothing but the compressed bytes and the picture's size.
std::optional<std::vector<std::byte>> decoded_by_gdcm(Bytes stream,
                                                      const std::string& transfer_syntax,
                                                      const DicomSlice& slice) {
  gdcm::Fragment fragment;
  fragment.SetByteValue(reinterpret_cast<const char*>(stream.data()),
                        gdcm::VL(static_cast<std::uint32_t>(stream.size())));
  const auto sequence = gdcm::SequenceOfFragments::New();
  sequence->AddFragment(fragment);
  gdcm::DataElement pixels(gdcm::Tag(0x7fe0, 0x0010));
  pixels.SetVR(gdcm::VR::OB);
  pixels.SetValue(*sequence);
  gdcm::Image image;
  image.SetNumberOfDimensions(2);
  image.SetDimension(0, static_cast<unsigned>(slice.columns));
  image.SetDimension(1, static_cast<unsigned>(slice.rows));
  const auto& meaning = slice.meaning;
  // All bits up to the highest: GDCM ends the process where that is not the last of the stored.
  image.SetPixelFormat(gdcm::PixelFormat(1,
                                         static_cast<unsigned short>(meaning.bits_allocated),
                                         static_cast<unsigned short>(meaning.high_bit + 1),
                                         static_cast<unsigned short>(meaning.high_bit),
                                         meaning.is_signed ? 1 : 0));
  image.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
  image.SetTransferSyntax(gdcm::TransferSyntax::GetTSType(transfer_syntax.c_str()));
  image.SetDataElement(pixels);
  std::vector<std::byte> result(num_bytes_of(slice));
  try {
    if (image.GetBufferLength() == result.size() &&
        image.GetBuffer(reinterpret_cast<char*>(result.data())))
      return result;
  } catch (const std::exception&) {
    // What the decoder did not like does not help who has the file.
  }
  return {};
}

/// What one frame's fragments hold together. Nothing: damaged.
std::optional<std::vector<std::byte>> decoded(const std::vector<Bytes>& fragments,
                                              const std::string& transfer_syntax,
                                              const DicomSlice& slice) {
  std::vector<std::byte> stream;
  for (const Bytes& bytes : fragments) stream.insert(stream.end(), bytes.begin(), bytes.end());
  if (transfer_syntax == kRle) {
    const auto bytes_per_pixel = static_cast<std::size_t>(slice.meaning.bits_allocated / 8);
    return decode_rle(stream, num_bytes_of(slice) / bytes_per_pixel, bytes_per_pixel);
  }
  if (is_one_of(transfer_syntax, kJpeg)) {
    auto checked = checked_jpeg(stream, slice.columns, slice.rows);
    if (!checked) return {};
    stream = std::move(*checked);
  }
  return decoded_by_gdcm(stream, transfer_syntax, slice);
}

}  // namespace

Result<void> SliceReader::open(const DicomSlice& slice) {
  if (open_file_ == slice.file) return {};
  open_file_.reset();
  say_file(slice.name);
  const auto name_it = [&](Error error) {
    error.message = slice.name + " " + error.message;
    return error;
  };
  MOR_TRY(bytes_, files_.load(slice.file).map_error(name_it));
  MOR_TRY(file_, parse_dicom(bytes_.bytes).map_error(name_it));
  open_file_ = slice.file;
  return {};
}

Result<std::vector<std::byte>> SliceReader::stored_pixels(const DicomSlice& slice) const {
  const auto* pixels = file_.data.find(Tag::kPixelData);
  if (pixels == nullptr) return damaged(slice);
  if (file_.is_encapsulated) {
    if (!is_read(file_.transfer_syntax)) {
      return make_error(ErrorCode::kUnsupported,
                        slice.name + " is compressed in a way that is not read (transfer syntax " +
                            file_.transfer_syntax + "): export it uncompressed");
    }
    auto result = decoded(fragments_of(*pixels, slice), file_.transfer_syntax, slice);
    if (!result) return damaged(slice);
    return *std::move(result);
  }
  const std::size_t num_bytes = num_bytes_of(slice);
  if (pixels->value.size() / static_cast<std::size_t>(slice.num_frames) < num_bytes)
    return damaged(slice);
  const Bytes stored =
      pixels->value.subspan(static_cast<std::size_t>(slice.frame) * num_bytes, num_bytes);
  std::vector<std::byte> result(stored.begin(), stored.end());
  if (file_.data.big_endian && slice.meaning.bits_allocated == 16)
    for (std::size_t i = 0; i + 1 < result.size(); i += 2) std::swap(result[i], result[i + 1]);
  return result;
}

void SliceReader::make_table(const PixelMeaning& meaning) {
  if (table_of_ == meaning) return;
  table_of_ = meaning;
  table_.resize(std::size_t{1} << meaning.bits_allocated);
  const std::int32_t range = 1 << meaning.bits_stored;
  for (std::size_t stored = 0; stored < table_.size(); ++stored) {
    auto number = static_cast<std::int32_t>(stored >> (meaning.high_bit + 1 - meaning.bits_stored));
    number &= range - 1;
    if (meaning.is_signed && number >= range / 2) number -= range;
    const bool is_padding =
        meaning.padding_low && number >= *meaning.padding_low && number <= meaning.padding_high;
    const double hu = number * meaning.slope + meaning.intercept;
    table_[stored] =
        is_padding ? kAirHu
                   : static_cast<std::int16_t>(std::lround(std::clamp(hu, -32768.0, 32767.0)));
  }
}

Result<std::vector<std::int16_t>> SliceReader::read_hu(const DicomSlice& slice) {
  MOR_CHECK(open(slice));
  MOR_TRY(const auto stored, stored_pixels(slice));
  make_table(slice.meaning);
  const std::size_t step = static_cast<std::size_t>(slice.meaning.bits_allocated) / 8;
  std::vector<std::int16_t> hu(stored.size() / step);
  for (std::size_t i = 0; i < hu.size(); ++i) {
    auto number = std::to_integer<std::size_t>(stored[i * step]);
    if (step == 2) number |= std::to_integer<std::size_t>(stored[i * step + 1]) << 8;
    hu[i] = table_[number];
  }
  return hu;
}

}  // namespace mor::import
