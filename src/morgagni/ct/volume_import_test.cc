// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/volume_import.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "morgagni/ct/internal/import_process.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ImportVolume : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("morgagni_import_" + std::string(info->name()) + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }

  /// A MetaImage of 4 x 3 x 2 short voxels 0, 1, 2, ...; `lines` come before its last line.
  fs::path write_mha(const std::string& lines, std::size_t num_bytes = 48) {
    std::string bytes = "ObjectType = Image\nBinaryData = True\nBinaryDataByteOrderMSB = False\n" +
                        lines + "ElementDataFile = LOCAL\n";
    std::string voxels;
    for (int i = 0; i < 24; ++i) voxels += {static_cast<char>(i), '\0'};
    return write("ct.mha", bytes + voxels.substr(0, num_bytes));
  }

  static std::string error_of(const fs::path& path) {
    const auto volume = import_volume(path, {}, {});
    return volume ? "no error" : volume.error().message;
  }

  fs::path folder_;
};

constexpr const char* kGrid =
    "NDims = 3\nDimSize = 4 3 2\nElementSpacing = 0.5 1 2\nOffset = 10 20 30\n"
    "ElementType = MET_SHORT\n";

/// Where in space the voxel of a value lies.
Eigen::Vector3d place_of(const Volume& volume, int hu) {
  for (int z = 0; z < volume.size[2]; ++z)
    for (int y = 0; y < volume.size[1]; ++y)
      for (int x = 0; x < volume.size[0]; ++x)
        if (volume.hu[volume.index(x, y, z)] == hu)
          return volume.ct_from_grid * Eigen::Vector3d(x, y, z).cwiseProduct(volume.spacing_mm);
  return Eigen::Vector3d::Constant(NAN);
}

TEST_F(ImportVolume, ReadsAMetaImage) {
  const auto volume = import_volume(write_mha(kGrid), {}, {});
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_EQ(volume->size, (std::array{4, 3, 2}));
  EXPECT_EQ(volume->spacing_mm, Eigen::Vector3d(0.5, 1, 2));
  EXPECT_EQ(volume->num_voxels(), 24U);
  EXPECT_TRUE(place_of(*volume, 1 + 4 * 2 + 12).isApprox(Eigen::Vector3d(10.5, 22, 32)));
}

TEST_F(ImportVolume, FlipsALeftHandedGridWithoutMirroringSpace) {
  const auto volume = import_volume(
      write_mha(std::string(kGrid) + "TransformMatrix = 1 0 0 0 1 0 0 0 -1\n"), {}, {});
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_NEAR(volume->ct_from_grid.linear().determinant(), 1.0, 1e-9);
  EXPECT_TRUE(place_of(*volume, 0).isApprox(Eigen::Vector3d(10, 20, 30)));
  EXPECT_TRUE(place_of(*volume, 1 + 4 * 2 + 12).isApprox(Eigen::Vector3d(10.5, 22, 28)));
}

TEST_F(ImportVolume, ReportsProgressToItsEnd) {
  double last = -1.0;
  ASSERT_TRUE(import_volume(write_mha(kGrid), {}, [&](std::string_view stage, double fraction) {
    EXPECT_EQ(stage, "read CT");
    EXPECT_GE(fraction, last);
    last = fraction;
  }));
  EXPECT_EQ(last, 1.0);
}

TEST_F(ImportVolume, SaysWhatIsWrongWithAFile) {
  EXPECT_THAT(error_of(folder_ / "none.nii"), HasSubstr("there is no file or folder"));
  EXPECT_THAT(error_of(write("ct.jpg", "x")),
              HasSubstr("give a DICOM folder, DICOMDIR or .zip, or a .nii"));
  EXPECT_THAT(error_of(write("empty.nii.gz", "")), HasSubstr("damaged"));
  EXPECT_THAT(error_of(write("noise.nrrd", "no nrrd at all")), HasSubstr("damaged"));
  EXPECT_THAT(error_of(write_mha(kGrid, 30)),
              HasSubstr("cut short: 48 bytes of voxels are announced, 30 are there"));
  EXPECT_THAT(error_of(write_mha("NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\n"
                                 "ElementSpacing = 0 1 2\n")),
              HasSubstr("spacing"));
  EXPECT_THAT(error_of(write_mha("NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\n"
                                 "ElementSpacing = nan 1 2\n")),
              HasSubstr("behind its ElementSpacing"));
  EXPECT_THAT(error_of(write_mha("NDims = 2\nDimSize = 4 6\nElementType = MET_SHORT\n")),
              HasSubstr("2 dimensions, a CT has 3"));
  EXPECT_THAT(error_of(write_mha("NDims = 4\nDimSize = 2 3 2 2\nElementType = MET_SHORT\n")),
              HasSubstr("4 dimensions, a CT has 3"));
  EXPECT_THAT(error_of(write_mha("NDims = 3\nDimSize = 4 2 2\nElementType = MET_UCHAR\n"
                                 "ElementNumberOfChannels = 3\n")),
              HasSubstr("colour"));
  EXPECT_THAT(error_of(write_mha("NDims = 3\nDimSize = 4 3 99999\nElementType = MET_SHORT\n")),
              HasSubstr("99999 voxels"));
}

