// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cctype>
#include <cstdlib>

#include <gmock/gmock.h>

#include "morgagni/ct/testing/dicom_series_folder.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using namespace testing_dicom;

TEST_F(DicomImport, ReadsEveryUncompressedSyntax) {
  for (const char* syntax : {kImplicit, kExplicit, kDeflated, kBigEndian}) {
    SCOPED_TRACE(syntax);
    write_series({.transfer_syntax = syntax, .position_mm = {1, 2, 3}}, kFive);
    const auto volume = read();
    ASSERT_TRUE(volume) << volume.error().message;
    EXPECT_EQ(volume->size, (std::array{6, 5, 5}));
    EXPECT_TRUE(volume->spacing_mm.isApprox(Eigen::Vector3d(0.5, 1.0, 2.0)));
    expect_holds(*volume, slanted_hu);
  }
}

/// Through a tool that compresses files for an archive.
void pack(const std::string& tool, const fs::path& file) {
  const std::string path = "'" + file.string() + "'";
  const std::string command =
      tool + " " + path + " " + path + ".packed >/dev/null 2>&1 && mv " + path + ".packed " + path;
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
}

std::string transfer_syntax_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string head(1000, ' ');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  const auto at = head.find(std::string("\x02\0\x10\0UI", 6));
  return head.substr(at + 8, static_cast<unsigned char>(head[at + 6])).c_str();  // Without a NUL.
}

struct Packing {
  std::string tool;
  std::string transfer_syntax;
  int tolerance_hu = 0;      ///< Of each voxel.
  bool takes_signed = true;  ///< The tool.
};

class CompressedDicomImport : public DicomImport, public testing::WithParamInterface<Packing> {
 protected:
  /// The same series plain and packed.
  void expect_same_voxels(const SliceText& base) {
    const auto& [tool, transfer_syntax, tolerance_hu, takes_signed] = GetParam();
    write_series(base, {0, 2, 4});
    const auto plain = read();
    ASSERT_TRUE(plain) << plain.error().message;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      pack(tool, entry.path());
      ASSERT_EQ(transfer_syntax_of(entry.path()), transfer_syntax);
    }
    const auto packed = read();
    ASSERT_TRUE(packed) << packed.error().message;
    EXPECT_TRUE(packed->ct_from_grid.isApprox(plain->ct_from_grid));
    ASSERT_EQ(packed->hu.size(), plain->hu.size());
    for (std::size_t i = 0; i < plain->hu.size(); ++i)
      ASSERT_NEAR(packed->hu[i], plain->hu[i], tolerance_hu) << "voxel " << i;
  }

  /// From about -1,300 to 900 HU.
  static SliceText stored_with(const char* intercept, bool is_signed, int bits_stored) {
    return {.columns = 64,
            .rows = 48,
            .position_mm = {-16, -24, -4},
            .intercept = intercept,
            .is_signed = is_signed,
            .bits_stored = bits_stored};
  }
};

TEST_P(CompressedDicomImport, GivesTheSameVoxels) {
  expect_same_voxels(stored_with("-2048", false, 12));
  const bool is_signed = GetParam().takes_signed;
  expect_same_voxels(stored_with(is_signed ? "0" : "-2048", is_signed, 16));
  if (is_signed) expect_same_voxels(stored_with("0", true, 12));
}

INSTANTIATE_TEST_SUITE_P(
    Syntaxes,
    CompressedDicomImport,
    testing::Values(Packing{"dcmcrle", "1.2.840.10008.1.2.5"},
                    Packing{"dcmcjpeg +eb", "1.2.840.10008.1.2.4.50", 20},
                    Packing{"dcmcjpeg +ee", "1.2.840.10008.1.2.4.51", 20},
                    Packing{"dcmcjpeg +el", "1.2.840.10008.1.2.4.57"},
                    Packing{"dcmcjpeg +e1", "1.2.840.10008.1.2.4.70"},
                    Packing{"dcmcjpls +el", "1.2.840.10008.1.2.4.80"},
                    Packing{"dcmcjpls +en", "1.2.840.10008.1.2.4.81", 2, false},
                    Packing{"gdcmconv --j2k", "1.2.840.10008.1.2.4.90"},
                    Packing{"gdcmconv --j2k --lossy", "1.2.840.10008.1.2.4.91", 20},
                    Packing{"dcmconv +ti", kImplicit},
                    Packing{"dcmconv +tb", kBigEndian},
                    Packing{"dcmconv +td", kDeflated}),
    [](const auto& packing) {
      std::string name = packing.param.tool;
      for (char& letter : name)
        if (std::isalnum(static_cast<unsigned char>(letter)) == 0) letter = '_';
      return name;
    });

