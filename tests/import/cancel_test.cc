// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// `morgagni prepare` ended at many moments, by Ctrl-C, SIGTERM and kill -9: nothing is left beside
// the case, and the case is the old one or the new one, whole.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "morgagni/stream/testing/http_client.h"

namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

/// A ball of muscle with a ball of bone in it, in air.
std::string ball_ct() {
  constexpr int kSide = 100;
  std::string file =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 100 100 100\n"
      "ElementSpacing = 3 3 3\nElementType = MET_SHORT\nElementDataFile = LOCAL\n";
  for (int z = 0; z < kSide; ++z)
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const double radius = std::hypot(x - 50.0, y - 50.0, z - 50.0);
        const std::int16_t hu = radius < 15.0 ? 900 : radius < 42.0 ? 40 : -1000;
        file.append(reinterpret_cast<const char*>(&hu), 2);
      }
  return file;
}

class Cancelled : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("morgagni_cancel_" + std::to_string(::getpid()));
    fs::create_directories(folder_ / "place");
    std::ofstream(folder_ / "ball.mha", std::ios::binary) << ball_ct();
    const auto started = Clock::now();
    ASSERT_EQ(end_of(start()), 0);
    whole_run_ = std::chrono::duration_cast<milliseconds>(Clock::now() - started);
    fs::create_directories(case_folder() / "findings");
    std::ofstream(case_folder() / "findings" / "mine.json") << "{}";
    before_ = contents();
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] fs::path case_folder() const { return folder_ / "place" / "case"; }

  /// @param output  Where its words go.
  [[nodiscard]] pid_t start(const std::vector<std::string>& more = {},
                            const fs::path& output = "/dev/null") const {
    std::vector<std::string> words = {std::string(MORGAGNI_BIN_DIR) + "/morgagni",
                                      "prepare",
                                      (folder_ / "ball.mha").string(),
                                      "--case",
                                      case_folder().string()};
    words.insert(words.end(), more.begin(), more.end());
    std::vector<char*> arguments(words.size() + 1);
    std::transform(words.begin(), words.end(), arguments.begin(), [](auto& w) { return w.data(); });
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(
        &actions, 1, output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
    pid_t child = -1;
    EXPECT_EQ(::posix_spawn(&child, words[0].c_str(), &actions, nullptr, arguments.data(), environ),
              0);
    posix_spawn_file_actions_destroy(&actions);
    return child;
  }

  static bool is_running(pid_t child) {
    siginfo_t info{};
    ::waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT);
    return info.si_pid == 0;
  }

  static int end_of(pid_t child) {
    int status = -1;
    ::waitpid(child, &status, 0);
    return status;
  }

  /// Of the case: what each file holds.
  [[nodiscard]] std::map<std::string, std::string> contents() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(case_folder())) {
      if (!entry.is_regular_file() || entry.path().filename() == "case.json") continue;
      std::ifstream file(entry.path(), std::ios::binary);
      files[entry.path().lexically_relative(case_folder())].assign(
          std::istreambuf_iterator<char>(file), {});
    }
    return files;
  }

  [[nodiscard]] std::size_t num_beside() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_ / "place"), fs::directory_iterator()));
  }

  /// Import processes and watchers that have this test's files in their arguments.
  [[nodiscard]] bool is_anyone_left() const {
    for (const auto& entry : fs::directory_iterator("/proc")) {
      if (entry.path().filename() == std::to_string(::getpid())) continue;
      std::ifstream file(entry.path() / "cmdline", std::ios::binary);
      const std::string words(std::istreambuf_iterator<char>(file), {});
      if (words.find(folder_.string()) != std::string::npos) return true;
    }
    return false;
  }

  /// What is left goes within moments of the process.
  void expect_nothing_left() const {
    const auto deadline = Clock::now() + std::chrono::seconds(20);
    while ((num_beside() != 1 || is_anyone_left()) && Clock::now() < deadline)
      std::this_thread::sleep_for(milliseconds(5));
    EXPECT_EQ(num_beside(), 1U);
    EXPECT_FALSE(is_anyone_left());
    // The voxels decide the rest: the old case and the new one are alike, file by file.
    EXPECT_EQ(contents(), before_);
    EXPECT_TRUE(fs::exists(case_folder() / "case.json"));
  }

  fs::path folder_;
  milliseconds whole_run_{};
  std::map<std::string, std::string> before_;
};

