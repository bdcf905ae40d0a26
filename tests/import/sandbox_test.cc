// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// What an import process that was taken over can do: nothing, and the parent says at which file.
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <linux/landlock.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "morgagni/ct/import_protocol.h"
#include "morgagni/ct/internal/import_process.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Sandbox : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("morgagni_sandbox_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    std::ofstream(folder_ / "evil.nii") << "bytes";
    std::ofstream(folder_ / "secret") << "not yours";
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// What the parent says of an import process that tries this.
  [[nodiscard]] std::string outcome(
      const std::string& attempt,
      std::chrono::seconds time_limit = std::chrono::seconds(60)) const {
    const auto volume =
        internal::run_import_process(std::string(MORGAGNI_TEST_DIR) + "/import_rogue",
                                     {kReadVolumeTask, folder_ / "evil.nii", attempt},
                                     time_limit,
                                     {});
    return volume ? "a volume" : volume.error().message;
  }

  void expect_killed(const std::string& attempt) const {
    EXPECT_THAT(
        outcome(attempt),
        AllOf(HasSubstr("died (Bad system call, it tried what reading a file does not take)"),
              HasSubstr("while reading " + (folder_ / "evil.nii").string())))
        << attempt;
  }
  void expect_refused(const std::string& attempt, const std::string& why) const {
    EXPECT_EQ(outcome(attempt), "refused: " + why) << attempt;
  }

  fs::path folder_;
};

int mib_of(const std::string& sentence) {
  return std::atoi(sentence.c_str() + std::string("took ").size());
}

TEST_F(Sandbox, MemoryEndsAt256MiBBeforeAVolumeIsDeclared) {
  const std::string sentence = outcome("take memory");
  ASSERT_THAT(sentence, AllOf(HasSubstr("took "), Not(HasSubstr("AND MORE"))));
  EXPECT_LE(mib_of(sentence), 256);
  EXPECT_GE(mib_of(sentence), 200);
}

TEST_F(Sandbox, MemoryEndsAtTwiceTheVolumeAnd256MiB) {
  const std::string sentence = outcome("take memory with a volume");
  ASSERT_THAT(sentence, AllOf(HasSubstr("took "), Not(HasSubstr("AND MORE"))));
  // 100 MiB lie in the memory file: the rest of twice the volume and 256 MiB is left.
  EXPECT_LE(mib_of(sentence), 100 + 256);
  EXPECT_GE(mib_of(sentence), 300);
  expect_refused("grow the memory file", "File too large");
}

TEST_F(Sandbox, TimeEnds) {
  EXPECT_THAT(outcome("spin"),
              AllOf(HasSubstr("its time limit) while reading"), HasSubstr("evil.nii")));
  EXPECT_THAT(outcome("wait for ever", std::chrono::seconds(1)),
              AllOf(HasSubstr("evil.nii took longer than 1 s")));
}

TEST_F(Sandbox, WhatNoReaderTriesEndsTheProcess) {
  for (const char* attempt :
       {"open a socket", "run a program", "trace the parent", "kill the parent", "remove the file"})
    expect_killed(attempt);
  EXPECT_TRUE(fs::exists(folder_ / "evil.nii"));
}

TEST_F(Sandbox, TheRestIsRefused) {
  const std::string no = "Operation not permitted";
  for (const char* attempt : {"make a file",
                              "write the file",
                              "make a folder",
                              "fork",
                              "start a thread",
                              "abort the parent",
                              "limit the parent"})
    expect_refused(attempt, no);
  EXPECT_EQ(outcome("read the file"), "IT WORKED");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 2);
}

TEST_F(Sandbox, OtherFilesStayClosed) {
  if (::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION) < 1)
    GTEST_SKIP() << "this kernel has no Landlock";
  for (const char* attempt : {"read another file", "read passwords", "look into processes"})
    expect_refused(attempt, "Permission denied");
}

TEST_F(Sandbox, SaysWhatDoesNotHoldOnThisMachine) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  EXPECT_EQ(outcome("no Landlock"), "IT WORKED");
  EXPECT_EQ(outcome("no Landlock"), "IT WORKED");
  std::string said = testing::internal::GetCapturedStdout();
  said += testing::internal::GetCapturedStderr();
  const std::string sentence =
      "can open all that you can (Landlock: Function not implemented): read no files that nobody";
  EXPECT_THAT(said, HasSubstr(sentence));
  EXPECT_EQ(said.find(sentence), said.rfind(sentence)) << "said once: " << said;
  EXPECT_THAT(outcome("no seccomp"), HasSubstr("nothing is read, because"));
}

TEST_F(Sandbox, DeathAndSilenceAreToldWithTheFile) {
  EXPECT_THAT(outcome("crash"),
              HasSubstr("died (Segmentation fault) while reading " +
                        (folder_ / "evil.nii").string() + ": the file may be damaged"));
  EXPECT_EQ(outcome("end well with nothing"), "evil.nii: the import process gave no volume");
}

}  // namespace
}  // namespace mor
