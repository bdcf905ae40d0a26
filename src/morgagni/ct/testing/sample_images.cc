// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// NIfTI, NRRD and MetaImage files of 4 x 3 x 2 voxels, each a way of writing them down.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <stdexcept>

#include <zlib.h>

#include "morgagni/ct/testing/sample_parts.h"

namespace mor::testing_files {
namespace {

constexpr std::size_t kNumVoxels = 4 * 3 * 2;
constexpr const char* kVoxelsInWords =
    "0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23\n";

/// A number in either byte order.
template <class T>
std::string word(T value, bool big_endian = false) {
  std::string bytes;
  append(bytes, value);
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

template <class T>
std::string voxels(bool big_endian = false) {
  std::string bytes;
  for (std::size_t i = 0; i < kNumVoxels; ++i) bytes += word(static_cast<T>(i), big_endian);
  return bytes;
}

/// @param window_bits  As for zlib: 31 for gzip, 15 for a zlib stream.
std::string deflated(const std::string& bytes, int window_bits) {
  z_stream stream{};
  std::string packed(bytes.size() + 256, '\0');
  if (::deflateInit2(
          &stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("zlib does not start");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const int status = ::deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  ::deflateEnd(&stream);
  if (status != Z_STREAM_END) throw std::runtime_error("zlib does not end");
  return packed;
}

/// How a NIfTI file is written.
struct NiftiStyle {
  std::int16_t type = 4;
  bool big_endian = false;
  bool by_quaternion = false;  ///< Where it lies: else by three rows.
  float slope = 1.0F;
  std::string extension = {};  ///< Of a multiple of 16 bytes, with its own head of 8.
};

class NiftiWriter {
 public:
  explicit NiftiWriter(NiftiStyle style) : style_(std::move(style)) {}

  std::string file(const std::string& stored) {
    bits_ = static_cast<std::int16_t>(stored.size() / kNumVoxels * 8);
    write_head();
    std::string flag(4, '\0');
    if (!style_.extension.empty()) flag[0] = 1;
    return bytes_ + flag + style_.extension + stored;
  }

 private:
  template <class T>
  void put(std::size_t at, T value) {
    const std::string stored = word(value, style_.big_endian);
    std::copy(stored.begin(), stored.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(at));
  }
  template <class T, std::size_t n>
  void put_all(std::size_t at, const std::array<T, n>& values) {
    for (std::size_t i = 0; i < n; ++i) put(at + i * sizeof(T), values[i]);
  }

  void write_head() {
    bytes_.assign(348, '\0');
    put(0, std::int32_t{348});
    put_all(40, std::array<std::int16_t, 8>{3, 4, 3, 2, 1, 1, 1, 1});
    put(70, style_.type);
    put(72, bits_);
    put_all(76, std::array<float, 8>{1, 1, 1, 2, 0, 0, 0, 0});
    put(108, 352.0F + static_cast<float>(style_.extension.size()));
    put(112, style_.slope);
    if (style_.by_quaternion) {
      put(252, std::int16_t{1});
      put_all(256, std::array<float, 6>{0, 0, 1, -7, 3, 5});
    } else {
      put(254, std::int16_t{1});
      put_all(280, std::array<float, 12>{1, 0, 0, -7, 0, 1, 0, 3, 0, 0, 2, 5});
    }
    std::memcpy(bytes_.data() + 344, "n+1", 4);
  }

  NiftiStyle style_;
  std::int16_t bits_ = 0;
  std::string bytes_;
};

/// Names of labels as a NIfTI extension (code 0: nobody's).
std::string label_table() {
  std::string text =
      "<CaretExtension><LabelTable><Label Key=\"1\" Red=\"0.5\" Green=\"0.2\" Blue=\"0.1\" "
      "Alpha=\"1\"><![CDATA[liver]]></Label></LabelTable></CaretExtension>";
  text.resize((text.size() + 8 + 15) / 16 * 16 - 8, ' ');
  return word(static_cast<std::int32_t>(text.size() + 8)) + word(std::int32_t{0}) + text;
}

template <class T>
SampleFile nifti(const std::string& name, NiftiStyle style) {
  const std::string stored = voxels<T>(style.big_endian);
  return {name + ".nii", NiftiWriter(std::move(style)).file(stored)};
}

const std::string kNrrdGrid =
    "dimension: 3\nsizes: 4 3 2\nspace: left-posterior-superior\n"
    "space directions: (1,0,0) (0,1,0) (0,0,2)\nspace origin: (-7,3,5)\n";

template <class T>
SampleFile nrrd(const std::string& name, const std::string& type, const std::string& lines = {}) {
  const bool big_endian = lines.find("endian: big") != std::string::npos;
  return {name + ".nrrd",
          "NRRD0004\ntype: " + type + "\nencoding: raw\n" +
              (big_endian || sizeof(T) == 1 ? "" : "endian: little\n") + kNrrdGrid + lines + "\n" +
              voxels<T>(big_endian)};
}

std::string in_hex(const std::string& bytes) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  for (const char byte : bytes) {
    text += kDigits[static_cast<unsigned char>(byte) >> 4U];
    text += kDigits[static_cast<unsigned char>(byte) & 15U];
  }
  return text;
}

/// A MetaImage's head up to the voxels.
std::string meta_head(const std::string& type, const std::string& lines = {}) {
  return "ObjectType = Image\nNDims = 3\n" + lines +
         "Offset = -7 3 5\nElementSpacing = 1 1 2\nDimSize = 4 3 2\nElementType = " + type +
         "\nElementDataFile = LOCAL\n";
}

const std::string kMetaPlain = "BinaryData = True\nBinaryDataByteOrderMSB = False\n";

}  // namespace

std::vector<SampleFile> nifti_samples() {
  const auto packed = [](const SampleFile& file) {
    return SampleFile{"packed_" + file.name + ".gz", deflated(file.bytes, 31)};
  };
  const auto plain = nifti<std::int16_t>("short", {});
  const auto names = nifti<std::uint8_t>("names", {.type = 2, .extension = label_table()});
  return {plain,
          packed(plain),
          names,
          packed(names),
          nifti<std::int16_t>("big_endian", {.big_endian = true}),
          nifti<std::int16_t>("quaternion", {.by_quaternion = true}),
          nifti<std::int16_t>("slope", {.slope = 2.0F}),
          nifti<std::int32_t>("int", {.type = 8}),
          nifti<float>("float", {.type = 16}),
          nifti<double>("double", {.type = 64}),
          nifti<std::int8_t>("char", {.type = 256}),
          nifti<std::uint16_t>("ushort", {.type = 512}),
          nifti<std::uint32_t>("uint", {.type = 768}),
          nifti<std::int64_t>("long", {.type = 1024})};
}

std::vector<SampleFile> nrrd_samples() {
  const std::string names =
      "Segment0_Name:=liver\nSegment0_LabelValue:=1\nSegment0_Color:=0.5 0.2 0.1\n";
  const std::string head = "NRRD0005\ntype: short\nendian: little\nencoding: ";
  return {
      nrrd<std::int16_t>("short", "short", names),
      nrrd<std::int16_t>("big_endian", "int16", "endian: big\n"),
      nrrd<std::uint8_t>("uchar", "uchar", "# a comment\nkinds: domain domain domain\n"),
      nrrd<std::int8_t>("char", "signed char", "content: made\n"),
      nrrd<std::uint16_t>("ushort", "unsigned short", "space units: \"mm\" \"mm\" \"mm\"\n"),
      nrrd<std::int32_t>("int", "int", "measurement frame: (1,0,0) (0,1,0) (0,0,1)\n"),
      nrrd<std::uint32_t>("uint", "uint32_t", "centerings: cell cell cell\n"),
      nrrd<float>("float", "float", "byte skip: -1\n"),
      nrrd<double>("double", "double", "min: 0\nmax: 23\nold min: 0\n"),
      nrrd<std::int64_t>("long", "longlong"),
      {"packed.nrrd",
       head + "gzip\n" + kNrrdGrid + names + "\n" + deflated(voxels<std::int16_t>(), 31)},
      {"hex.nrrd", head + "hex\n" + kNrrdGrid + "\n" + in_hex(voxels<std::int16_t>())},
      {"text.nrrd", "NRRD0004\ntype: short\nencoding: ascii\n" + kNrrdGrid + "\n" + kVoxelsInWords},
      {"spacings.nrrd",
       "NRRD0001\ntype: short\nencoding: raw\nendian: little\ndimension: 3\nsizes: 4 3 2\n"
       "spacings: 1 1 2\naxis mins: 0 0 0\nline skip: 1\n\nskipped\n" +
           voxels<std::int16_t>()}};
}

std::vector<SampleFile> meta_samples() {
  const std::string packed = deflated(voxels<std::int16_t>(), 15);
  const std::string packed_lines = kMetaPlain + "CompressedData = True\n";
  return {
      {"short.mha", meta_head("MET_SHORT", kMetaPlain) + voxels<std::int16_t>()},
      {"uchar.mha", meta_head("MET_UCHAR", kMetaPlain) + voxels<std::uint8_t>()},
      {"char.mha",
       meta_head("MET_CHAR", kMetaPlain + "AnatomicalOrientation = RAI\n") + voxels<std::int8_t>()},
      {"ushort.mha",
       meta_head("MET_USHORT", kMetaPlain + "TransformMatrix = 1 0 0 0 1 0 0 0 1\n") +
           voxels<std::uint16_t>()},
      {"int.mha",
       meta_head("MET_INT", kMetaPlain + "CenterOfRotation = 0 0 0\n") + voxels<std::int32_t>()},
      {"uint.mha", meta_head("MET_UINT", kMetaPlain) + voxels<std::uint32_t>()},
      {"long.mha", meta_head("MET_LONG_LONG", kMetaPlain) + voxels<std::int64_t>()},
      {"float.mha",
       meta_head("MET_FLOAT", kMetaPlain + "ElementMin = 0\nElementMax = 23\n") + voxels<float>()},
      {"double.mha",
       meta_head("MET_DOUBLE", kMetaPlain + "Comment = made\nColor = 1 0 0 1\n") +
           voxels<double>()},
      {"big_endian.mha",
       meta_head("MET_SHORT", "BinaryData = True\nBinaryDataByteOrderMSB = True\n") +
           voxels<std::int16_t>(true)},
      {"text.mha", meta_head("MET_SHORT", "BinaryData = False\n") + kVoxelsInWords},
      {"packed.mha",
       meta_head("MET_SHORT",
                 packed_lines + "CompressedDataSize = " + std::to_string(packed.size()) + "\n") +
           packed},
      {"packed_unsized.mha", meta_head("MET_SHORT", packed_lines) + packed}};
}

}  // namespace mor::testing_files
