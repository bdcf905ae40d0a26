// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The video as a player of somebody else's sees it: ffprobe and ffmpeg.
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "morgagni/stream/live_server.h"
#include "morgagni/stream/testing/test_pattern.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using std::chrono::milliseconds;
using ::testing::HasSubstr;
using testing::TestPattern;

constexpr int kWidth = 401;
constexpr int kHeight = 302;

fs::path folder() {
  return fs::path(::testing::TempDir()) / "video_recorder_test";
}

VideoFiles files() {
  return {folder() / "video.webm", folder() / "video.jsonl"};
}

std::string output_of(const std::string& command) {
  std::string text;
  FILE* const pipe = popen((command + " 2>/dev/null").c_str(), "r");
  std::array<char, 65536> buffer{};
  for (std::size_t count = 0; (count = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    text.append(buffer.data(), count);
  pclose(pipe);
  return text;
}

Json probe(const fs::path& video) {
  return Json::parse(output_of(
      "ffprobe -v error -count_frames -show_streams -show_format -show_frames -of json '" +
      video.string() + "'"));
}

std::vector<Json> lines_of(const fs::path& path) {
  std::ifstream in(path);
  std::vector<Json> lines;
  for (std::string line; std::getline(in, line);)
    lines.push_back(Json::parse(line, nullptr, /*allow_exceptions=*/false));
  return lines;
}

/// The numbers that the pictures of the video say in their pixels.
std::vector<std::uint32_t> numbers_in(const fs::path& video) {
  const std::string grey =
      output_of("ffmpeg -v error -i '" + video.string() + "' -f rawvideo -pix_fmt gray -vsync 0 -");
  std::vector<std::uint32_t> numbers;
  for (std::size_t start = 0; start + kWidth * kHeight <= grey.size(); start += kWidth * kHeight) {
    std::uint32_t number = 0;
    for (int bit = 0; bit < TestPattern::kNumBits; ++bit) {
      const std::size_t at = start + (kHeight - TestPattern::kBitPx / 2) * std::size_t{kWidth} +
                             static_cast<std::size_t>((2 * bit + 1) * TestPattern::kBitPx / 2);
      number = number << 1U | (static_cast<unsigned char>(grey[at]) > 127 ? 1U : 0U);
    }
    numbers.push_back(number);
  }
  return numbers;
}

/// A server that shows a picture each 33 ms, with its number in its words.
class Show {
 public:
  Show() {
    fs::create_directories(folder() / "page");
    std::ofstream(folder() / "page" / "index.html") << "<p>page</p>";
    server_ = LiveServer::start({.port = 0, .web_root = folder() / "page"}, {}).value();
    thread_ = std::jthread([this](std::stop_token stop) {
      TestPattern pattern(kWidth, kHeight);
      TestPattern small(kWidth, kHeight / 2);
      auto next = std::chrono::steady_clock::now();
      for (std::uint32_t number = 1; !stop.stop_requested(); ++number) {
        server_->show((is_small ? small : pattern).draw(number),
                      {std::chrono::steady_clock::now(), Json{{"number", number}}.dump()});
        std::this_thread::sleep_until(next += milliseconds(33));
      }
    });
  }

  LiveServer& server() { return *server_; }
  std::atomic<bool> is_small = false;  ///< What is shown from now on.

  /// Waits until so many pictures are in the video, or it has ended by itself.
  VideoStatus wait_for(std::uint64_t num_pictures) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    VideoStatus status = server_->video();
    while (status.num_pictures < num_pictures && status.problem.empty() &&
           std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(milliseconds(10));
      status = server_->video();
    }
    return status;
  }

 private:
  std::unique_ptr<LiveServer> server_;
  std::jthread thread_;
};

class VideoRecorderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder());
    fs::create_directories(folder());
  }

  /// Runs a test of this program in a process of its own.
  static pid_t spawn(const char* filter) {
    const pid_t child = fork();
    if (child != 0) return child;
    const std::string argument = std::string("--gtest_filter=") + filter;
    execl("/proc/self/exe",
          "video_recorder_test",
          argument.c_str(),
          "--gtest_also_run_disabled_tests",
          nullptr);
    _exit(127);
  }
};

TEST_F(VideoRecorderTest, IsAVp8VideoWithTheRightLengthAndItsPosesPictureByPicture) {
  Show show;
  std::this_thread::sleep_for(milliseconds(300));  // The first picture recorded is not the first.
  ASSERT_TRUE(show.server().start_video(files()));
  EXPECT_THAT(show.server().start_video(files()).error().message, HasSubstr("already"));
  ASSERT_GE(show.wait_for(90).num_pictures, 90U);
  const VideoStatus status = show.server().stop_video();
  EXPECT_EQ(status.problem, "");
  EXPECT_EQ(status.width_px, kWidth);

  const Json video = probe(files().video);
  const Json& stream = video["streams"][0];
  EXPECT_EQ(stream["codec_name"], "vp8");
  EXPECT_EQ(stream["width"], kWidth);
  EXPECT_EQ(stream["height"], kHeight);
  EXPECT_EQ(stream["nb_read_frames"], std::to_string(status.num_pictures));
  EXPECT_THAT(video["format"]["format_name"].get<std::string>(), HasSubstr("webm"));
  EXPECT_NEAR(std::stod(video["format"]["duration"].get<std::string>()), status.seconds, 0.1);
  EXPECT_EQ(video["frames"][0]["key_frame"], 1) << "it begins with a key picture";

  const auto lines = lines_of(files().pictures);
  const auto numbers = numbers_in(files().video);
  ASSERT_EQ(lines.size(), status.num_pictures);
  ASSERT_EQ(numbers.size(), lines.size());
  EXPECT_GT(numbers.front(), 3U);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    ASSERT_EQ(lines[i]["picture"], i);
    ASSERT_EQ(lines[i]["number"], numbers[i]) << "line " << i << " belongs to another picture";
    const double shown_at = std::stod(video["frames"][i]["pts_time"].get<std::string>());
    ASSERT_NEAR(lines[i]["time_s"].get<double>(), shown_at, 0.0011);
  }
  EXPECT_THAT(lines[0]["captured_at"].get<std::string>(),
              ::testing::MatchesRegex("2...-..-..T..:..:..\\....Z"));
}

