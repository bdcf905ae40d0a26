// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <functional>

#include <gmock/gmock.h>

#include "morgagni/ct/testing/dicom_writer.h"
#include "morgagni/ct/testing/import_folder.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using namespace testing_dicom;

using Body = std::function<double(const Eigen::Vector3d&)>;

/// HU that tell every place from every other and from its mirror image.
double slanted_hu(const Eigen::Vector3d& place) {
  return 7.0 * place.x() + 31.0 * place.y() + 113.0 * place.z();
}

/// The slice with what the body has at its pixels.
SliceText filled(SliceText slice, const Body& hu_at) {
  const double slope = std::stod(slice.slope);
  const double intercept = std::stod(slice.intercept);
  for (int y = 0; y < slice.rows; ++y) {
    for (int x = 0; x < slice.columns; ++x) {
      const Eigen::Vector3d place = slice.position_mm +
                                    x * slice.column_spacing_mm * slice.along_row +
                                    y * slice.row_spacing_mm * slice.down_column;
      const auto stored = static_cast<int>(std::lround((hu_at(place) - intercept) / slope));
      slice.stored.push_back(static_cast<std::uint16_t>(stored & ((1 << slice.bits_stored) - 1)));
    }
  }
  return slice;
}

Eigen::Vector3d place_of(const Volume& volume, int x, int y, int z) {
  return volume.ct_from_grid * Eigen::Vector3d(x, y, z).cwiseProduct(volume.spacing_mm);
}

/// Every voxel has the HU of its place in space.
void expect_holds(const Volume& volume, const Body& hu_at, double tolerance_hu = 0.51) {
  EXPECT_NEAR(volume.ct_from_grid.linear().determinant(), 1.0, 1e-9);
  for (int z = 0; z < volume.size[2]; ++z)
    for (int y = 0; y < volume.size[1]; ++y)
      for (int x = 0; x < volume.size[0]; ++x)
        ASSERT_NEAR(
            volume.hu[volume.index(x, y, z)], hu_at(place_of(volume, x, y, z)), tolerance_hu)
            << "voxel " << x << ' ' << y << ' ' << z;
}

class DicomImport : public ImportFolder {
 protected:
  /// Slices at these heights along their normal, named so that their order says nothing.
  void write_series(const SliceText& base,
                    const std::vector<double>& heights_mm,
                    const Body& hu_at = slanted_hu,
                    const std::string& prefix = "") {
    const Eigen::Vector3d normal = base.along_row.cross(base.down_column);
    for (std::size_t k = 0; k < heights_mm.size(); ++k) {
      SliceText slice = base;
      slice.position_mm += heights_mm[k] * normal;
      const auto number = (k * 11 + 3) % heights_mm.size();
      write(prefix + "im" + std::to_string(number), slice_file(filled(slice, hu_at)));
    }
  }

  Result<Volume> read(const std::string& series = {}) {
    return import_volume(folder_, {series}, {});
  }

  /// And what the log says meanwhile.
  std::pair<Result<Volume>, std::string> read_and_hear(const std::string& series = {}) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    auto volume = read(series);
    std::string said = testing::internal::GetCapturedStdout();
    said += testing::internal::GetCapturedStderr();
    return {std::move(volume), said};
  }
};

const std::vector<double> kFive = {0, 2, 4, 6, 8};

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