TEST_F(ImportVolume, RefusesNrrdsThatAreCutShortOrInColour) {
  const std::string head = "NRRD0004\ntype: short\nencoding: raw\nendian: little\n";
  const std::string grid = "dimension: 3\nsizes: 4 3 2\nspacings: 1 1 1\n\n";
  EXPECT_EQ(error_of(write("whole.nrrd", head + grid + std::string(48, 'a'))), "no error");
  EXPECT_THAT(error_of(write("cut.nrrd", head + grid + std::string(30, 'a'))),
              HasSubstr("cut short"));
  EXPECT_THAT(error_of(write("four.nrrd",
                             head + "dimension: 4\nsizes: 2 3 2 2\n\n" + std::string(48, 'a'))),
              HasSubstr("4 dimensions"));
}

TEST_F(ImportVolume, RefusesARealNiftiThatIsCutShort) {
  const auto whole = fs::path(MORGAGNI_DATA_DIR) / "ct_head_invesalius/promed_ct_0051.nii.gz";
  if (!fs::exists(whole)) GTEST_SKIP() << "no " << whole;
  fs::copy_file(whole, folder_ / "cut.nii.gz");
  fs::permissions(folder_ / "cut.nii.gz", fs::perms::owner_all);
  fs::resize_file(folder_ / "cut.nii.gz", 3000000);
  EXPECT_THAT(error_of(folder_ / "cut.nii.gz"), HasSubstr("cut.nii.gz is cut short or damaged"));
}

TEST_F(ImportVolume, SaysWhatIsWrongWithAFolder) {
  EXPECT_THAT(error_of(folder_), HasSubstr("holds no DICOM file"));
  write("note.txt", "hello");
  EXPECT_THAT(error_of(folder_), HasSubstr("holds no DICOM file"));
}

/// Real slices, spoilt one way or another.
class ImportSpoiltDicom : public ImportVolume {
 protected:
  void SetUp() override {
    ImportVolume::SetUp();
    const auto archive =
        fs::path(MORGAGNI_DATA_DIR) / "phantom_skull_philips/skull_untilted_5mm_dicom.tar.xz";
    if (!fs::exists(archive)) GTEST_SKIP() << "no " << archive;
    const std::string command =
        "tar xJf '" + archive.string() + "' -C '" + folder_.string() + "' --strip-components=1";
    ASSERT_EQ(std::system(command.c_str()), 0);
    for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
      fs::permissions(entry.path(), fs::perms::owner_all);
      if (entry.is_regular_file() && entry.file_size() > 100000) slices_.push_back(entry.path());
    }
    std::sort(slices_.begin(), slices_.end());
    ASSERT_GE(slices_.size(), 20U);
  }

  std::vector<fs::path> slices_;
};

TEST_F(ImportSpoiltDicom, PassesOverTheFileWithoutPixels) {
  const auto volume = import_volume(folder_, {}, {});
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_EQ(volume->size, (std::array{512, 512, 28}));
  EXPECT_NEAR(volume->spacing_mm.z(), 5.0, 1e-6);
  EXPECT_THAT(volume->description, HasSubstr("STD BRAIN 5MM"));
}

TEST_F(ImportSpoiltDicom, RefusesASliceCutInItsHeader) {
  fs::resize_file(slices_[3], 900);
  EXPECT_THAT(error_of(folder_), HasSubstr("cut short or damaged"));
}

