// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/recorder.h"

#include <chrono>
#include <fstream>
#include <functional>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "morgagni/core/files.h"
#include "morgagni/stream/testing/test_pattern.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using std::chrono::milliseconds;
using ::testing::HasSubstr;

class RecorderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(place_);
    fs::create_directories(place_ / "page");
    std::ofstream(place_ / "page" / "index.html") << "<p>page</p>";
    auto body = std::make_shared<Case>();
    body->name = "case";
    body->folder = place_ / "case";
    body->ct_voxels_sha256 = "abc";
    fs::create_directories(body->folder);
    body_ = body;
    server_ = LiveServer::start({.port = 0, .web_root = place_ / "page"}, {}).value();
    pictures_ = std::jthread([this](std::stop_token stop) {
      testing::TestPattern pattern(400, 300);
      for (std::uint32_t number = 1; !stop.stop_requested(); ++number) {
        server_->show(pattern.draw(number),
                      {std::chrono::steady_clock::now(), Json{{"number", number}}.dump()});
        std::this_thread::sleep_for(milliseconds(30));
      }
    });
    recorder_ = made();
    recorder_->run(*server_);
  }

  void TearDown() override {
    recorder_->close();
    pictures_ = {};
  }

  std::unique_ptr<Recorder> made() const {
    return std::make_unique<Recorder>(
        body_,
        [] { return std::make_shared<const RgbdCalibration>(); },
        [] { return std::shared_ptr<const FixedSurface>(); },
        "simulated:");
  }

  static bool eventually(const std::function<bool()>& holds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (std::chrono::steady_clock::now() < end) {
      if (holds()) return true;
      std::this_thread::sleep_for(milliseconds(20));
    }
    return false;
  }

  bool has_recorded(std::uint64_t num_pictures) const {
    return eventually([&] { return recorder_->status().video.num_pictures >= num_pictures; });
  }
  bool is_idle() const {
    return eventually([&] { return recorder_->status().state == RecorderState::kIdle; });
  }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(body_->folder / "videos"))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }

  const fs::path place_ = fs::path(::testing::TempDir()) / "recorder_test";
  std::shared_ptr<const Case> body_;
  std::unique_ptr<LiveServer> server_;
  std::jthread pictures_;
  std::unique_ptr<Recorder> recorder_;
};

TEST_F(RecorderTest, LeavesAVideoItsPosesAndWhatProvesThem) {
  EXPECT_THAT(recorder_->stop().error().message, HasSubstr("no video is being recorded"));
  ASSERT_TRUE(recorder_->start());
  EXPECT_THAT(recorder_->start().error().message, HasSubstr("already"));
  ASSERT_TRUE(has_recorded(20));
  EXPECT_GT(recorder_->status().video.num_bytes, 1000U);
  ASSERT_TRUE(recorder_->stop());
  ASSERT_TRUE(is_idle());
  const auto status = recorder_->status();
  EXPECT_FALSE(status.last_failed);
  EXPECT_THAT(status.last_said, HasSubstr("Saved " + status.name + ".webm"));
  EXPECT_THAT(
      files(),
      ::testing::ElementsAre(status.name + ".json", status.name + ".jsonl", status.name + ".webm"));
  const fs::path base = body_->folder / "videos" / status.name;
  const Json json = Json::parse(read_text_file(base.string() + ".json", 1U << 20U).value());
  EXPECT_EQ(json["sha256"][status.name + ".webm"],
            sha256_hex_of_file(base.string() + ".webm").value());
  EXPECT_EQ(json["sha256"][status.name + ".jsonl"],
            sha256_hex_of_file(base.string() + ".jsonl").value());
  EXPECT_EQ(json["case"], "case");
  EXPECT_EQ(json["ct_voxels_sha256"], "abc");
  EXPECT_EQ(json["ended"], "by the user");
  EXPECT_EQ(json["notice"], "Not a medical device");
  EXPECT_GE(json["num_pictures"], 20);
}

TEST_F(RecorderTest, FinishesAVideoThatTheProgramsEndCutsShort) {
  ASSERT_TRUE(recorder_->start());
  ASSERT_TRUE(has_recorded(10));
  recorder_->close();
  EXPECT_EQ(files().size(), 3U);
  EXPECT_THAT(files()[2], ::testing::EndsWith("Z.webm"));
}

TEST_F(RecorderTest, RepairsAtTheNextStartWhatAKilledProgramLeft) {
  ASSERT_TRUE(recorder_->start());
  ASSERT_TRUE(has_recorded(20));
  // As a kill leaves it: the files of this moment.
  const fs::path videos = body_->folder / "videos";
  const std::string name = recorder_->status().name;
  const fs::path kept = place_ / "kept";
  fs::copy(videos, kept, fs::copy_options::recursive);
  recorder_->close();
  recorder_.reset();
  fs::remove_all(videos);
  fs::rename(kept, videos);
  std::ofstream(videos / (name + ".part.jsonl"), std::ios::app) << R"({"half a li)";

  recorder_ = made();
  recorder_->run(*server_);
  ASSERT_TRUE(eventually([&] { return !recorder_->status().last_said.empty(); }));
  EXPECT_THAT(recorder_->status().last_said, HasSubstr("left unfinished; it is repaired"));
  EXPECT_THAT(files(), ::testing::ElementsAre(name + ".json", name + ".jsonl", name + ".webm"));
  const Json json = Json::parse(read_text_file(videos / (name + ".json"), 1U << 20U).value());
  EXPECT_THAT(json["ended"].get<std::string>(), HasSubstr("repaired"));
  const std::string lines = read_text_file(videos / (name + ".jsonl"), 1U << 26U).value();
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), json["num_pictures"]);
  EXPECT_EQ(lines.back(), '\n');
}

TEST_F(RecorderTest, LeavesNothingWhereNoPictureCame) {
  pictures_ = {};  // The camera is silent.
  std::this_thread::sleep_for(milliseconds(100));
  server_ = LiveServer::start({.port = 0, .web_root = place_ / "page"}, {}).value();
  recorder_ = made();
  recorder_->run(*server_);
  ASSERT_TRUE(recorder_->start());
  ASSERT_TRUE(recorder_->stop());
  ASSERT_TRUE(is_idle());
  EXPECT_TRUE(recorder_->status().last_failed);
  EXPECT_THAT(recorder_->status().last_said, HasSubstr("no picture came"));
  EXPECT_TRUE(files().empty());
}

TEST_F(RecorderTest, SaysWhyNoVideoCanBeMade) {
  std::ofstream(body_->folder / "videos") << "a file where the folder should be";
  const auto refused = recorder_->start();
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("videos"));
  fs::remove(body_->folder / "videos");
  ASSERT_TRUE(recorder_->start());
  ASSERT_TRUE(has_recorded(3));
  const auto second = made();
  second->run(*server_);
  EXPECT_THAT(second->start().error().message, HasSubstr("another Morgagni records"));
  second->close();
  EXPECT_TRUE(eventually([&] { return recorder_->status().video.num_pictures > 10; }))
      << "the first one goes on";
}

}  // namespace
}  // namespace mor