struct Orientation {
  const char* patient_position;
  Eigen::Vector3d along_row;
  Eigen::Vector3d down_column;
};

class OrientedDicomImport : public DicomImport, public testing::WithParamInterface<Orientation> {};

TEST_P(OrientedDicomImport, LeavesEveryVoxelAtItsPlace) {
  const auto& [position, row, column] = GetParam();
  write_series({.patient_position = position,
                .position_mm = {-3, 5, 20},
                .along_row = row,
                .down_column = column},
               kFive);
  const auto volume = read();
  ASSERT_TRUE(volume) << volume.error().message;
  expect_holds(*volume, slanted_hu);
}

INSTANTIATE_TEST_SUITE_P(Positions,
                         OrientedDicomImport,
                         testing::Values(Orientation{"HFS", {1, 0, 0}, {0, 1, 0}},
                                         Orientation{"HFP", {-1, 0, 0}, {0, -1, 0}},
                                         Orientation{"FFS", {-1, 0, 0}, {0, 1, 0}},
                                         Orientation{"FFP", {1, 0, 0}, {0, -1, 0}},
                                         Orientation{"HFDR", {0, -1, 0}, {1, 0, 0}},
                                         Orientation{"HFDL", {0, 1, 0}, {-1, 0, 0}},
                                         Orientation{"FFDR", {0, -1, 0}, {-1, 0, 0}},
                                         Orientation{"FFDL", {0, 1, 0}, {1, 0, 0}},
                                         Orientation{"SAGITTAL", {0, 1, 0}, {0, 0, -1}},
                                         Orientation{"OBLIQUE", {0.8, 0.6, 0}, {-0.36, 0.48, 0.8}}),
                         [](const auto& oriented) { return oriented.param.patient_position; });

TEST_F(DicomImport, StraightensATiltedGantry) {
  const double tilt_rad = 0.32;
  SliceText base = {
      .columns = 12, .rows = 12, .down_column = {0, std::cos(tilt_rad), std::sin(tilt_rad)}};
  for (int k = 0; k < 8; ++k) {
    SliceText slice = base;
    slice.position_mm = {0, 0, 1.5 * k};  // The table moves along z, the slices lean.
    write("t" + std::to_string(k), slice_file(filled(slice, slanted_hu)));
  }
  const auto volume = read();
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_GT(volume->size[1], 12) << "room for the shear";
  int num_inside = 0;
  for (int z = 0; z < volume->size[2]; ++z) {
    for (int y = 0; y < volume->size[1]; ++y) {
      const Eigen::Vector3d place = place_of(*volume, 3, y, z);
      // Within the parallelogram that was scanned, a row away from its edges.
      const double along_mm = place.y() / std::cos(tilt_rad);
      if (along_mm < 1.0 || along_mm > 10.0) continue;
      ++num_inside;
      EXPECT_NEAR(volume->hu[volume->index(3, y, z)], slanted_hu(place), 1.1);
    }
  }
  EXPECT_GT(num_inside, 60);
}

TEST_F(DicomImport, EvensOutIrregularSpacing) {
  write_series({}, {0, 4, 8, 12, 13, 14, 15});
  const auto volume = read();
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_EQ(volume->size[2], 16);
  EXPECT_NEAR(volume->spacing_mm.z(), 1.0, 1e-9);
  expect_holds(*volume, slanted_hu, 1.01);
}

TEST_F(DicomImport, BridgesASliceThatIsMissing) {
  write_series({}, {0, 2, 4, 8, 10});
  const auto [volume, said] = read_and_hear();
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_THAT(said,
              HasSubstr("slices may be missing: 4.00 mm between " + (folder_ / "im0").string() +
                        " and " + (folder_ / "im1").string() + ", more than beside them"));
  EXPECT_EQ(volume->size[2], 6);
  expect_holds(*volume, slanted_hu, 1.01);
}

TEST_F(DicomImport, UnderstandsStoredNumbers) {
  const Body hu_at = [](const Eigen::Vector3d& place) { return 10.0 * std::round(place.y()); };
  for (const SliceText& base : {SliceText{.slope = "2", .intercept = "-1000"},
                                SliceText{.intercept = "0", .is_signed = true},
                                SliceText{.intercept = "0", .is_signed = true, .bits_stored = 12},
                                SliceText{.intercept = "-1024.0", .bits_stored = 12}}) {
    SliceText slice = base;
    slice.position_mm.y() = -3.0;
    write_series(slice, kFive, hu_at);
    const auto volume = read();
    ASSERT_TRUE(volume) << volume.error().message;
    expect_holds(*volume, hu_at);
  }
}