TEST_F(ImportSpoiltDicom, RefusesASliceWhosePixelsEndEarly) {
  fs::resize_file(slices_[3], fs::file_size(slices_[3]) - 100);
  EXPECT_THAT(error_of(folder_), HasSubstr(slices_[3].filename().string() + " is cut short"));
}

TEST_F(ImportSpoiltDicom, TakesASliceThatIsThereTwiceOnce) {
  fs::copy_file(slices_[3], folder_ / "again");
  const auto volume = import_volume(folder_, {}, {});
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_EQ(volume->size, (std::array{512, 512, 28}));
}

TEST_F(ImportSpoiltDicom, RefusesAWideGap) {
  for (std::size_t i = 8; i < 14; ++i) fs::remove(slices_[i]);
  const std::string message = error_of(folder_);
  EXPECT_THAT(message, HasSubstr("slices are missing"));
}

TEST_F(ImportSpoiltDicom, RefusesAnotherModality) {
  for (const auto& slice : slices_) {
    std::ifstream file(slice, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(file)), {});
    // (0008,0060) Modality, a CS of two letters: CT becomes MR.
    const auto at = bytes.find(std::string("\x08\0\x60\0CS\x02\0CT", 10));
    ASSERT_NE(at, std::string::npos);
    bytes.replace(at + 8, 2, "MR");
    std::ofstream(slice, std::ios::binary) << bytes;
  }
  EXPECT_THAT(error_of(folder_), HasSubstr("its modality is MR, not CT"));
}

/// A program in the place of morgagni-import that does what the shell lines say.
class ImportProcess : public ImportVolume {
 protected:
  std::string outcome(const std::string& lines, int seconds = 20) {
    const auto program = write("fake", "#!/bin/sh\n" + lines + "\n");
    fs::permissions(program, fs::perms::owner_all);
    const auto volume = internal::run_import_process(
        program, {"volume", "some.nii", {}}, std::chrono::seconds(seconds), {});
    return volume ? "no error" : volume.error().message;
  }
};

TEST_F(ImportProcess, SurvivesTheDeathOfTheChild) {
  EXPECT_THAT(outcome("echo 'f bad.dcm' >&3; kill -SEGV $$"),
              testing::AllOf(HasSubstr("died (Segmentation fault) while reading bad.dcm")));
  EXPECT_THAT(outcome("exit 7"), HasSubstr("ended with code 7 while reading some.nii"));
}

TEST_F(ImportProcess, BelievesNothingTheChildHandsOver) {
  EXPECT_THAT(outcome("exit 0"), HasSubstr("gave no volume"));
  EXPECT_THAT(outcome("head -c 400 /dev/zero >&4"), HasSubstr("gave no volume"));
  EXPECT_THAT(outcome("printf MORVOL01 >&4; head -c 400 /dev/zero >&4"), HasSubstr("0 voxels"));
  EXPECT_THAT(outcome("printf MORVOL01 >&4; head -c 400 /dev/zero | tr '\\0' '\\177' >&4"),
              HasSubstr("voxels along x"));
  EXPECT_THAT(outcome("head -c 100000 /dev/zero >&3; exit 0"), HasSubstr("import process"));
  EXPECT_THAT(outcome("echo 'e 3 so it is' >&3; exit 1"), HasSubstr("so it is"));
}

TEST_F(ImportProcess, EndsAChildThatTakesTooLong) {
  EXPECT_THAT(outcome("exec sleep 60", 1), HasSubstr("took longer than 1 s"));
}

TEST_F(ImportProcess, HandsTheChildNothingButItsTwoFiles) {
  EXPECT_THAT(outcome("ls /proc/self/fd | tr '\\n' ' ' | sed 's/^/e 2 /' >&3; echo >&3; exit 1"),
              testing::AnyOf("0 1 2 3 4 5 ", "0 1 2 3 4 "))
      << "and the folder that ls reads";
}

TEST_F(ImportProcess, SaysSoWhenThereIsNoProgram) {
  const auto volume = internal::run_import_process(
      folder_ / "none", {"volume", "x", {}}, std::chrono::seconds(5), {});
  ASSERT_FALSE(volume);
  EXPECT_THAT(volume.error().message, HasSubstr("cannot start"));
}

}  // namespace
}  // namespace mor
