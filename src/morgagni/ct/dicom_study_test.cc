// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// Which slices of a study are one scan: series found, told apart and chosen, and what is left out.
#include <gmock/gmock.h>

#include "morgagni/ct/testing/dicom_series_folder.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using namespace testing_dicom;

using DicomStudy = DicomImport;

TEST_F(DicomStudy, LeavesOutWhatIsNoSliceOfTheSeries) {
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

TEST_F(DicomStudy, LeavesOutTheEndOfAnotherScan) {
  write_series({}, {0, 1, 2, 3, 4, 5, 6, 7, 8, 300});
  const auto volume = read();
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_EQ(volume->size[2], 9);
}

TEST_F(DicomStudy, ListsSeriesAndReadsTheChosenOne) {
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

TEST_F(DicomStudy, ChoosesASeriesByTheNameThatIsShown) {
  write_series({.series_uid = "1.2.3",
                .series_description = "Sch\xe4"
                                      "del"},
               kFive,
               slanted_hu,
               "a/");
  write_series({.series_uid = "1.2.4", .series_description = "other"}, kFive, slanted_hu, "b/");
  EXPECT_TRUE(read("Schädel"));
}

TEST_F(DicomStudy, TakesAcquisitionsOfOneSeriesApart) {
  const Body later = [](const Eigen::Vector3d& place) { return slanted_hu(place) + 9.0; };
  write_series({.acquisition_number = 1}, kFive, slanted_hu, "a/");
  write_series({.acquisition_number = 2}, kFive, later, "b/");
  EXPECT_THAT(error_of(folder_), HasSubstr("several CT series"));
  const auto volume = read("2");
  ASSERT_TRUE(volume) << volume.error().message;
  expect_holds(*volume, later);
}

TEST_F(DicomStudy, TakesAcquisitionsThatLieAmongOneAnotherApart) {
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

TEST_F(DicomStudy, PutsAcquisitionsThatFollowOneAnotherTogether) {
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

TEST_F(DicomStudy, NamesTheFewSlicesOfAnotherAcquisition) {
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

TEST_F(DicomStudy, RefusesPhasesThatCannotBeToldApart) {
  write_series({}, kFive);
  const Body later = [](const Eigen::Vector3d& place) { return slanted_hu(place) + 9.0; };
  write("later", slice_file(filled({.sop_instance_uid = "9.9", .position_mm = {0, 0, 4}}, later)));
  EXPECT_THAT(error_of(folder_), HasSubstr("two slices lie at the same place and differ"));
  EXPECT_THAT(error_of(folder_), HasSubstr("later"));
}

TEST_F(DicomStudy, LeavesOutADamagedFileOfAnotherSeriesOnly) {
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

TEST_F(DicomStudy, RefusesTooFewSlices) {
  write_series({}, {0, 1});
  EXPECT_THAT(error_of(folder_), HasSubstr("fewer than 3 slices"));
}

}  // namespace
}  // namespace mor