TEST_F(VideoRecorderTest, MakesOneVideoAfterAnother) {
  Show show;
  for (const char* const name : {"a", "b"}) {
    const VideoFiles pair{folder() / (std::string(name) + ".webm"),
                          folder() / (std::string(name) + ".jsonl")};
    ASSERT_TRUE(show.server().start_video(pair));
    ASSERT_GE(show.wait_for(15).num_pictures, 15U);
    show.server().stop_video();
    EXPECT_EQ(numbers_in(pair.video).size(), lines_of(pair.pictures).size());
  }
  EXPECT_THAT(
      show.server().start_video({folder() / "a.webm", folder() / "c.jsonl"}).error().message,
      HasSubstr("a.webm"))
      << "no video is written over";
  EXPECT_FALSE(fs::exists(folder() / "c.jsonl"));
  EXPECT_THAT(show.server().start_video({"/no/such/a.webm", "/no/such/a.jsonl"}).error().message,
              HasSubstr("/no/such/a.jsonl"));
}

/// What a test below runs as a program of its own, to be killed.
TEST(Child, DISABLED_Records) {
  Show show;
  ASSERT_TRUE(show.server().start_video(files()));
  show.wait_for(100000);
}

TEST_F(VideoRecorderTest, AKilledProgramLeavesAVideoThatPlaysAndCanBeRepaired) {
  const pid_t child = spawn("Child.DISABLED_Records");
  const auto num_lines = [] { return lines_of(files().pictures).size(); };
  for (int i = 0; i < 3000 && num_lines() < 60; ++i) std::this_thread::sleep_for(milliseconds(20));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  const auto lines = lines_of(files().pictures);
  ASSERT_GE(lines.size(), 60U);

  const auto as_left = numbers_in(files().video);
  ASSERT_GE(as_left.size() + 5, lines.size()) << "the last moments are missing";
  const fs::path whole = folder() / "whole.webm";
  const auto repaired = repair_video(files().video, whole);
  ASSERT_TRUE(repaired) << repaired.error().message;
  const auto numbers = numbers_in(whole);
  EXPECT_EQ(numbers.size(), *repaired);
  ASSERT_GE(numbers.size() + 5, lines.size());
  for (std::size_t i = 0; i < std::min(numbers.size(), lines.size()); ++i)
    ASSERT_EQ(lines[i]["number"], numbers[i]);
  const double seconds = std::stod(probe(whole)["format"]["duration"].get<std::string>());
  EXPECT_NEAR(seconds, lines.back()["time_s"].get<double>(), 0.3);
}

TEST(Child, DISABLED_HasNoRoom) {
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{100'000, 100'000};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  Show show;
  ASSERT_TRUE(show.server().start_video(files()));
  const VideoStatus status = show.wait_for(100000);
  EXPECT_THAT(status.problem, HasSubstr("the video cannot be written any further"));
  EXPECT_FALSE(status.is_running);
  const auto before = show.server().stats().num_encoded;
  std::this_thread::sleep_for(milliseconds(500));
  EXPECT_GT(show.server().stats().num_encoded, before + 3) << "the stream goes on";
  show.server().stop_video();
}

TEST_F(VideoRecorderTest, AFileThatCannotGrowEndsTheVideoAndNotTheStream) {
  const pid_t child = spawn("Child.DISABLED_HasNoRoom");
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_GT(numbers_in(files().video).size(), 3U) << "what was written plays";
}

TEST_F(VideoRecorderTest, APictureOfAnotherSizeEndsTheVideoAndLosesNothing) {
  Show show;
  ASSERT_TRUE(show.server().start_video(files()));
  show.wait_for(15);
  show.is_small = true;
  EXPECT_THAT(show.wait_for(100000).problem, HasSubstr("size has changed"));
  const VideoStatus status = show.server().stop_video();
  EXPECT_EQ(numbers_in(files().video).size(), status.num_pictures);
  EXPECT_EQ(lines_of(files().pictures).size(), status.num_pictures);
  EXPECT_NEAR(
      std::stod(probe(files().video)["format"]["duration"].get<std::string>()), status.seconds, 0.1)
      << "it was ended properly";
}

TEST_F(VideoRecorderTest, RefusesToRepairWhatIsNoVideo) {
  std::ofstream(folder() / "no.webm") << "this is no video at all";
  const auto refused = repair_video(folder() / "no.webm", folder() / "out.webm");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("no.webm: the video cannot be repaired"));
  EXPECT_FALSE(fs::exists(folder() / "out.webm"));
  EXPECT_FALSE(repair_video(folder() / "missing.webm", folder() / "out.webm"));
}

}  // namespace
}  // namespace mor
