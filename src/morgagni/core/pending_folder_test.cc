// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/pending_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/core/files.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

fs::path fresh_place(const std::string& name) {
  const fs::path place = fs::path(testing::TempDir()) / name;
  fs::remove_all(place);
  fs::create_directories(place);
  return place;
}

TEST(PendingFolder, AppearsOnlyWhenCommitted) {
  const fs::path target = fresh_place("pending_appears") / "case";
  {
    auto pending = PendingFolder::create(target).value();
    ASSERT_TRUE(write_file(pending.path() / "a", "new"));
    EXPECT_FALSE(fs::exists(target));
    ASSERT_TRUE(pending.commit());
  }
  EXPECT_EQ(read_text_file(target / "a", 10).value(), "new");
}

TEST(PendingFolder, LeavesNothingWhenAbandoned) {
  const fs::path place = fresh_place("pending_abandoned");
  { const auto pending = PendingFolder::create(place / "case").value(); }
  EXPECT_TRUE(fs::is_empty(place));
}

TEST(PendingFolder, ReplacesTheOldFolderWhole) {
  const fs::path place = fresh_place("pending_replaces");
  fs::create_directories(place / "case");
  ASSERT_TRUE(write_file(place / "case" / "old", "old"));
  {
    auto pending = PendingFolder::create(place / "case").value();
    ASSERT_TRUE(write_file(pending.path() / "new", "new"));
    EXPECT_TRUE(fs::exists(place / "case" / "old"));
    ASSERT_TRUE(pending.commit());
  }
  EXPECT_TRUE(fs::exists(place / "case" / "new"));
  EXPECT_FALSE(fs::exists(place / "case" / "old"));
  EXPECT_EQ(std::distance(fs::directory_iterator(place), {}), 1);
}

TEST(PendingFolder, SweepsWhatAKilledRunLeft) {
  const fs::path place = fresh_place("pending_sweeps");
  fs::create_directories(place / "case.part-999999999");
  { const auto pending = PendingFolder::create(place / "case").value(); }
  EXPECT_TRUE(fs::is_empty(place));
}

TEST(PendingFolder, TakesATrailingSlash) {
  const fs::path place = fresh_place("pending_slash");
  {
    auto pending = PendingFolder::create((place / "case").string() + "/").value();
    ASSERT_TRUE(pending.commit());
  }
  EXPECT_TRUE(fs::is_directory(place / "case"));
}

TEST(PendingFolder, SaysWhereItCannotWrite) {
  const fs::path place = fresh_place("pending_blocked");
  ASSERT_TRUE(write_file(place / "file", "in the way"));
  const auto pending = PendingFolder::create(place / "file" / "case");
  ASSERT_FALSE(pending);
  EXPECT_THAT(pending.error().message, testing::HasSubstr("cannot be written"));
}

}  // namespace
}  // namespace mor