TEST_F(DicomImport, LeavesOutWhatIsNoSliceOfTheSeries) {
  write_series({}, kFive);
  write("deep/er/localizer",
        slice_file(filled({.image_type = "ORIGINAL\\PRIMARY\\LOCALIZER"}, slanted_hu)));
  write("no_pixels", slice_file({}));
  write("no_place", slice_file(filled({.has_position = false}, slanted_hu)));
  write("turned",
        slice_file(
            filled({.position_mm = {0, 0, 10}, .along_row = {0, 1, 0}, .down_column = {0, 0, 1}},
                   slanted_hu)));
  write("larger", slice_file(filled({.columns = 9, .position_mm = {0, 0, 10}}, slanted_hu)));
  write("copy", slice_file(filled({.position_mm = {0, 0, 4}}, slanted_hu)));
  write("copy_of_other_name",
        slice_file(filled({.sop_instance_uid = "9.9", .position_mm = {0, 0, 6}}, slanted_hu)));
  write("dose", slice_file(filled({.modality = "SR"}, slanted_hu)));
  write("readme.txt", "hello");
  const auto [volume, said] = read_and_hear();
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_EQ(volume->size, (std::array{6, 5, 5}));
  expect_holds(*volume, slanted_hu);
  const auto left_out = [&](int num, const std::string& reason, const std::string& name) {
    return HasSubstr(std::to_string(num) + " of " + folder_.string() + " left out, because " +
                     reason + ": " + (folder_ / name).string());
  };
  EXPECT_THAT(said, left_out(1, "it is a localizer", "deep/er/localizer"));
  EXPECT_THAT(said, left_out(1, "it has no pixels", "no_pixels"));
  EXPECT_THAT(said, left_out(1, "it has no position in space", "no_place"));
  EXPECT_THAT(said, left_out(1, "it is turned against the other slices of its series", "turned"));
  EXPECT_THAT(said,
              left_out(1, "it has another size than the other slices of its series", "larger"));
  EXPECT_THAT(said, left_out(1, "its modality is SR, not CT", "dose"));
  EXPECT_THAT(said, left_out(1, "it is no DICOM file", "readme.txt"));
  // Of two that are the same the later name goes.
  EXPECT_THAT(said, left_out(2, "it is there twice", "im"));
}

TEST_F(DicomImport, LeavesOutTheEndOfAnotherScan) {
  write_series({}, {0, 1, 2, 3, 4, 5, 6, 7, 8, 300});
  const auto volume = read();
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_EQ(volume->size[2], 9);
}

TEST_F(DicomImport, ListsSeriesAndReadsTheChosenOne) {
  const Body bone = [](const Eigen::Vector3d& place) { return slanted_hu(place) + 50.0; };
  write_series({.series_uid = "1.2.3", .series_description = "soft"}, kFive, slanted_hu, "a/");
  write_series({.series_uid = "1.2.4",
                .series_description = "hard",
                .patient_position = "FFS",
                .series_number = 7},
               {0, 1, 2, 3},
               bone,
               "b/");
  EXPECT_THAT(
      error_of(folder_),
      HasSubstr("several CT series (1: \"soft\" with 5 slices, 2: \"hard\" with 4 slices)"));
  EXPECT_THAT(error_of(folder_), HasSubstr("--series"));
  const auto all = list_ct_series(folder_, {});
  ASSERT_TRUE(all) << all.error().message;
  ASSERT_EQ(all->size(), 2U);
  EXPECT_EQ((*all)[1].uid, "1.2.4");
  EXPECT_EQ((*all)[1].description, "hard");
  EXPECT_EQ((*all)[1].patient_position, "FFS");
  EXPECT_EQ((*all)[1].num_slices, 4);
  EXPECT_EQ((*all)[1].columns, 6);
  EXPECT_NEAR((*all)[1].max_gap_mm, 1.0, 1e-6);
  for (const char* name : {"2", "1.2.4", "hard"}) {
    const auto volume = read(name);
    ASSERT_TRUE(volume) << volume.error().message;
    expect_holds(*volume, bone);
  }
  EXPECT_THAT(error_of(folder_, "3"), HasSubstr("holds no series \"3\", but 1: \"soft\""));
}

TEST_F(DicomImport, ChoosesASeriesByTheNameThatIsShown) {
  write_series({.series_uid = "1.2.3",
                .series_description = "Sch\xe4"
                                      "del"},
               kFive,
               slanted_hu,
               "a/");
  write_series({.series_uid = "1.2.4", .series_description = "other"}, kFive, slanted_hu, "b/");
  EXPECT_TRUE(read("Schädel"));
}

TEST_F(DicomImport, TakesAcquisitionsOfOneSeriesApart) {
  const Body later = [](const Eigen::Vector3d& place) { return slanted_hu(place) + 9.0; };
  write_series({.acquisition_number = 1}, kFive, slanted_hu, "a/");
  write_series({.acquisition_number = 2}, kFive, later, "b/");
  EXPECT_THAT(error_of(folder_), HasSubstr("several CT series"));
  const auto volume = read("2");
  ASSERT_TRUE(volume) << volume.error().message;
  expect_holds(*volume, later);
}