TEST_F(Cancelled, AtAnyMomentLeavesNothingBehind) {
  constexpr int kNumMoments = 5;
  int num_cut = 0;
  for (const int signal : {SIGINT, SIGTERM, SIGKILL}) {
    for (int i = 0; i < kNumMoments; ++i) {
      SCOPED_TRACE(std::to_string(signal) + " at moment " + std::to_string(i));
      const pid_t child = start();
      std::this_thread::sleep_for(whole_run_ * i / kNumMoments);
      ::kill(child, signal);
      if (WIFSIGNALED(end_of(child))) ++num_cut;
      expect_nothing_left();
      if (HasFailure()) return;
    }
  }
  EXPECT_GE(num_cut, 3 * kNumMoments / 2);
}

/// The moments that matter most: files are being written aside, exchanged, and the old ones
/// removed.
TEST_F(Cancelled, WhileItWritesLeavesNothingBehind) {
  for (const int signal : {SIGINT, SIGTERM, SIGKILL}) {
    for (const int delay_ms : {0, 2, 10, 30}) {
      SCOPED_TRACE(std::to_string(signal) + " after " + std::to_string(delay_ms) + " ms");
      const pid_t child = start();
      const auto deadline = Clock::now() + std::chrono::seconds(60);
      while (num_beside() == 1 && is_running(child) && Clock::now() < deadline)
        std::this_thread::sleep_for(std::chrono::microseconds(500));
      std::this_thread::sleep_for(milliseconds(delay_ms));
      ::kill(child, signal);
      end_of(child);
      expect_nothing_left();
      if (HasFailure()) return;
    }
  }
}

/// The page of `--check`, once "Use it" is pressed.
TEST_F(Cancelled, WhileThePageMakesTheCaseEndsAtOnce) {
  const fs::path output = folder_ / "output";
  std::ofstream(folder_ / "index.html") << "no page";
  const pid_t child = start({"--check", "--web", folder_.string()}, output);
  std::smatch address;
  std::string words;
  for (int i = 0; i < 600 && !std::regex_search(words, address, std::regex(":([0-9]+)/")); ++i) {
    std::this_thread::sleep_for(milliseconds(50));
    std::ifstream file(output);
    words.assign(std::istreambuf_iterator<char>(file), {});
  }
  ASSERT_FALSE(address.empty()) << words;
  const auto port = static_cast<std::uint16_t>(std::stoi(address[1]));
  ASSERT_EQ(mor::testing::request(port, "POST", "/api/check/use").status, 200);
  std::this_thread::sleep_for(whole_run_ / 10);
  ::kill(child, SIGINT);
  EXPECT_TRUE(WIFSIGNALED(end_of(child)));
  expect_nothing_left();
}

TEST_F(Cancelled, BeforeThereIsACaseLeavesNone) {
  fs::remove_all(case_folder());
  const pid_t child = start();
  while (num_beside() == 0 && is_running(child))
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  ::kill(child, SIGKILL);
  end_of(child);
  const auto deadline = Clock::now() + std::chrono::seconds(20);
  while (num_beside() != 0 && !fs::exists(case_folder()) && Clock::now() < deadline)
    std::this_thread::sleep_for(milliseconds(5));
  EXPECT_TRUE(num_beside() == 0 || (num_beside() == 1 && fs::exists(case_folder() / "case.json")));
}

}  // namespace
