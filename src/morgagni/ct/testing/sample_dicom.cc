// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// Slices, frames and segmentations of 6 x 5 pixels, and structure sets, in DICOM's encodings.
#include <cstdint>
#include <string>

#include "morgagni/ct/testing/dicom_writer.h"
#include "morgagni/ct/testing/sample_parts.h"
#include "morgagni/ct/testing/structure_set_writer.h"

namespace mor::testing_files {
namespace {

using namespace testing_dicom;

constexpr int kColumns = 6;
constexpr int kRows = 5;

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

}  // namespace

std::vector<SampleFile> dicom_samples() {
  return {{"explicit.dcm", slice_file(slice_at(2, kExplicit))},
          {"implicit.dcm", slice_file(slice_at(2, kImplicit))},
          {"big_endian.dcm", slice_file(slice_at(2, kBigEndian))},
          {"deflated.dcm", slice_file(slice_at(2, kDeflated))},
          {"alone_frames.dcm", multi_frame_file(kExplicit, false)},
          {"alone_segments.dcm", multi_frame_file(kImplicit, true)}};
}

std::vector<SampleFile> structure_set_samples() {
  std::vector<RoiText> rois(2);
  rois[0].name = "box";
  for (int height = 0; height < 3; ++height) {
    const double z = 2.5 * height;
    rois[0].contours.push_back({{{0, 0, z}, {9, 0, z}, {9, 7, z}, {0, 7, z}}});
    rois[0].contours.push_back({{{3, 2, z}, {6, 2, z}, {5, 5, z}}});
  }
  rois[1].name = "tilted";
  rois[1].contours = {{{{0, 0, 0}, {5, 0, 5}, {5, 8, 5}}}, {{{1, 1, 1}}, "POINT"}};
  return {{"explicit.dcm", structure_set_file(rois)},
          {"implicit.dcm", structure_set_file(rois, {}, kImplicit)},
          {"big_endian.dcm", structure_set_file(rois, {}, kBigEndian)},
          {"deflated.dcm", structure_set_file(rois, {}, kDeflated)}};
}

std::vector<SampleFile> sample_neighbours() {
  return {{"0", slice_file(slice_at(0, kExplicit))}, {"1", slice_file(slice_at(1, kExplicit))}};
}

}  // namespace mor::testing_files
