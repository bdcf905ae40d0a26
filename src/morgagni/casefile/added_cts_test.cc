// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/casefile/added_cts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/casefile/case.h"
#include "morgagni/casefile/prepare.h"
#include "morgagni/casefile/testing/synthetic_ct.h"
#include "morgagni/core/folder_lock.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

const Progress kQuiet = [](std::string_view, double) {};

class AddedCts : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(place_);
    fs::create_directories(place_);
    testing_ct::write_synthetic_ct(ct_);
    options_.skin.num_vertices = 500;
    options_.skin.sub_sampling = 1;
    options_.bone.num_triangles = 500;
  }

  Result<PrepareSummary> prepare(const fs::path& folder) {
    fs::create_directories(folder.parent_path());
    return prepare_case(ct_, folder, options_, kQuiet);
  }

  const fs::path place_ = fs::path(testing::TempDir()) / "added_cts_test";
  const fs::path ct_ = place_ / "egg.mha";
  const fs::path case_ = place_ / "0815";
  PrepareOptions options_;
};

TEST_F(AddedCts, StandInTheCaseWithFindingsOfTheirOwn) {
  ASSERT_TRUE(prepare(case_));
  EXPECT_THAT(added_cts(case_), testing::IsEmpty());
  const fs::path before = ct_folder(case_, "before").value();
  ASSERT_TRUE(prepare(before));
  EXPECT_THAT(added_cts(case_), ElementsAre("before"));
  EXPECT_EQ(load_case(find_ct(case_, "").value())->name, "0815");
  EXPECT_EQ(load_case(find_ct(case_, "before").value())->name, "0815, before");

  // What people made on either stays with it when the case's first CT is prepared anew.
  fs::create_directories(before / "findings");
  fs::create_directories(case_ / "findings");
  ASSERT_TRUE(write_file(before / "findings" / "findings.json", "of the added one"));
  ASSERT_TRUE(write_file(case_ / "findings" / "findings.json", "of the first"));
  ASSERT_TRUE(prepare(case_));
  EXPECT_TRUE(load_case(before)) << "the added CT is whole";
  EXPECT_EQ(read_text_file(before / "findings" / "findings.json", 100).value(), "of the added one");
  EXPECT_EQ(read_text_file(case_ / "findings" / "findings.json", 100).value(), "of the first");
  ASSERT_TRUE(prepare(before));
  EXPECT_EQ(read_text_file(before / "findings" / "findings.json", 100).value(), "of the added one");
}

TEST_F(AddedCts, AreNotPulledAwayFromWhoUsesThem) {
  ASSERT_TRUE(prepare(case_));
  const fs::path before = ct_folder(case_, "before").value();
  ASSERT_TRUE(prepare(before));
  {
    const auto served = FolderLock::take(before, FolderLock::Kind::kShared, "busy");
    ASSERT_TRUE(served);
    const auto refused = prepare(case_);
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message, HasSubstr("before is in use by another Morgagni"));
    EXPECT_FALSE(prepare(before));
    EXPECT_TRUE(prepare(ct_folder(case_, "after").value())) << "another one may be added";
  }
  // While one is added the case is not exchanged under it.
  const auto prepared = FolderLock::take(case_, FolderLock::Kind::kExclusive, "busy");
  ASSERT_TRUE(prepared);
  EXPECT_FALSE(prepare(before));
}

TEST_F(AddedCts, HaveNamesThatLeadNowhereElse) {
  for (const char* name : {"../other", ".hidden", "a/b", "tab\there", "x.part-12", " blank"}) {
    const auto folder = ct_folder(case_, name);
    ASSERT_FALSE(folder) << name;
    EXPECT_THAT(folder.error().message, HasSubstr("a CT's name has 1 to 60 letters"));
  }
  EXPECT_EQ(ct_folder(case_, "Kopf 2").value(), case_ / "cts" / "Kopf 2");
  EXPECT_EQ(ct_folder(case_, "Schädel").value(), case_ / "cts" / "Schädel");
  EXPECT_EQ(ct_folder(case_, "").value(), case_);
  EXPECT_THAT(find_ct(case_, "none").error().message,
              HasSubstr("has one CT only: add \"none\" with"));
}

}  // namespace
}  // namespace mor
