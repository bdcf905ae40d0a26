// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST(Files, WriteReplacesTheOldFileWhole) {
  const fs::path path = fs::path(testing::TempDir()) / "replaced.txt";
  ASSERT_TRUE(write_file(path, "old and long"));
  ASSERT_TRUE(write_file(path, "new"));
  EXPECT_EQ(read_text_file(path, 100).value(), "new");
}

TEST(Files, AFailedWriteLeavesNothingBehind) {
  const fs::path place = fs::path(testing::TempDir()) / "failed_write";
  const fs::path folder = place / "a_folder_in_the_way";
  fs::create_directories(folder / "inside");
  const auto written = write_file(folder, "text");
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().message, HasSubstr("a_folder_in_the_way"));
  for (const auto& entry : fs::directory_iterator(place)) {
    EXPECT_NE(entry.path().extension(), ".part") << entry.path();
  }
}

TEST(Files, ReadNamesTheSizeAndTheLimit) {
  const fs::path path = fs::path(testing::TempDir()) / "large.txt";
  ASSERT_TRUE(write_file(path, "0123456789"));
  const auto text = read_text_file(path, 4);
  ASSERT_FALSE(text);
  EXPECT_THAT(text.error().message, HasSubstr("has 10 bytes, the limit is 4"));
}

TEST(Files, HashIsTheKnownOne) {
  const std::string text = "abc";  // FIPS 180-4, appendix B.1
  EXPECT_EQ(sha256_hex(std::as_bytes(std::span(text))),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  const fs::path path = fs::path(testing::TempDir()) / "abc.txt";
  ASSERT_TRUE(write_file(path, text));
  EXPECT_EQ(sha256_hex_of_file(path).value(), sha256_hex(std::as_bytes(std::span(text))));
}

}  // namespace
}  // namespace mor
