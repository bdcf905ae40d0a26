// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/testing/sample_files.h"

#include <array>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <stdexcept>

#include <zlib.h>

#include "morgagni/ct/testing/dicom_writer.h"

namespace mor::testing_files {
namespace {

using namespace testing_dicom;

constexpr int kColumns = 6;
constexpr int kRows = 5;
constexpr std::size_t kNumVoxels = 4 * 3 * 2;

template <class T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

template <class T>
std::string voxels() {
  std::string bytes;
  for (std::size_t i = 0; i < kNumVoxels; ++i) append(bytes, static_cast<T>(i));
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

SliceText slice_at(double height_mm, const char* syntax) {
  SliceText slice;
  slice.transfer_syntax = syntax;
  slice.columns = kColumns;
  slice.rows = kRows;
  slice.position_mm.z() = height_mm;
  for (std::uint16_t i = 0; i < kColumns * kRows; ++i)
    slice.stored.push_back(static_cast<std::uint16_t>(1000 + i));
  return slice;
}

/// Of the groups that a multi-frame file has for all frames.
std::string shared_groups(const char* syntax) {
  DicomWriter orientation(syntax);
  orientation.text(0x0020'0037, "DS", "1\\0\\0\\0\\1\\0");
  DicomWriter measures(syntax);
  measures.text(0x0028'0030, "DS", "1\\0.5");
  DicomWriter shared(syntax);
  shared.sequence(0x0020'9116, {orientation.data()});
  shared.sequence(0x0028'9110, {measures.data()});
  return shared.data();
}

std::string frame_groups(const char* syntax, int height_mm, std::uint16_t segment) {
  DicomWriter position(syntax);
  position.text(0x0020'0032, "DS", "4\\5\\" + std::to_string(height_mm));
  DicomWriter which(syntax);
  which.number(0x0062'000b, segment);
  DicomWriter frame(syntax);
  frame.sequence(0x0020'9113, {position.data()});
  if (segment > 0) frame.sequence(0x0062'000a, {which.data()});
  return frame.data();
}

/// An enhanced CT, or a segmentation of two segments.
std::string multi_frame_file(const char* syntax, bool is_segmentation) {
  constexpr std::uint16_t kNumFrames = 4;
  std::vector<std::string> frames;
  for (std::uint16_t i = 0; i < kNumFrames; ++i) {
    const auto segment = static_cast<std::uint16_t>(is_segmentation ? 1 + i % 2 : 0);
    frames.push_back(frame_groups(syntax, 2 * i, segment));
  }
  const std::uint16_t bits = is_segmentation ? 8 : 16;
  DicomWriter out(syntax);
  out.text(0x0008'0018, "UI", "1.2.3.4.5");
  out.text(0x0008'0060, "CS", is_segmentation ? "SEG" : "CT");
  out.text(0x0020'000e, "UI", "1.2.3");
  out.number(0x0028'0002, 1);
  out.text(0x0028'0008, "IS", std::to_string(kNumFrames));
  out.number(0x0028'0010, kRows);
  out.number(0x0028'0011, kColumns);
  out.number(0x0028'0100, bits);
  out.number(0x0028'0101, bits);
  out.number(0x0028'0102, static_cast<std::uint16_t>(bits - 1));
  out.number(0x0028'0103, 0);
  if (is_segmentation) {
    DicomWriter segment(syntax);
    segment.number(0x0062'0004, 1);
    segment.text(0x0062'0005, "LO", "liver");
    segment.words(0x0062'000d, {35580, 53661, 50857});
    out.text(0x0062'0001, "CS", "FRACTIONAL");
    out.sequence(0x0062'0002, {segment.data()});
    out.number(0x0062'000e, 255);
  }
  out.sequence(0x5200'9229, {shared_groups(syntax)});
  out.sequence(0x5200'9230, frames);
  const std::vector<std::uint16_t> pixels(
      static_cast<std::size_t>(kColumns * kRows * kNumFrames * bits / 16), 0x00f0);
  out.words(0x7fe0'0010, pixels);
  return out.file();
}

std::vector<SampleFile> dicom_files() {
  return {{"explicit.dcm", slice_file(slice_at(2, kExplicit))},
          {"implicit.dcm", slice_file(slice_at(2, kImplicit))},
          {"big_endian.dcm", slice_file(slice_at(2, kBigEndian))},
          {"deflated.dcm", slice_file(slice_at(2, kDeflated))},
          {"alone_frames.dcm", multi_frame_file(kExplicit, false)},
          {"alone_segments.dcm", multi_frame_file(kImplicit, true)}};
}

/// A NIfTI of either version, with a place and a direction.
std::string nifti_file(bool is_version_2, std::int16_t type, const std::string& stored) {
  std::string bytes(is_version_2 ? 544 : 352, '\0');
  const auto put = [&](std::size_t at, const auto& value) {
    std::memcpy(bytes.data() + at, &value, sizeof(value));
  };
  const auto bits = static_cast<std::int16_t>(stored.size() / kNumVoxels * 8);
  if (is_version_2) {
    put(0, std::int32_t{540});
    std::memcpy(bytes.data() + 4, "n+2\0\r\n\032\n", 8);
    put(12, type);
    put(14, bits);
    put(16, std::array<std::int64_t, 8>{3, 4, 3, 2, 1, 1, 1, 1});
    put(104, std::array<double, 8>{1, 1, 1, 2, 0, 0, 0, 0});
    put(168, std::int64_t{544});
  } else {
    put(0, std::int32_t{348});
    put(40, std::array<std::int16_t, 8>{3, 4, 3, 2, 1, 1, 1, 1});
    put(70, type);
    put(72, bits);
    put(76, std::array<float, 8>{1, 1, 1, 2, 0, 0, 0, 0});
    put(108, 352.0F);
    put(112, 1.0F);             // Slope.
    put(254, std::int16_t{1});  // sform: the three rows below.
    put(280, std::array<float, 12>{1, 0, 0, -7, 0, 1, 0, 3, 0, 0, 2, 5});
    std::memcpy(bytes.data() + 344, "n+1", 4);
  }
  return bytes + stored;
}

std::vector<SampleFile> nifti_files() {
  const std::string short_file = nifti_file(false, 4, voxels<std::int16_t>());
  return {{"short.nii", short_file},
          {"float.nii", nifti_file(false, 16, voxels<float>())},
          {"version_2.nii", nifti_file(true, 4, voxels<std::int16_t>())},
          {"packed.nii.gz", deflated(short_file, 31)}};
}

std::vector<SampleFile> nrrd_files() {
  const std::string grid =
      "endian: little\ndimension: 3\nsizes: 4 3 2\nspace: left-posterior-superior\n"
      "space directions: (1,0,0) (0,1,0) (0,0,2)\nspace origin: (-7,3,5)\n";
  const std::string names =
      "Segment0_Name:=liver\nSegment0_LabelValue:=1\nSegment0_Color:=0.5 0.2 0.1\n";
  return {{"short.nrrd",
           "NRRD0004\ntype: short\nencoding: raw\n" + grid + names + "\n" + voxels<std::int16_t>()},
          {"packed.nrrd",
           "NRRD0005\ntype: short\nencoding: gzip\n" + grid + "\n" +
               deflated(voxels<std::int16_t>(), 31)},
          {"text.nrrd",
           "NRRD0004\ntype: short\nencoding: ascii\n" + grid +
               "\n0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23\n"}};
}

std::vector<SampleFile> meta_files() {
  const std::string head =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
      "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = -7 3 5\nElementSpacing = 1 1 2\n"
      "DimSize = 4 3 2\n";
  const std::string packed = deflated(voxels<std::int16_t>(), 15);
  return {
      {"short.mha",
       head + "ElementType = MET_SHORT\nElementDataFile = LOCAL\n" + voxels<std::int16_t>()},
      {"float.mha", head + "ElementType = MET_FLOAT\nElementDataFile = LOCAL\n" + voxels<float>()},
      {"packed.mha",
       head + "CompressedData = True\nCompressedDataSize = " + std::to_string(packed.size()) +
           "\nElementType = MET_SHORT\nElementDataFile = LOCAL\n" + packed}};
}

// A tetrahedron, in three formats.
constexpr std::array<std::array<float, 3>, 4> kCorners = {
    {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}}};
constexpr std::array<std::array<std::uint32_t, 3>, 4> kFaces = {
    {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};

std::vector<SampleFile> ply_files() {
  const std::string counts =
      "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 4\nproperty list uchar int vertex_indices\nend_header\n";
  std::string binary = "ply\nformat binary_little_endian 1.0\ncomment SPACE=RAS\n" + counts;
  std::string text = "ply\nformat ascii 1.0\n" + counts;
  for (const auto& corner : kCorners) {
    append(binary, corner);
    for (const float value : corner) text += std::to_string(value) + ' ';
    text += '\n';
  }
  for (const auto& face : kFaces) {
    append(binary, std::uint8_t{3});
    append(binary, face);
    text += '3';
    for (const auto corner : face) text += ' ' + std::to_string(corner);
    text += '\n';
  }
  return {{"binary.ply", binary}, {"text.ply", text}};
}

std::vector<SampleFile> stl_files() {
  std::string binary(80, ' ');
  append(binary, std::uint32_t{kFaces.size()});
  std::string text = "solid made\n";
  for (const auto& face : kFaces) {
    append(binary, std::array<float, 3>{0, 0, 1});
    text += "facet normal 0 0 1\n outer loop\n";
    for (const auto corner : face) {
      append(binary, kCorners[corner]);
      text += "  vertex";
      for (const float value : kCorners[corner]) text += ' ' + std::to_string(value);
      text += '\n';
    }
    append(binary, std::uint16_t{0});
    text += " endloop\nendfacet\n";
  }
  return {{"binary.stl", binary}, {"text.stl", text + "endsolid made\n"}};
}

std::vector<SampleFile> obj_files() {
  std::string plain = "# SPACE=LPS\no made\n";
  for (const auto& corner : kCorners) {
    plain += "v";
    for (const float value : corner) plain += ' ' + std::to_string(value);
    plain += '\n';
  }
  std::string with_normals = plain + "vn 0 0 1\nvt 0.5 0.5\ng part\nusemtl skin\n";
  for (const auto& face : kFaces) {
    plain += 'f';
    with_normals += 'f';
    for (const auto corner : face) {
      plain += ' ' + std::to_string(corner + 1);
      with_normals += ' ' + std::to_string(corner + 1) + "/1/1";
    }
    plain += '\n';
    with_normals += '\n';
  }
  return {{"plain.obj", plain}, {"normals.obj", with_normals}};
}

}  // namespace

std::vector<SampleFile> sample_files(std::string_view format) {
  if (format == "dicom") return dicom_files();
  if (format == "nifti") return nifti_files();
  if (format == "nrrd") return nrrd_files();
  if (format == "mha") return meta_files();
  if (format == "ply") return ply_files();
  if (format == "stl") return stl_files();
  if (format == "obj") return obj_files();
  throw std::invalid_argument("no samples of " + std::string(format));
}

std::vector<SampleFile> sample_neighbours() {
  return {{"0", slice_file(slice_at(0, kExplicit))}, {"1", slice_file(slice_at(1, kExplicit))}};
}

}  // namespace mor::testing_files