TEST_F(DicomImport, TakesPaddingForAir) {
  SliceText base = filled({.intercept = "0", .is_signed = true, .padding = 0xf830}, slanted_hu);
  base.stored[8] = 0xf830;  // -2000
  for (int k = 0; k < 3; ++k) {
    base.position_mm.z() = k;
    write("p" + std::to_string(k), slice_file(base));
  }
  const auto volume = read();
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_EQ(volume->hu[8], -1024);
}

/// An enhanced CT: one file, what all frames share beside what each has of its own.
std::string multi_frame_file(const char* syntax,
                             const std::vector<double>& heights_mm,
                             int columns = 6,
                             int rows = 5,
                             const Body& hu_at = slanted_hu) {
  DicomWriter shared(syntax);
  DicomWriter orientation(syntax);
  orientation.text(0x0020'0037, "DS", "0\\1\\0\\-1\\0\\0");
  DicomWriter measures(syntax);
  measures.text(0x0028'0030, "DS", "1\\0.5");
  DicomWriter values(syntax);
  values.text(0x0028'1052, "DS", "-500");
  values.text(0x0028'1053, "DS", "1");
  shared.sequence(0x0020'9116, {orientation.data()});
  shared.sequence(0x0028'9110, {measures.data()});
  shared.sequence(0x0028'9145, {values.data()});
  std::vector<std::string> frames;
  std::vector<std::uint16_t> stored;
  for (const double height_mm : heights_mm) {
    DicomWriter position(syntax);
    position.text(0x0020'0032, "DS", "4\\5\\" + std::to_string(height_mm));
    DicomWriter frame(syntax);
    frame.sequence(0x0020'9113, {position.data()});
    frames.push_back(frame.data());
    SliceText slice = {.columns = columns,
                       .rows = rows,
                       .position_mm = {4, 5, height_mm},
                       .along_row = {0, 1, 0},
                       .down_column = {-1, 0, 0},
                       .intercept = "-500"};
    const auto pixels = filled(slice, hu_at).stored;
    stored.insert(stored.end(), pixels.begin(), pixels.end());
  }
  DicomWriter out(syntax);
  out.text(0x0008'0016, "UI", "1.2.840.10008.5.1.4.1.1.2.1");
  out.text(0x0008'0018, "UI", "1.2.3.4.5");
  out.text(0x0008'0060, "CS", "CT");
  out.text(0x0020'000d, "UI", "1.2");
  out.text(0x0020'000e, "UI", "1.2.3");
  out.number(0x0028'0002, 1);
  out.text(0x0028'0004, "CS", "MONOCHROME2");
  out.text(0x0028'0008, "IS", std::to_string(heights_mm.size()));
  out.number(0x0028'0010, static_cast<std::uint16_t>(rows));
  out.number(0x0028'0011, static_cast<std::uint16_t>(columns));
  out.number(0x0028'0100, 16);
  out.number(0x0028'0101, 16);
  out.number(0x0028'0102, 15);
  out.number(0x0028'0103, 0);
  out.sequence(0x5200'9229, {shared.data()});
  out.sequence(0x5200'9230, frames);
  out.words(0x7fe0'0010, stored);
  return out.file();
}

TEST_F(DicomImport, ReadsAnEnhancedMultiFrameCt) {
  for (const char* syntax : {kExplicit, kImplicit, kBigEndian, kDeflated}) {
    SCOPED_TRACE(syntax);
    const auto path = write("frames.dcm", multi_frame_file(syntax, {8, 2, 4, 6}));
    for (const auto& given : {path, folder_}) {
      const auto volume = import_volume(given, {}, {});
      ASSERT_TRUE(volume) << volume.error().message;
      EXPECT_EQ(volume->size, (std::array{6, 5, 4}));
      expect_holds(*volume, slanted_hu);
    }
  }
}

TEST_F(DicomImport, ReadsCompressedFrames) {
  const auto path = write("frames.dcm", multi_frame_file(kExplicit, {8, 2, 4, 6}));
  pack("dcmcrle", path);
  const auto volume = import_volume(path, {}, {});
  ASSERT_TRUE(volume) << volume.error().message;
  expect_holds(*volume, slanted_hu);
}

int num_fragments(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  const std::string item("\xfe\xff\0\xe0", 4);
  int count = -1;  // The first is the offset table.
  for (auto at = bytes.find(std::string("\xe0\x7f\x10\0", 4)); at != std::string::npos;
       at = bytes.find(item, at + 1))
    ++count;
  return count - 1;
}

/// The offset table alone tells the frames apart then.
TEST_F(DicomImport, ReadsFramesOfSeveralFragments) {
  const Body rough = [](const Eigen::Vector3d& place) {
    return std::round(600.0 + 1000.0 * std::sin(1e4 * place.dot(Eigen::Vector3d(1.0, 1.7, 2.3))));
  };
  constexpr int kNumFrames = 4;
  const std::string file = multi_frame_file(kExplicit, {8, 2, 4, 6}, 64, 48, rough);
  for (const std::string tool : {"dcmcjpeg +e1 +fs 1", "dcmcjpls +el +fs 1", "dcmcrle +fs 1"}) {
    SCOPED_TRACE(tool);
    auto path = write("frames.dcm", file);
    pack(tool, path);
    ASSERT_GT(num_fragments(path), 2 * kNumFrames);
    const auto volume = import_volume(path, {}, {});
    ASSERT_TRUE(volume) << volume.error().message;
    expect_holds(*volume, rough);
    path = write("frames.dcm", file);
    pack(tool + " -ot", path);
    EXPECT_THAT(error_of(path), HasSubstr("damaged or missing pixels"));
  }
  write_series({.columns = 64, .rows = 48, .intercept = "-2048"}, kFive, rough, "single/");
  for (const auto& entry : fs::directory_iterator(folder_ / "single")) {
    pack("dcmcjpeg +e1 +fs 1", entry.path());
    ASSERT_GT(num_fragments(entry.path()), 2);
  }
  const auto volume = import_volume(folder_ / "single", {}, {});
  ASSERT_TRUE(volume) << volume.error().message;
  expect_holds(*volume, rough);
}

TEST_F(DicomImport, RefusesFramesWithoutPlaces) {
  std::string file = multi_frame_file(kExplicit, {0, 1, 2});
  const auto at = file.find("3 ", file.find(std::string("\x28\0\x08\0IS", 6)));
  ASSERT_NE(at, std::string::npos);
  file.replace(at, 2, "9 ");
  EXPECT_THAT(error_of(write("frames.dcm", file)), HasSubstr("without saying where each lies"));
}

TEST_F(DicomImport, ReadsAZip) {
  write_series({}, kFive, slanted_hu, "study/series/");
  const std::string zip = (folder_ / "study.zip").string();
  const std::string command =
      "cd '" + folder_.string() + "' && python3 -m zipfile -c study.zip study >/dev/null";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const auto volume = import_volume(zip, {}, {});
  ASSERT_TRUE(volume) << volume.error().message;
  expect_holds(*volume, slanted_hu);
  fs::resize_file(zip, fs::file_size(zip) - 30);
  EXPECT_THAT(error_of(zip), HasSubstr("no whole zip archive"));
}

TEST_F(DicomImport, ReadsWhatADicomdirNames) {
  write_series({.position_mm = {0, 0, 50}}, kFive, slanted_hu, "CT/S1/");
  write_series({.series_uid = "7.7"}, kFive, slanted_hu, "CT/S2/");
  std::vector<std::string> records;
  for (const char* name : {"CT\\S1\\IM0",
                           "CT\\S1\\IM1",
                           "CT\\S1\\IM2",
                           "CT\\S1\\IM3",
                           "CT\\S1\\IM4",
                           "CT\\S1\\IM9",
                           "..\\..\\etc\\passwd"}) {
    DicomWriter record;
    record.text(0x0004'1430, "CS", "IMAGE");
    record.text(0x0004'1500, "CS", name);
    records.push_back(record.data());
  }
  DicomWriter directory;
  directory.sequence(0x0004'1220, records);
  const auto path = write("DICOMDIR", directory.file());
  const auto volume = import_volume(path, {}, {});
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_NEAR(volume->ct_from_grid.translation().z(), 50.0, 1e-6);
  EXPECT_THAT(error_of(folder_), HasSubstr("several CT series")) << "the folder has both";
}

TEST_F(DicomImport, ReadsAFileWithoutPreamble) {
  write_series({.transfer_syntax = kImplicit}, kFive);
  for (const auto& entry : fs::directory_iterator(folder_)) {
    std::ifstream in(entry.path(), std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), {});
    const auto start = bytes.find(std::string("\x08\0\x08\0", 4));
    std::ofstream(entry.path(), std::ios::binary) << bytes.substr(start);
  }
  const auto volume = read();
  ASSERT_TRUE(volume) << volume.error().message;
  expect_holds(*volume, slanted_hu);
}

}  // namespace
}  // namespace mor