TEST_F(DicomImport, TakesAcquisitionsThatLieAmongOneAnotherApart) {
  const Body later = [](const Eigen::Vector3d& place) { return slanted_hu(place) + 300.0; };
  for (const std::vector<double>& heights_mm :
       {std::vector<double>{1, 3, 5, 7, 9}, {7, 9, 11, 13}, {-3, -1, 1, 3, 5, 7, 9, 11}}) {
    write_series({.acquisition_number = 1}, kFive, slanted_hu, "a/");
    write_series({.acquisition_number = 2}, heights_mm, later, "b/");
    EXPECT_THAT(error_of(folder_), HasSubstr("several CT series (1: \"made\" with 5 slices, 2: "));
    const auto volume = read("2");
    ASSERT_TRUE(volume) << volume.error().message;
    EXPECT_EQ(volume->size[2], heights_mm.size());
    expect_holds(*volume, later);
    fs::remove_all(folder_ / "b");
  }
}

TEST_F(DicomImport, PutsAcquisitionsThatFollowOneAnotherTogether) {
  write_series({.acquisition_number = 2}, {0, 2, 4}, slanted_hu, "a/");
  write_series({.acquisition_number = 1}, {6, 8, 10}, slanted_hu, "b/");
  for (int k = 0; k < 4; ++k)
    write_series(
        {.acquisition_number = 3 + k}, {12.0 + 2 * k}, slanted_hu, "c" + std::to_string(k));
  const auto volume = read();
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_EQ(volume->size[2], 10);
  expect_holds(*volume, slanted_hu);
}

TEST_F(DicomImport, NamesTheFewSlicesOfAnotherAcquisition) {
  write_series({.acquisition_number = 1}, kFive, slanted_hu, "a/");
  write_series({.acquisition_number = 2}, {3, 5}, slanted_hu, "b/");
  const auto [volume, said] = read_and_hear();
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_EQ(volume->size[2], 5);
  EXPECT_THAT(said,
              HasSubstr("2 of " + folder_.string() + " left out, because it is of another " +
                        "acquisition than the other slices of its series, and lies among them: " +
                        (folder_ / "b/im").string()));
}

TEST_F(DicomImport, RefusesPhasesThatCannotBeToldApart) {
  write_series({}, kFive);
  const Body later = [](const Eigen::Vector3d& place) { return slanted_hu(place) + 9.0; };
  write("later", slice_file(filled({.sop_instance_uid = "9.9", .position_mm = {0, 0, 4}}, later)));
  EXPECT_THAT(error_of(folder_), HasSubstr("two slices lie at the same place and differ"));
  EXPECT_THAT(error_of(folder_), HasSubstr("later"));
}

TEST_F(DicomImport, LeavesOutADamagedFileOfAnotherSeriesOnly) {
  write_series({.series_uid = "1.2.3"}, kFive, slanted_hu, "a/");
  write_series({.series_uid = "1.2.4", .series_number = 2}, kFive, slanted_hu, "b/");
  const auto cut = [&](const std::string& name, std::uintmax_t num_bytes) {
    fs::resize_file(folder_ / name, num_bytes);
  };
  const auto whole = fs::file_size(folder_ / "b/im3");
  cut("b/im3", whole - 20);
  const auto [volume, said] = read_and_hear("1");
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_EQ(volume->size[2], 5);
  EXPECT_THAT(
      said,
      HasSubstr("1 damaged file(s) of other series left out: " + (folder_ / "b/im3").string()));
  EXPECT_THAT(error_of(folder_, "2"), HasSubstr("b/im3 is cut short or damaged"));
  EXPECT_TRUE(list_ct_series(folder_, {}));
  // Before the series' UID it may be of any.
  cut("b/im3", 200);
  EXPECT_THAT(error_of(folder_, "1"), HasSubstr("b/im3 is cut short or damaged"));
}

TEST_F(DicomImport, RefusesTooFewSlices) {
  write_series({}, {0, 1});
  EXPECT_THAT(error_of(folder_), HasSubstr("fewer than 3 slices"));
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
