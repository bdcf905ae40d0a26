// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The fused texture from tracked frames to the case's folder and back.
#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>
#include <map>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "morgagni/camera/simulated_camera.h"
#include "morgagni/casefile/testing/synthetic_case.h"
#include "morgagni/core/files.h"
#include "morgagni/documentation/skin_texture_io.h"
#include "morgagni/session/routes/texture_routes.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using ::testing::HasSubstr;

std::shared_ptr<const Case> synthetic_case() {
  return testing_case::synthetic_case("texture_test");
}

bool eventually(const std::function<bool()>& holds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (std::chrono::steady_clock::now() < end) {
    if (holds()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

class TextureTest : public testing::Test {
 protected:
  void SetUp() override {
    body_ = synthetic_case();
    fs::remove_all(body_->folder / "texture");
    camera_ = SimulatedCamera::create(
                  std::shared_ptr<const TriangleMesh>(body_->skin, &body_->skin->mesh),
                  SimulatedCameraOptions::parse("path=orbit,fps=2").value())
                  .value();
    begin();
  }

  void begin() {
    recorder_ = std::make_shared<TextureRecorder>(body_);
    routes_.clear();
    for (auto& route : make_texture_routes(recorder_)) {
      routes_[route.method + " " + route.path] = route.handler;
    }
    ASSERT_TRUE(eventually(
        [this] { return recorder_->status().is_ready || !recorder_->status().problem.empty(); }));
  }

  HttpResponse ask(const std::string& what, const std::string& body = {}) {
    return routes_.at(what)({what.substr(what.find(' ') + 1), {}, body});
  }
  Json status() { return Json::parse(ask("GET /api/texture").body); }

  /// A frame as the tracker would hand it on, at the true pose.
  TrackedFrame tracked(std::uint64_t id) const {
    TrackedFrame result;
    auto frame = std::make_shared<RgbdFrame>(*camera_->frame_at(id));
    frame->captured_at = std::chrono::steady_clock::now();
    result.frame = frame;
    result.state = TrackingState::kTracking;
    result.ct_from_depth = camera_->ct_from_camera(id);
    result.covariance = PoseCovariance{};
    result.covariance->pivot_mm = body_->skin->mesh.bounds().center().cast<double>();
    result.covariance->matrix.diagonal() << 1e-6, 1e-6, 1e-6, 0.04, 0.04, 0.04;
    return result;
  }

  void record_some() {
    ASSERT_EQ(ask("POST /api/texture/record", R"({"recording": true})").status, 200);
    ASSERT_TRUE(eventually([this] {
      recorder_->look(tracked(next_++ % 20));
      return recorder_->status().num_frames >= 2;
    }));
    ASSERT_EQ(ask("POST /api/texture/record", R"({"recording": false})").status, 200);
  }

  bool save_and_wait() {
    if (ask("POST /api/texture/save").status != 200) return false;
    return eventually([this] { return !recorder_->status().is_saving; });
  }

  std::shared_ptr<const Case> body_;
  std::unique_ptr<SimulatedCamera> camera_;
  std::shared_ptr<TextureRecorder> recorder_;
  std::map<std::string, std::function<HttpResponse(const HttpRequest&)>> routes_;
  std::uint64_t next_ = 0;
};

TEST_F(TextureTest, RecordsSavesAndIsThereWhenTheCaseIsOpenedAgain) {
  EXPECT_EQ(status()["coverage"], 0.0);
  EXPECT_EQ(ask("POST /api/texture/save").status, 400) << "there is nothing to save";
  record_some();
  EXPECT_GT(status()["coverage"].get<double>(), 0.05);
  EXPECT_EQ(ask("GET /api/texture/sides.png").content_type, "image/png");
  EXPECT_EQ(ask("GET /api/texture/color.png").content_type, "image/png");
  ASSERT_TRUE(save_and_wait());
  EXPECT_TRUE(status()["saved"].get<bool>()) << status();
  const double coverage = status()["coverage"];
  begin();
  EXPECT_TRUE(status()["saved"].get<bool>());
  EXPECT_NEAR(status()["coverage"].get<double>(), coverage, 1e-9);
  EXPECT_GE(status()["frames"].get<int>(), 2);
}

TEST_F(TextureTest, PassesOverFramesThatAreNotTrackedOrNotAskedFor) {
  recorder_->look(tracked(0));  // Not recording.
  ASSERT_EQ(ask("POST /api/texture/record", R"({"recording": true})").status, 200);
  auto lost = tracked(1);
  lost.state = TrackingState::kLost;
  lost.ct_from_depth.reset();
  auto held = tracked(2);
  held.is_held = true;
  recorder_->look(lost);
  recorder_->look(held);
  recorder_->look({});
  // A good one after a loss is taken, so those before have been passed over by then.
  ASSERT_TRUE(eventually([this] {
    recorder_->look(tracked(3));
    return recorder_->status().num_frames >= 1;
  }));
  for (const auto& frame : recorder_->texture()->frames) EXPECT_EQ(frame.frame_id, 3U);
}

TEST_F(TextureTest, StartsAgainButTheCaseKeepsWhatItHas) {
  record_some();
  ASSERT_TRUE(save_and_wait());
  ASSERT_EQ(ask("POST /api/texture/clear").status, 200);
  ASSERT_TRUE(eventually([this] { return recorder_->status().num_frames == 0; }));
  EXPECT_EQ(status()["coverage"], 0.0);
  EXPECT_TRUE(read_skin_texture(body_->folder / "texture").has_value());
}

TEST_F(TextureTest, WhatIsSavedAndThenBegunAgainIsSaved) {
  record_some();
  ASSERT_EQ(ask("POST /api/texture/save").status, 200);
  ASSERT_EQ(ask("POST /api/texture/clear").status, 200);
  ASSERT_TRUE(eventually(
      [this] { return recorder_->status().num_frames == 0 && !recorder_->status().is_saving; }));
  const auto kept = read_skin_texture(body_->folder / "texture");
  ASSERT_TRUE(kept);
  EXPECT_FALSE(kept->frames.empty());
}

TEST_F(TextureTest, OnAFullDiskItSaysSoAndTheOldOneStays) {
  record_some();
  ASSERT_TRUE(save_and_wait());
  const auto before = read_text_file(body_->folder / "texture" / "texture.json", 1U << 20U).value();
  record_some();
  // A limit on the size of files fails a write as a full disk does, once SIGXFSZ is ignored.
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit few_bytes{100, limit.rlim_max};
  setrlimit(RLIMIT_FSIZE, &few_bytes);
  const bool has_ended = save_and_wait();
  setrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, SIG_DFL);
  ASSERT_TRUE(has_ended);
  EXPECT_FALSE(status()["saved"].get<bool>());
  EXPECT_THAT(status()["problem"].get<std::string>(), HasSubstr("cannot be saved"));
  EXPECT_EQ(read_text_file(body_->folder / "texture" / "texture.json", 1U << 20U).value(), before);
}

TEST_F(TextureTest, ADamagedTextureIsNamedAndRecordingGoesOn) {
  record_some();
  ASSERT_TRUE(save_and_wait());
  ASSERT_TRUE(write_file(body_->folder / "texture" / "color.png", std::string("no picture")));
  begin();
  ASSERT_TRUE(eventually([this] { return recorder_->status().is_ready; }));
  EXPECT_THAT(status()["problem"].get<std::string>(), HasSubstr("color.png is not the file"));
  EXPECT_EQ(status()["frames"], 0);
  record_some();
}

TEST_F(TextureTest, RefusesARequestThatSaysNothing) {
  const auto response = ask("POST /api/texture/record", "{}");
  EXPECT_EQ(response.status, 400);
  EXPECT_THAT(response.body, HasSubstr("recording"));
}

}  // namespace
}  // namespace mor
