// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/finding_book.h"

#include <csignal>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "morgagni/core/files.h"
#include "morgagni/documentation/findings_io.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class FindingBookTest : public testing::Test {
 protected:
  void SetUp() override { fs::remove_all(folder_); }

  static Finding point(const std::string& note) {
    Finding finding;
    finding.note = note;
    finding.points = {{.ct_mm = {1, 2, 3}, .is_on_skin = true, .bound_mm = 2.0}};
    return finding;
  }

  std::vector<std::string> on_disk() const {
    std::vector<std::string> list;
    const auto findings = read_findings(folder_).value();
    for (const auto& finding : findings)
      list.push_back(finding.id + ": " + finding.note);
    return list;
  }

  const fs::path folder_ = fs::path(testing::TempDir()) / "finding_book_test" / "findings";
  const std::vector<std::byte> png_ = {std::byte{1}, std::byte{2}};
};

TEST_F(FindingBookTest, KeepsEachChangeOnDisk) {
  auto book = FindingBook::open(folder_).value();
  const auto first = book.add(point("bruise"), {.plain = png_, .overlay = png_});
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_EQ(first->id, "F1");
  EXPECT_EQ(first->photo, "F1.png");
  EXPECT_THAT(first->created_at, testing::MatchesRegex("2...-..-..T..:..:..Z"));
  EXPECT_TRUE(fs::exists(folder_ / "F1.png"));
  EXPECT_TRUE(fs::exists(folder_ / "F1_overlay.png"));
  ASSERT_TRUE(book.add(point("scar"), {}));
  EXPECT_THAT(on_disk(), testing::ElementsAre("F1: bruise", "F2: scar"));
  ASSERT_TRUE(book.set_note("F1", "old bruise"));
  ASSERT_TRUE(book.remove("F2"));
  EXPECT_THAT(on_disk(), testing::ElementsAre("F1: old bruise"));
  EXPECT_EQ(book.add(point("again"), {})->id, "F3") << "F2 was somebody else";
}

TEST_F(FindingBookTest, UndoesStepByStep) {
  auto book = FindingBook::open(folder_).value();
  EXPECT_EQ(book.undoable(), "");
  EXPECT_THAT(book.undo().error().message, HasSubstr("nothing to undo"));
  ASSERT_TRUE(book.add(point("a"), {}));
  ASSERT_TRUE(book.set_note("F1", "b"));
  ASSERT_TRUE(book.remove("F1"));
  EXPECT_EQ(book.undoable(), "the deletion of F1");
  ASSERT_TRUE(book.undo());
  EXPECT_THAT(on_disk(), testing::ElementsAre("F1: b"));
  EXPECT_EQ(book.undoable(), "the new note of F1");
  ASSERT_TRUE(book.undo());
  EXPECT_THAT(on_disk(), testing::ElementsAre("F1: a"));
  ASSERT_TRUE(book.undo());
  EXPECT_TRUE(on_disk().empty());
  EXPECT_EQ(book.add(point("c"), {})->id, "F2") << "an undone number stays used";
}

TEST_F(FindingBookTest, OnlyOneWritesAndNobodysFindingsAreLost) {
  auto first = FindingBook::open(folder_).value();
  auto late = FindingBook::open(folder_).value();  // Both saw an empty folder.
  {
    auto second = FindingBook::open(folder_).value();
    ASSERT_TRUE(second.add(point("of the second"), {}));
    const auto refused = first.add(point("of the first"), {});
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message, HasSubstr("another Morgagni writes"));
  }
  ASSERT_TRUE(late.add(point("of the late one"), {}));
  EXPECT_THAT(on_disk(), testing::ElementsAre("F1: of the second", "F2: of the late one"));
}

TEST_F(FindingBookTest, AKillAtAnyMomentLosesNoFindingThatWasAnswered) {
  int answered[2];
  ASSERT_EQ(pipe(answered), 0);
  const pid_t child = fork();
  if (child == 0) {
    auto book = FindingBook::open(folder_).value();
    for (;;) {
      const auto added = book.add(point("x"), {.plain = png_, .overlay = {}});
      if (!added || write(answered[1], "x", 1) != 1) _exit(1);
    }
  }
  char byte = 0;
  for (int i = 0; i < 25; ++i) ASSERT_EQ(read(answered[0], &byte, 1), 1);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  close(answered[1]);
  std::size_t num_answered = 25;
  while (read(answered[0], &byte, 1) == 1) ++num_answered;
  close(answered[0]);
  const auto kept = read_findings(folder_);
  ASSERT_TRUE(kept) << kept.error().message;
  EXPECT_GE(kept->size(), num_answered);
  for (const auto& finding : *kept) EXPECT_TRUE(fs::exists(folder_ / finding.photo));
}

TEST_F(FindingBookTest, RefusesAndStaysAsItWas) {
  auto book = FindingBook::open(folder_).value();
  ASSERT_TRUE(book.add(point("a"), {}));
  EXPECT_FALSE(book.add(point(std::string(5000, 'x')), {}));
  EXPECT_FALSE(book.set_note("F1", "\x07"));
  EXPECT_THAT(book.set_note("F9", "b").error().message, HasSubstr("no finding F9"));
  EXPECT_THAT(book.remove("<img src=x>").error().message, HasSubstr("no such finding"));
  EXPECT_THAT(on_disk(), testing::ElementsAre("F1: a"));
}

TEST(StraightLength, AddsTheBoundsAsIndependentErrors) {
  const FindingPoint a{.ct_mm = {0, 0, 0}, .is_on_skin = true, .bound_mm = 3.0};
  FindingPoint b{.ct_mm = {30, 40, 0}, .is_on_skin = false, .bound_mm = 4.0};
  EXPECT_DOUBLE_EQ(straight_length(a, b).length_mm, 50.0);
  EXPECT_DOUBLE_EQ(straight_length(a, b).bound_mm.value(), 5.0);
  b.bound_mm.reset();
  EXPECT_FALSE(straight_length(a, b).bound_mm);
}

}  // namespace
}  // namespace mor
