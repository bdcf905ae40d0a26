// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/casefile/kept_folders.h"

#include <chrono>
#include <csignal>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "morgagni/casefile/case.h"
#include "morgagni/casefile/prepare.h"
#include "morgagni/casefile/testing/synthetic_ct.h"
#include "morgagni/core/folder_lock.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const Progress kQuiet = [](std::string_view, double) {};

class KeptFolders : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(place_);
    fs::create_directories(place_);
    testing_ct::write_synthetic_ct(ct_);
    ASSERT_TRUE(prepare_case(ct_, case_, options(2000), kQuiet));
    for (const char* const name : kKeptFolders) {
      fs::create_directories(case_ / name / "deeper");
      ASSERT_TRUE(write_file(case_ / name / "a.json", std::string("made in ") + name));
      ASSERT_TRUE(write_file(case_ / name / "deeper" / "b.bin", std::string(5000, 'b')));
    }
    fs::create_symlink("a.json", case_ / "findings" / "link");
  }

  static PrepareOptions options(int num_vertices) {
    PrepareOptions options;
    options.skin.num_vertices = num_vertices;
    options.bone.num_triangles = 2000;
    return options;
  }

  void expect_all_kept(const std::string& when) const {
    for (const char* const name : kKeptFolders) {
      const fs::path folder = case_ / name;
      ASSERT_EQ(read_text_file(folder / "a.json", 100).value_or("lost"),
                std::string("made in ") + name)
          << when;
      ASSERT_EQ(read_text_file(folder / "deeper" / "b.bin", 5000).value_or("lost").size(), 5000U)
          << when;
    }
    ASSERT_EQ(fs::read_symlink(case_ / "findings" / "link"), "a.json") << when;
  }

  /// Dies without a word at the given word of progress.
  int prepare_and_die(double at) const {
    const pid_t child = fork();
    if (child == 0) {
      static_cast<void>(
          prepare_case(ct_, case_, options(500), [at](std::string_view stage, double fraction) {
            if (stage == "write case" && fraction == at) raise(SIGKILL);
          }));
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  }

  /// Of each test its own: what a killed preparation leaves is removed a moment after its death.
  const fs::path place_ = fs::path(testing::TempDir()) / "kept_folders_test" /
                          testing::UnitTest::GetInstance()->current_test_info()->name();
  const fs::path ct_ = place_ / "egg.mha";
  const fs::path case_ = place_ / "case";
};

TEST_F(KeptFolders, StayWhenTheCaseIsPreparedAnew) {
  const auto before = load_case(case_)->skin->mesh.vertices.size();
  ASSERT_TRUE(prepare_case(ct_, case_, options(1000), kQuiet));
  EXPECT_LT(load_case(case_)->skin->mesh.vertices.size(), before);
  expect_all_kept("after another preparation");
  ASSERT_TRUE(prepare_case(ct_, case_, options(1000), kQuiet));
  expect_all_kept("after a third one");
}

TEST_F(KeptFolders, SurviveAKillAtEachStep) {
  for (const double at : {0.0, 0.8, 0.9, 1.0}) {
    ASSERT_EQ(prepare_and_die(at), SIGKILL);
    expect_all_kept("killed at " + std::to_string(at));
    ASSERT_TRUE(load_case(case_)) << "killed at " << at;
  }
  ASSERT_TRUE(prepare_case(ct_, case_, options(1000), kQuiet));
  expect_all_kept("after the next whole run");
  for (const auto& entry : fs::directory_iterator(place_))
    EXPECT_EQ(entry.path().string().find(".part-"), std::string::npos) << entry.path();
}

TEST_F(KeptFolders, SurviveKillsAtAnyMoment) {
  // Without the tail of the run, which has most of the steps, the kills would all be early.
  const auto started = std::chrono::steady_clock::now();
  ASSERT_TRUE(prepare_case(ct_, case_, options(500), kQuiet));
  const auto whole = std::chrono::steady_clock::now() - started;
  constexpr int kNumKills = 6;
  for (int i = 0; i < kNumKills; ++i) {
    const pid_t child = fork();
    if (child == 0) {
      static_cast<void>(prepare_case(ct_, case_, options(500), kQuiet));
      _exit(0);
    }
    std::this_thread::sleep_for(whole * (kNumKills + i) / (2 * kNumKills));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    expect_all_kept("kill " + std::to_string(i));
    ASSERT_TRUE(load_case(case_)) << "kill " << i;
  }
}

TEST_F(KeptFolders, AreNotTakenOverByAnotherCt) {
  const fs::path other = place_ / "other.mha";
  auto bytes = read_file(ct_, 1U << 30U).value();
  bytes[bytes.size() / 2] ^= std::byte{1};  // One voxel.
  ASSERT_TRUE(write_file(other, bytes));
  const auto refused = prepare_case(other, case_, options(500), kQuiet);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("made on another CT"));
  EXPECT_THAT(refused.error().message, HasSubstr("name another folder"));
  expect_all_kept("after the refusal");
  for (const char* const name : kKeptFolders) fs::remove_all(case_ / name);
  fs::create_directories(case_ / "cts" / "before");
  ASSERT_TRUE(write_file(case_ / "cts" / "before" / kCaseFile, std::string("{}")));
  ASSERT_FALSE(prepare_case(other, case_, options(500), kQuiet))
      << "a CT was added to the first one";
  fs::remove_all(case_ / "cts");
  EXPECT_TRUE(prepare_case(other, case_, options(500), kQuiet))
      << "nothing there that could be lost";
}

TEST_F(KeptFolders, AreNotGivenToACtThatLiesElsewhere) {
  auto text = read_text_file(ct_, 1U << 30U).value();
  const auto at = text.find("Offset = -95");
  text.replace(at, 12, "Offset = -94");
  const fs::path moved = place_ / "moved.mha";
  ASSERT_TRUE(write_file(moved, text));
  ASSERT_FALSE(prepare_case(moved, case_, options(500), kQuiet));
  expect_all_kept("after the refusal");
}

TEST_F(KeptFolders, AreSafeFromACaseJsonThatSaysNothing) {
  ASSERT_TRUE(write_file(case_ / kCaseFile, "{\"ct\": 3}"));
  const auto refused = prepare_case(ct_, case_, options(500), kQuiet);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("another CT"));
  expect_all_kept("after the refusal");
}

TEST_F(KeptFolders, ACaseInUseIsNotPreparedAnew) {
  const auto held = FolderLock::take(case_, FolderLock::Kind::kShared, "");
  ASSERT_TRUE(held);
  const auto refused = prepare_case(ct_, case_, options(500), kQuiet);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("in use by another Morgagni"));
}

}  // namespace
}  // namespace mor
