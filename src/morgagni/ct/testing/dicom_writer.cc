// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/testing/dicom_writer.h"

#include <array>
#include <cstdio>
#include <utility>

#include <zlib.h>

namespace mor::testing_dicom {
namespace {

std::string numbers(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) {
    std::array<char, 32> word{};
    std::snprintf(word.data(), word.size(), "%.10g", value);
    if (!text.empty()) text += '\\';
    text += word.data();
  }
  return text;
}

std::string deflated(const std::string& bytes) {
  z_stream stream{};
  deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
  std::string result(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(result.data());
  stream.avail_out = static_cast<uInt>(result.size());
  deflate(&stream, Z_FINISH);
  result.resize(stream.total_out);
  deflateEnd(&stream);
  return result;
}

}  // namespace

DicomWriter::DicomWriter(std::string transfer_syntax)
    : transfer_syntax_(std::move(transfer_syntax)),
      is_explicit_(transfer_syntax_ != kImplicit),
      big_endian_(transfer_syntax_ == kBigEndian) {}

void DicomWriter::put16(std::uint32_t value) {
  const char low = static_cast<char>(value & 0xff);
  const char high = static_cast<char>(value >> 8 & 0xff);
  data_ += big_endian_ ? high : low;
  data_ += big_endian_ ? low : high;
}

void DicomWriter::put32(std::uint32_t value) {
  put16(big_endian_ ? value >> 16 : value & 0xffff);
  put16(big_endian_ ? value & 0xffff : value >> 16);
}

void DicomWriter::head(std::uint32_t tag, const char* type, std::uint32_t length) {
  put16(tag >> 16);
  put16(tag & 0xffff);
  const std::string name(type);
  if (!is_explicit_) {
    put32(length);
    return;
  }
  data_ += name;
  if (name == "OB" || name == "OW" || name == "SQ" || name == "UN") {
    put16(0);
    put32(length);
  } else {
    put16(length);
  }
}

void DicomWriter::text(std::uint32_t tag, const char* type, const std::string& value) {
  std::string even = value;
  if (even.size() % 2 != 0) even += std::string(type) == "UI" ? '\0' : ' ';
  raw(tag, type, static_cast<std::uint32_t>(even.size()), even);
}

void DicomWriter::number(std::uint32_t tag, std::uint16_t value) {
  head(tag, "US", 2);
  put16(value);
}

void DicomWriter::words(std::uint32_t tag, const std::vector<std::uint16_t>& values) {
  head(tag, "OW", static_cast<std::uint32_t>(2 * values.size()));
  for (const std::uint16_t value : values) put16(value);
}

void DicomWriter::raw(std::uint32_t tag,
                      const char* type,
                      std::uint32_t length,
                      const std::string& bytes) {
  head(tag, type, length);
  data_ += bytes;
}

void DicomWriter::sequence(std::uint32_t tag, const std::vector<std::string>& items) {
  std::uint32_t length = 0;
  for (const auto& item : items) length += 8 + static_cast<std::uint32_t>(item.size());
  head(tag, "SQ", length);
  for (const auto& item : items) {
    put16(0xfffe);
    put16(0xe000);
    put32(static_cast<std::uint32_t>(item.size()));
    data_ += item;
  }
}

std::string DicomWriter::file() const {
  DicomWriter meta;
  meta.text(0x0002'0010, "UI", transfer_syntax_);
  const std::string body = transfer_syntax_ == kDeflated ? deflated(data_) : data_;
  return std::string(128, '\0') + "DICM" + meta.data() + body;
}

std::string slice_file(const SliceText& slice) {
  DicomWriter out(slice.transfer_syntax);
  std::string uid = slice.sop_instance_uid;
  if (uid.empty()) {
    uid = slice.series_uid + "." + std::to_string(slice.acquisition_number) + "." +
          std::to_string(100000 + static_cast<int>(10 * slice.position_mm.sum()));
  }
  out.text(0x0008'0008, "CS", slice.image_type);
  out.text(0x0008'0016, "UI", "1.2.840.10008.5.1.4.1.1.2");
  out.text(0x0008'0018, "UI", uid);
  out.text(0x0008'0060, "CS", slice.modality);
  out.text(0x0008'103e, "LO", slice.series_description);
  out.text(0x0010'0020, "LO", "P1");
  out.text(0x0018'5100, "CS", slice.patient_position);
  out.text(0x0020'000d, "UI", "1.2");
  out.text(0x0020'000e, "UI", slice.series_uid);
  out.text(0x0020'0011, "IS", std::to_string(slice.series_number));
  out.text(0x0020'0012, "IS", std::to_string(slice.acquisition_number));
  out.text(0x0020'0052, "UI", slice.frame_of_reference_uid);
  if (slice.has_position) {
    const auto& p = slice.position_mm;
    const auto& a = slice.along_row;
    const auto& b = slice.down_column;
    out.text(0x0020'0032, "DS", numbers({p.x(), p.y(), p.z()}));
    out.text(0x0020'0037, "DS", numbers({a.x(), a.y(), a.z(), b.x(), b.y(), b.z()}));
  }
  out.number(0x0028'0002, 1);
  out.text(0x0028'0004, "CS", "MONOCHROME2");
  out.number(0x0028'0010, static_cast<std::uint16_t>(slice.rows));
  out.number(0x0028'0011, static_cast<std::uint16_t>(slice.columns));
  out.text(0x0028'0030, "DS", numbers({slice.row_spacing_mm, slice.column_spacing_mm}));
  out.number(0x0028'0100, 16);
  out.number(0x0028'0101, static_cast<std::uint16_t>(slice.bits_stored));
  out.number(0x0028'0102, static_cast<std::uint16_t>(slice.bits_stored - 1));
  out.number(0x0028'0103, slice.is_signed ? 1 : 0);
  if (slice.padding >= 0) out.number(0x0028'0120, static_cast<std::uint16_t>(slice.padding));
  out.text(0x0028'1052, "DS", slice.intercept);
  out.text(0x0028'1053, "DS", slice.slope);
  if (!slice.stored.empty()) out.words(0x7fe0'0010, slice.stored);
  return out.file();
}

}  // namespace mor::testing_dicom
