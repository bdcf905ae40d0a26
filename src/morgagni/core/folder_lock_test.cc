// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/folder_lock.h"

#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

namespace fs = std::filesystem;

TEST(FolderLock, KeepsOthersOutUntilItEnds) {
  const fs::path folder = fs::path(testing::TempDir()) / "folder_lock_test";
  fs::create_directories(folder);
  auto first = FolderLock::take(folder, FolderLock::Kind::kShared, "busy");
  ASSERT_TRUE(first) << first.error().message;
  std::optional<FolderLock> moved(*std::move(first));
  EXPECT_TRUE(FolderLock::take(folder, FolderLock::Kind::kShared, "busy"));
  const auto refused = FolderLock::take(folder, FolderLock::Kind::kExclusive, "somebody has it");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, "somebody has it");
  moved.reset();
  EXPECT_TRUE(FolderLock::take(folder, FolderLock::Kind::kExclusive, "busy"));
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST(FolderLock, SaysWhichFolderIsNotThere) {
  const auto refused = FolderLock::take("/no/such/folder", FolderLock::Kind::kShared, "busy");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, testing::HasSubstr("/no/such/folder"));
}

}  // namespace
}  // namespace mor
