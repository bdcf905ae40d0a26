// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/geometry/volume_io.h"

#include <cstring>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/core/files.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

Volume noise() {
  Volume volume;
  volume.size = {37, 21, 9};
  volume.spacing_mm = {0.7, 0.8, 2.5};
  volume.ct_from_grid.translation() = Eigen::Vector3d(-12.5, 40.0, 900.25);
  volume.ct_from_grid.linear() =
      Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  std::mt19937 random(1);
  for (int i = 0; i < 37 * 21 * 9; ++i) volume.hu.push_back(static_cast<std::int16_t>(random()));
  return volume;
}

class VolumeIoTest : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(write_volume(path_, noise())); }
  std::string message() const {
    const auto read = read_volume(path_);
    return read ? "it was read" : read.error().message;
  }
  const fs::path path_ = fs::path(testing::TempDir()) / "volume_io_test.volume";
};

TEST_F(VolumeIoTest, ReadsWhatItWrote) {
  const auto read = read_volume(path_);
  ASSERT_TRUE(read) << read.error().message;
  const Volume truth = noise();
  EXPECT_EQ(read->size, truth.size);
  EXPECT_EQ(read->hu, truth.hu);
  EXPECT_EQ(read->spacing_mm, truth.spacing_mm);
  EXPECT_EQ(read->ct_from_grid.matrix(), truth.ct_from_grid.matrix());
}

TEST_F(VolumeIoTest, RefusesEveryTruncation) {
  const auto bytes = read_file(path_, 1U << 20U).value();
  for (std::size_t size = 0; size < bytes.size(); size += 97) {
    ASSERT_TRUE(write_file(path_, std::span(bytes).first(size)));
    EXPECT_THAT(message(), HasSubstr("prepare the case again")) << size;
  }
}

TEST_F(VolumeIoTest, AllocatesNothingThatTheFileCannotFill) {
  auto bytes = read_file(path_, 1U << 20U).value();
  const std::int32_t huge = 4096;
  std::memcpy(bytes.data() + 12, &huge, sizeof huge);
  std::memcpy(bytes.data() + 16, &huge, sizeof huge);
  ASSERT_TRUE(write_file(path_, bytes));
  EXPECT_THAT(message(), HasSubstr("truncated"));
  const std::int32_t negative = -1;
  std::memcpy(bytes.data() + 12, &negative, sizeof negative);
  ASSERT_TRUE(write_file(path_, bytes));
  EXPECT_THAT(message(), HasSubstr("impossible"));
}

TEST_F(VolumeIoTest, WritesNoVolumeWithoutVoxels) {
  EXPECT_FALSE(write_volume(path_, Volume{}));
  EXPECT_TRUE(read_volume(path_)) << "the old file stays";
}

}  // namespace
}  // namespace mor
