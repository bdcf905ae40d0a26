// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// What a DICOM connection's process that was taken over can do: receive, and nothing else.
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <linux/landlock.h>
#include <nlohmann/json.hpp>
#include <sys/syscall.h>
#include <unistd.h>

#include "morgagni/pacs/internal/dimse_process.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

class DimseConfinement : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("morgagni_dimse_" + std::to_string(::getpid()));
    fs::create_directories(folder_ / "received");
    fs::create_directories(folder_ / "received" / "parts");
    std::ofstream(folder_ / "secret") << "not yours";
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string outcome(const std::string& attempt) const {
    const nlohmann::json task = {{"task", attempt},
                                 {"folder", (folder_ / "received").string()},
                                 {"parts", (folder_ / "received" / "parts").string()}};
    const auto done = internal::run_dimse_process(
        std::string(MORGAGNI_TEST_DIR) + "/dimse_rogue", {.task = task.dump()}, {}, {});
    return done ? "nothing" : done.error().message;
  }

  fs::path folder_;
};

TEST_F(DimseConfinement, LeavesWhatAConnectionTakes) {
  for (const char* attempt : {"receive", "find a host", "own tgkill"})
    EXPECT_EQ(outcome(attempt), "IT WORKED") << attempt;
  EXPECT_TRUE(fs::exists(folder_ / "received" / "1.2" / "3.4" / "5.6.dcm"));
}

TEST_F(DimseConfinement, ForbidsOtherProcessesAndTheKernelsBackDoors) {
  for (const char* attempt : {"kill",
                              "tgkill",
                              "rt_sigqueueinfo",
                              "rt_tgsigqueueinfo",
                              "pidfd_open",
                              "pidfd_send_signal",
                              "process_vm_writev",
                              "prlimit64",
                              "io_uring_setup",
                              "open_tree",
                              "move_mount",
                              "fsopen",
                              "execve",
                              "truncate"})
    EXPECT_EQ(outcome(attempt), "refused: Operation not permitted") << attempt;
}

TEST_F(DimseConfinement, ClosesOtherFiles) {
  constexpr int kFirstThatMovesFiles = 2;
  if (::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION) <
      kFirstThatMovesFiles)
    GTEST_SKIP() << "this kernel's Landlock is too old";
  for (const char* attempt : {"read another file",
                              "write another file",
                              "remove another file",
                              "make a file",
                              "read passwords",
                              "look into processes"})
    EXPECT_EQ(outcome(attempt), "refused: Permission denied") << attempt;
}

}  // namespace
}  // namespace mor
