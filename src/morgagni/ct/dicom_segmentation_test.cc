// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// DICOM Segmentations as label maps.
#include <gmock/gmock.h>

#include "morgagni/ct/label_map.h"
#include "morgagni/ct/testing/dicom_writer.h"
#include "morgagni/ct/testing/import_folder.h"

namespace mor {
namespace {

using testing::HasSubstr;
using namespace testing_dicom;

constexpr int kColumns = 5;
constexpr int kRows = 3;

/// A frame of a made segmentation: its height, its segment and which pixels are in it.
struct FrameText {
  double height_mm = 0.0;
  std::uint16_t segment = 1;
  std::vector<int> pixels = {};  ///< Shares of 255; 0 is outside.
  double aside_mm = 0.0;
};

struct SegmentationText {
  const char* syntax = kExplicit;
  std::string type = "BINARY";
  std::vector<FrameText> frames = {};
  std::string thickness_mm = {};
  std::size_t num_missing_bytes = 0;
};

std::string packed(const SegmentationText& seg) {
  std::vector<int> all;
  for (const auto& frame : seg.frames)
    all.insert(all.end(), frame.pixels.begin(), frame.pixels.end());
  std::string bytes(seg.type == "BINARY" ? (all.size() + 7) / 8 : all.size(), '\0');
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (seg.type == "BINARY") {
      if (all[i] > 0) bytes[i / 8] = static_cast<char>(bytes[i / 8] | 1 << (i % 8));
    } else {
      bytes[i] = static_cast<char>(all[i]);
    }
  }
  if (bytes.size() % 2 != 0) bytes += '\0';
  bytes.resize(bytes.size() - seg.num_missing_bytes);
  return bytes;
}

std::string frame_group(const FrameText& frame, const char* syntax) {
  DicomWriter position(syntax);
  position.text(0x0020'0032,
                "DS",
                std::to_string(10.0 + frame.aside_mm) + "\\20\\" + std::to_string(frame.height_mm));
  DicomWriter which(syntax);
  which.number(0x0062'000b, frame.segment);
  DicomWriter group(syntax);
  group.sequence(0x0020'9113, {position.data()});
  group.sequence(0x0062'000a, {which.data()});
  return group.data();
}

std::string segment_item(const char* syntax, std::uint16_t number, const std::string& name) {
  DicomWriter segment(syntax);
  segment.number(0x0062'0004, number);
  segment.text(0x0062'0005, "LO", name);
  // CIELab of sRGB (1, 0, 0) under D50: 54.29, 80.80, 69.89.
  segment.words(0x0062'000d, {35580, 53661, 50857});
  return segment.data();
}

std::string segmentation_file(const SegmentationText& seg) {
  DicomWriter orientation(seg.syntax);
  orientation.text(0x0020'0037, "DS", "1\\0\\0\\0\\1\\0");
  DicomWriter measures(seg.syntax);
  if (!seg.thickness_mm.empty()) measures.text(0x0018'0050, "DS", seg.thickness_mm);
  measures.text(0x0028'0030, "DS", "2\\1");
  DicomWriter shared(seg.syntax);
  shared.sequence(0x0020'9116, {orientation.data()});
  shared.sequence(0x0028'9110, {measures.data()});
  std::vector<std::string> frames;
  for (const auto& frame : seg.frames) frames.push_back(frame_group(frame, seg.syntax));
  const bool is_binary = seg.type == "BINARY";
  DicomWriter out(seg.syntax);
  out.text(0x0008'0016, "UI", "1.2.840.10008.5.1.4.1.1.66.4");
  out.text(0x0008'0018, "UI", "1.2.3.4.5");
  out.text(0x0008'0060, "CS", "SEG");
  out.text(0x0020'000e, "UI", "1.2.3");
  out.number(0x0028'0002, 1);
  out.text(0x0028'0008, "IS", std::to_string(seg.frames.size()));
  out.number(0x0028'0010, kRows);
  out.number(0x0028'0011, kColumns);
  out.number(0x0028'0100, is_binary ? 1 : 8);
  out.number(0x0028'0101, is_binary ? 1 : 8);
  out.number(0x0028'0102, is_binary ? 0 : 7);
  out.number(0x0028'0103, 0);
  out.text(0x0062'0001, "CS", seg.type);
  out.sequence(0x0062'0002,
               {segment_item(seg.syntax, 1, "liver"), segment_item(seg.syntax, 7, "spleen")});
  out.number(0x0062'000e, 255);
  out.sequence(0x5200'9229, {shared.data()});
  out.sequence(0x5200'9230, frames);
  const auto pixels = packed(seg);
  out.raw(0x7fe0'0010, is_binary ? "OW" : "OB", static_cast<std::uint32_t>(pixels.size()), pixels);
  return out.file();
}

/// All outside but one pixel.
std::vector<int> only(int column, int row, int share = 255) {
  std::vector<int> pixels(kColumns * kRows, 0);
  pixels[static_cast<std::size_t>(row * kColumns + column)] = share;
  return pixels;
}

class DicomSegmentation : public ImportFolder {
 protected:
  std::string refusal(const SegmentationText& seg) {
    const auto labels = import_label_map(write("bad.dcm", segmentation_file(seg)), {});
    return labels ? "no error" : labels.error().message;
  }
};

TEST_F(DicomSegmentation, PutsEachFrameWhereItLies) {
  for (const char* syntax : {kExplicit, kImplicit, kDeflated}) {
    SCOPED_TRACE(syntax);
    // In no order, with a layer on which nothing lies.
    const auto path =
        write("seg.dcm",
              segmentation_file(
                  {.syntax = syntax,
                   .frames = {{6.0, 7, only(4, 2)}, {0.0, 1, only(0, 0)}, {2.0, 1, only(3, 1)}}}));
    for (const auto& given : {path, folder_}) {
      const auto labels = import_label_map(given, {});
      ASSERT_TRUE(labels) << labels.error().message;
      const auto& voxels = labels->voxels;
      EXPECT_EQ(voxels.size, (std::array{kColumns, kRows, 4}));
      EXPECT_LT((voxels.spacing_mm - Eigen::Vector3d(1, 2, 2)).norm(), 1e-9);
      EXPECT_LT((voxels.ct_from_grid.translation() - Eigen::Vector3d(10, 20, 0)).norm(), 1e-9);
      EXPECT_EQ(voxels.hu[voxels.index(0, 0, 0)], 1);
      EXPECT_EQ(voxels.hu[voxels.index(3, 1, 1)], 1);
      EXPECT_EQ(voxels.hu[voxels.index(4, 2, 3)], 7);
      EXPECT_EQ(std::count(voxels.hu.begin(), voxels.hu.end(), 0), kColumns * kRows * 4 - 3);
      ASSERT_EQ(labels->names.size(), 2U);
      EXPECT_EQ(labels->names[1].value, 7);
      EXPECT_EQ(labels->names[1].name, "spleen");
      EXPECT_LT((labels->names[1].color - Eigen::Vector3f(1, 0, 0)).norm(), 0.02F);
    }
  }
}

TEST_F(DicomSegmentation, TakesFromHalfAFractionOn) {
  const auto path =
      write("seg.dcm",
            segmentation_file({.type = "FRACTIONAL",
                               .frames = {{0.0, 1, only(0, 0, 128)}, {2.0, 1, only(1, 0, 127)}}}));
  const auto labels = import_label_map(path, {});
  ASSERT_TRUE(labels) << labels.error().message;
  EXPECT_EQ(labels->voxels.hu[0], 1);
  EXPECT_EQ(std::count(labels->voxels.hu.begin(), labels->voxels.hu.end(), 1), 1);
}

/// Frames in which nothing lies are often left out.
TEST_F(DicomSegmentation, TakesASingleFrameAsThickAsItSays) {
  for (const auto& [said, spacing_mm] : {std::pair{"5", 5.0}, std::pair{"", 1.0}}) {
    const auto path = write(
        "seg.dcm", segmentation_file({.frames = {{6.0, 7, only(4, 2)}}, .thickness_mm = said}));
    const auto labels = import_label_map(path, {});
    ASSERT_TRUE(labels) << labels.error().message;
    const auto& voxels = labels->voxels;
    EXPECT_EQ(voxels.size, (std::array{kColumns, kRows, 2}));
    EXPECT_EQ(voxels.spacing_mm.z(), spacing_mm);
    EXPECT_EQ(voxels.ct_from_grid.translation().z(), 6.0);
    EXPECT_EQ(voxels.hu[voxels.index(4, 2, 0)], 7);
    EXPECT_EQ(std::count(voxels.hu.begin(), voxels.hu.end(), 0), kColumns * kRows * 2 - 1);
  }
}

TEST_F(DicomSegmentation, SaysWhatIsWrong) {
  EXPECT_THAT(refusal({.frames = {{0.0, 1, only(0, 0)}}, .num_missing_bytes = 2}),
              HasSubstr("cut short"));
  EXPECT_THAT(refusal({.frames = {}}), HasSubstr("does not say of each frame where it lies"));
  EXPECT_THAT(refusal({.type = "LABELMAP", .frames = {{0.0, 1, only(0, 0)}}}),
              HasSubstr("of type \"LABELMAP\" with 8 bits a pixel"));
  EXPECT_THAT(refusal({.frames = {{0.0, 0, only(0, 0)}}}), HasSubstr("names segment 0 in frame 1"));
  EXPECT_THAT(refusal({.frames = {{0.0, 1, only(0, 0)}, {2.0, 1, only(0, 0), 1.5}}}),
              HasSubstr("not stacked at right angles"));
  EXPECT_THAT(
      refusal({.frames = {{0.0, 1, only(0, 0)}, {2.0, 1, only(0, 0)}, {5.0, 1, only(0, 0)}}}),
      HasSubstr("not evenly apart"));
  EXPECT_THAT(
      refusal({.frames = {{0.0, 1, only(0, 0)}, {0.1, 1, only(0, 0)}, {9000.0, 1, only(0, 0)}}}),
      HasSubstr("the limit is 2048 a side"));
  write("ct.dcm", slice_file({}));
  std::filesystem::remove(folder_ / "bad.dcm");
  const auto none = import_label_map(folder_, {});
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message, HasSubstr("holds no DICOM segmentation (modality SEG)"));
}

}  // namespace
}  // namespace mor
