// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/live_loop.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "morgagni/casefile/testing/synthetic_case.h"
#include "morgagni/session/routes/live_api.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using std::chrono::seconds;
using testing::HasSubstr;

std::shared_ptr<const Case> synthetic_case() {
  return testing_case::synthetic_case("live_loop_test");
}

/// Gives what it is told, to see what the loop makes of it.
class ToldCamera final : public RangeCamera {
 public:
  using Frame = Result<std::shared_ptr<const RgbdFrame>>;
  explicit ToldCamera(std::function<Frame(std::stop_token)> tell) : tell_(std::move(tell)) {}
  Frame next_frame(std::stop_token stop) override { return tell_(stop); }
  const RgbdCalibration& calibration() const override { return calibration_; }

 private:
  std::function<Frame(std::stop_token)> tell_;
  RgbdCalibration calibration_{
      {160, 120, 130.0, 130.0, 79.5, 59.5, {}}, {160, 120, 130.0, 130.0, 79.5, 59.5, {}}, {}};
};

class LiveLoopTest : public testing::Test {
 protected:
  void start(std::unique_ptr<RangeCamera> camera, const LiveLoopOptions& options = {}) {
    auto made = LiveLoop::create(synthetic_case(), std::move(camera), options);
    ASSERT_TRUE(made) << made.error().message;
    loop_ = *std::move(made);
    for (auto& route : make_live_routes(synthetic_case(), loop_, {})) {
      routes_[route.method + " " + route.path] = route.handler;
    }
    const auto running =
        loop_->run([this](ImageView<const Rgba8> picture, const PictureInfo& info) {
          const std::lock_guard lock(mutex_);
          ++num_pictures_;
          last_info_ = Json::parse(info.json);
          last_age_ = std::chrono::steady_clock::now() - info.captured_at;
          last_width_ = picture.width();
        });
    ASSERT_TRUE(running) << running.error().message;
  }

  /// The body is an egg: no search could tell its poses apart, so it is placed.
  void start_simulated() {
    LiveLoopOptions options;
    options.start = StartMethod::kPlacement;
    start_simulated("simulated:", options);
  }

  void start_simulated(const std::string& name, const LiveLoopOptions& options) {
    const auto body = synthetic_case();
    auto camera =
        open_camera(name, std::shared_ptr<const TriangleMesh>(body->skin, &body->skin->mesh));
    ASSERT_TRUE(camera) << camera.error().message;
    start(*std::move(camera), options);
  }

  void TearDown() override {
    if (loop_) loop_->stop();
  }

  /// Waits, generously: a loaded machine is no failure.
  bool eventually(const std::function<bool()>& holds) const {
    const auto end = std::chrono::steady_clock::now() + seconds(20);
    while (std::chrono::steady_clock::now() < end) {
      if (holds()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }

  bool tracks() const {
    return eventually([this] { return loop_->status().last.state == TrackingState::kTracking; });
  }

  HttpResponse ask(const std::string& what,
                   const std::string& body = {},
                   std::map<std::string, std::string> query = {}) {
    const auto route = routes_.find(what);
    if (route == routes_.end()) return {404, "", what};
    return route->second({what.substr(what.find(' ') + 1), std::move(query), body});
  }

  std::shared_ptr<LiveLoop> loop_;
  std::map<std::string, HttpHandler> routes_;
  mutable std::mutex mutex_;
  int num_pictures_ = 0;
  int last_width_ = 0;
  Json last_info_;
  std::chrono::duration<double> last_age_{};
};

TEST_F(LiveLoopTest, CatchesThePlacedBodyAndShowsIt) {
  start_simulated();
  ASSERT_TRUE(tracks());
  EXPECT_TRUE(eventually([this] {
    const std::lock_guard lock(mutex_);
    return num_pictures_ > 10 && last_info_["state"] == "tracking" && last_width_ == 640;
  }));
  const auto snapshot = loop_->snapshot();
  ASSERT_TRUE(snapshot);
  EXPECT_EQ(snapshot->pixels.width(), 640);
  ASSERT_TRUE(snapshot->shown.camera_from_ct);
  const auto& info = snapshot->shown;
  const auto said = Json::parse(picture_json(info, R"([{"id": "F1"}])"));
  EXPECT_EQ(said["marks"][0]["id"], "F1");
  ASSERT_EQ(said["ct_from_camera"].size(), 12U);
  const Eigen::Vector3d place = (info.camera_from_ct->inverse()).translation();
  EXPECT_EQ(said["ct_from_camera"][3], place.x());
  EXPECT_EQ(said["ct_from_camera"][11], place.z());
  EXPECT_NEAR(said["bound_mm"].get<double>(), 2.0, 2.0);
}

TEST_F(LiveLoopTest, TheFreeViewTurnsGoesOnAndComesBack) {
  start_simulated();
  ASSERT_TRUE(tracks());
  const auto shows = [this](const std::string& picture) {
    return eventually([&] {
      const std::lock_guard lock(mutex_);
      return last_info_["picture"] == picture;
    });
  };
  ASSERT_TRUE(shows("camera"));
  ASSERT_EQ(ask("POST /api/view", R"({"picture": "free"})").status, 200);
  ASSERT_TRUE(shows("free"));
  EXPECT_EQ(last_width_, 640) << "the stream's size stays";
  EXPECT_LT(loop_->status().colors_age_ms.value(), 5000.0);

  // Frozen, only the virtual camera moves.
  EXPECT_EQ(ask("POST /api/freeze", R"({"frozen": true})").status, 200);
  ASSERT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex_);
    return last_info_["frozen"] == true && last_info_["picture"] == "free";
  }));
  const auto before = loop_->snapshot()->pixels;
  EXPECT_EQ(ask("POST /api/view", R"({"free_yaw": 1.0})").status, 200);
  EXPECT_TRUE(eventually([&] { return loop_->snapshot()->pixels != before; }));
  EXPECT_EQ(ask("POST /api/view", R"({"free_yaw": 0.0})").status, 200);
  EXPECT_TRUE(eventually([&] { return loop_->snapshot()->pixels == before; })) << "another picture";

  ASSERT_EQ(ask("POST /api/view", R"({"picture": "camera"})").status, 200);
  EXPECT_TRUE(shows("camera"));
}

TEST_F(LiveLoopTest, ATouchOnTheFreeViewIsThePointSeenThere) {
  start_simulated();
  ASSERT_TRUE(tracks());
  ASSERT_EQ(ask("POST /api/view", R"({"picture": "free", "free_bare_skin": true})").status, 200);
  ASSERT_TRUE(eventually([this] {
    const std::lock_guard lock(mutex_);
    return last_info_["picture"] == "free";
  }));
  const auto answer = ask("POST /api/touch", R"({"x": 319.5, "y": 239.5})");
  ASSERT_EQ(answer.status, 200) << answer.body;
  const auto ct = Json::parse(answer.body)["ct_mm"].get<std::vector<double>>();
  // From the front: on the skin, before the body's middle.
  const auto bounds = synthetic_case()->skin->mesh.bounds();
  EXPECT_LT(ct.at(1), bounds.center().y());
  FieldSample sample;
  const Eigen::Vector3d point(ct.at(0), ct.at(1), ct.at(2));
  ASSERT_TRUE(
      DistanceField::look_up(synthetic_case()->skin->field.fine(), point.cast<float>(), sample));
  EXPECT_LT(std::abs(sample.distance_mm), 2.0F);
  const auto beside = ask("POST /api/touch", R"({"x": 2, "y": 2})");
  EXPECT_EQ(beside.status, 400);
  EXPECT_THAT(beside.body, HasSubstr("there is no body at this point"));
}

TEST_F(LiveLoopTest, TheFreeViewKeepsTheLastGoodColorsWhenTheBodyIsGone) {
  // The body is seen, then the camera looks at nothing.
  const auto body = synthetic_case();
  auto simulated = open_camera("simulated:path=still",
                               std::shared_ptr<const TriangleMesh>(body->skin, &body->skin->mesh));
  ASSERT_TRUE(simulated) << simulated.error().message;
  auto is_gone = std::make_shared<std::atomic<bool>>(false);
  auto source = std::shared_ptr<RangeCamera>(*std::move(simulated));
  class Blinded final : public RangeCamera {
   public:
    Blinded(std::shared_ptr<RangeCamera> camera, std::shared_ptr<std::atomic<bool>> is_gone)
        : camera_(std::move(camera)), is_gone_(std::move(is_gone)) {}
    Result<std::shared_ptr<const RgbdFrame>> next_frame(std::stop_token stop) override {
      auto frame = camera_->next_frame(stop);
      if (!frame || !*frame || !*is_gone_) return frame;
      auto blind = std::make_shared<RgbdFrame>(**frame);
      blind->depth_mm = Image<std::uint16_t>(blind->depth_mm.width(), blind->depth_mm.height(), 0);
      blind->color = Image<Rgb8>(blind->color.width(), blind->color.height(), Rgb8{0, 255, 0});
      return std::shared_ptr<const RgbdFrame>(std::move(blind));
    }
    const RgbdCalibration& calibration() const override { return camera_->calibration(); }

   private:
    std::shared_ptr<RangeCamera> camera_;
    std::shared_ptr<std::atomic<bool>> is_gone_;
  };
  start(std::make_unique<Blinded>(source, is_gone), {.start = StartMethod::kPlacement});
  ASSERT_TRUE(tracks());
  ASSERT_EQ(ask("POST /api/view", R"({"picture": "free"})").status, 200);
  *is_gone = true;
  ASSERT_TRUE(eventually([this] {
    const std::lock_guard lock(mutex_);
    return last_info_["state"] == "lost" && last_info_["picture"] == "free";
  }));
  const auto picture = loop_->snapshot()->pixels;
  int num_skin = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const Rgba8& pixel = picture(x, y);
      num_skin += pixel.r > 60 && pixel.r > pixel.b ? 1 : 0;
      ASSERT_FALSE(pixel.g > 200 && pixel.r < 50) << "colours of a picture without the body";
    }
  }
  EXPECT_GT(num_skin, 1000);
  EXPECT_GT(loop_->status().colors_age_ms.value(), 300.0);
}

TEST_F(LiveLoopTest, ObserversGetEachTrackedFrameInOrderAlsoWhileThePictureIsFrozen) {
  start_simulated();
  ASSERT_TRUE(tracks());
  std::mutex mutex;
  std::vector<std::uint64_t> seen;
  int num_with_pose = 0;
  loop_->observe([&](const TrackedFrame& tracked) {
    const std::lock_guard lock(mutex);
    seen.push_back(tracked.frame->frame_id);
    num_with_pose += tracked.ct_from_depth ? 1 : 0;
  });
  EXPECT_EQ(ask("POST /api/freeze", R"({"frozen": true})").status, 200);
  EXPECT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return num_with_pose > 5;
  }));
  loop_->stop();
  EXPECT_TRUE(std::adjacent_find(seen.begin(), seen.end(), std::greater_equal<>()) == seen.end())
      << "a frame came twice or late";
}

TEST_F(LiveLoopTest, AFrozenPictureStaysAndTheViewStillChanges) {
  start_simulated();
  ASSERT_TRUE(tracks());
  EXPECT_EQ(ask("POST /api/freeze", R"({"frozen": true})").status, 200);
  ASSERT_TRUE(eventually([this] {
    const std::lock_guard lock(mutex_);
    return last_info_["frozen"] == true;
  }));
  const auto before = loop_->snapshot()->pixels;
  EXPECT_EQ(ask("POST /api/view", R"({"opacity": 0})").status, 200);
  EXPECT_TRUE(eventually([&] { return loop_->snapshot()->pixels != before; }));
  const auto without_bone = loop_->snapshot()->pixels;
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(loop_->snapshot()->pixels, without_bone) << "the frozen picture moved";
}

TEST_F(LiveLoopTest, LandmarksTappedOnBothViewsStartTheTracking) {
  start_simulated();
  ASSERT_TRUE(tracks());
  ASSERT_EQ(ask("POST /api/landmarks/begin").status, 200);
  // Taps the live picture, and on the CT the same anatomy: where the pose found by placement has
  // it.
  const auto status = loop_->status();
  Json pairs = Json::array();
  for (const auto& [x, y] :
       {std::pair{320, 240}, std::pair{290, 220}, std::pair{345, 265}, std::pair{335, 215}}) {
    const auto live = ask("POST /api/landmarks/live", Json{{"x", x}, {"y", y}}.dump());
    ASSERT_EQ(live.status, 200) << live.body;
    const auto depth = Json::parse(live.body)["depth_mm"].get<std::vector<double>>();
    const Eigen::Vector3d ct =
        *status.last.ct_from_depth * Eigen::Vector3d(depth[0], depth[1], depth[2]);
    pairs.push_back({{"ct_mm", {ct.x(), ct.y(), ct.z()}}, {"depth_mm", depth}});
  }
  const std::string body = Json{{"pairs", pairs}}.dump();
  const auto solved = Json::parse(ask("POST /api/landmarks/solve", body).body);
  EXPECT_LT(solved["fre_mm"].get<double>(), 20.0);
  EXPECT_EQ(solved["residuals_mm"].size(), 4U);
  const auto accepted = ask("POST /api/landmarks/accept", body);
  EXPECT_EQ(accepted.status, 200) << accepted.body;
  EXPECT_FALSE(loop_->status().picking_landmarks);
  EXPECT_TRUE(tracks());
}

TEST_F(LiveLoopTest, ATouchSaysWhichCtPointItIsAndHowSure) {
  start_simulated();
  ASSERT_TRUE(tracks());
  const auto touched = Json::parse(ask("POST /api/touch", R"({"x": 320, "y": 240})").body);
  const auto ct = touched["ct_mm"].get<std::vector<double>>();
  FieldSample sample;
  const Eigen::Vector3d point(ct.at(0), ct.at(1), ct.at(2));
  ASSERT_TRUE(
      DistanceField::look_up(synthetic_case()->skin->field.fine(), point.cast<float>(), sample));
  EXPECT_LT(std::abs(sample.distance_mm), 10.0F) << "not on the skin";
  EXPECT_GT(touched["bound_mm"].get<double>(), 0.0);
  EXPECT_EQ(ask("POST /api/touch", R"({"x": "left"})").status, 400);
  EXPECT_TRUE(eventually([this] { return loop_->status().bound_mm.has_value(); }));
}

TEST_F(LiveLoopTest, FollowsABodyBeyondOneMetre) {
  LiveLoopOptions options;
  options.start = StartMethod::kPlacement;
  options.placement.distance_mm = 1200.0;
  start_simulated("simulated:path=still,distance=1200", options);
  EXPECT_TRUE(tracks());
}

TEST_F(LiveLoopTest, SearchesForTheBodyAndSaysWhyItFindsNone) {
  const auto calibration = std::make_shared<const RgbdCalibration>(RgbdCalibration{
      {160, 120, 130.0, 130.0, 79.5, 59.5, {}}, {160, 120, 130.0, 130.0, 79.5, 59.5, {}}, {}});
  start(std::make_unique<ToldCamera>([calibration, id = 0U](std::stop_token) mutable {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    auto frame = std::make_shared<RgbdFrame>();
    frame->frame_id = id++;
    frame->captured_at = std::chrono::steady_clock::now();
    frame->calibration = calibration;
    frame->color = Image<Rgb8>(160, 120);
    frame->depth_mm = Image<std::uint16_t>(160, 120);
    std::fill_n(frame->depth_mm.data(), frame->depth_mm.size(), std::uint16_t{500});
    return ToldCamera::Frame(std::move(frame));  // A wall.
  }));
  EXPECT_TRUE(eventually([this] {
    const auto search = loop_->status().search;
    return search.last == AutomaticStartStatus::kNotFound && !search.reason.empty();
  }));
  EXPECT_TRUE(eventually([this] {
    const std::lock_guard lock(mutex_);
    return num_pictures_ > 10;
  })) << "the live picture goes on";
}

TEST_F(LiveLoopTest, TheAutomaticStartTakesTheOutlineAway) {
  start_simulated();
  ASSERT_TRUE(tracks());
  ASSERT_EQ(ask("POST /api/start/placement", R"({"distance_mm": 2900})").status, 200);
  ASSERT_TRUE(eventually([this] { return loop_->status().last.ct_from_ghost.has_value(); }));
  ASSERT_EQ(ask("POST /api/start/automatic").status, 200);
  EXPECT_TRUE(eventually([this] { return !loop_->status().last.ct_from_ghost; }));
}

TEST_F(LiveLoopTest, InStepEveryFrameOfARecordingIsTracked) {
  std::atomic<std::uint64_t> told = 0;
  LiveLoopOptions options;
  options.in_step = true;
  const auto calibration = std::make_shared<const RgbdCalibration>(RgbdCalibration{
      {160, 120, 130.0, 130.0, 79.5, 59.5, {}}, {160, 120, 130.0, 130.0, 79.5, 59.5, {}}, {}});
  start(std::make_unique<ToldCamera>([&](std::stop_token) -> ToldCamera::Frame {
          if (told >= 50) return nullptr;
          auto frame = std::make_shared<RgbdFrame>();
          frame->frame_id = told++;
          frame->calibration = calibration;
          frame->depth_mm = Image<std::uint16_t>(160, 120, 0);
          frame->color = Image<Rgb8>(160, 120);
          return frame;
        }),
        options);
  EXPECT_TRUE(
      eventually([this] { return loop_->status().camera_error == "the recording has ended"; }));
  EXPECT_EQ(loop_->status().last.frame->frame_id, 49U);
  EXPECT_TRUE(eventually([this] {
    const std::lock_guard lock(mutex_);
    return num_pictures_ > 0;
  }));
  // The frames say that they are hours old; shown is how long they took from when they came.
  const std::lock_guard lock(mutex_);
  EXPECT_GE(last_age_.count(), 0.0);
  EXPECT_LT(last_age_.count(), 60.0);
}

TEST_F(LiveLoopTest, SaysWhatIsWrongWithARequest) {
  start_simulated();
  ASSERT_TRUE(tracks());
  const auto sentence = [this](const std::string& what, const std::string& body) {
    const auto response = ask(what, body);
    EXPECT_EQ(response.status, 400) << what;
    return Json::parse(response.body)["error"].get<std::string>();
  };
  EXPECT_THAT(sentence("POST /api/landmarks/live", R"({"x": 1, "y": 2})"), HasSubstr("begin"));
  EXPECT_THAT(sentence("POST /api/landmarks/solve", R"({"pairs": []})"), HasSubstr("at least 3"));
  EXPECT_THAT(sentence("POST /api/touch", R"({"x": -5000, "y": 2})"), HasSubstr("no depth"));
  EXPECT_THAT(sentence("POST /api/landmarks/solve", R"({"pairs": [1]})"), HasSubstr("ct_mm"));
  EXPECT_THAT(sentence("POST /api/landmarks/ct", R"({"x": 1, "y": 1, "yaw": 0, "pitch": 0})"),
              HasSubstr("no skin"));
  EXPECT_THAT(sentence("POST /api/landmarks/ct", R"({"x": 1, "y": 1, "width": 1e9})"),
              HasSubstr("width"));
  EXPECT_THAT(sentence("POST /api/start/placement", R"({"side": "top"})"), HasSubstr("anterior"));
  EXPECT_THAT(sentence("POST /api/start/placement", R"({"distance_mm": 1})"), HasSubstr("100"));
  EXPECT_THAT(sentence("POST /api/freeze", "{}"), HasSubstr("frozen"));
  EXPECT_THAT(sentence("POST /api/view", "["), HasSubstr("JSON"));
}

TEST_F(LiveLoopTest, ShowsTheSkinForTheLandmarks) {
  start_simulated();
  const auto response =
      ask("GET /api/skin-view.png", "", {{"yaw", "0.5"}, {"width", "320"}, {"height", "240"}});
  EXPECT_EQ(response.status, 200);
  EXPECT_EQ(response.content_type, "image/png");
  EXPECT_EQ(ask("GET /api/skin-view.png", "", {{"yaw", "front"}}).status, 400);
}

TEST_F(LiveLoopTest, ACameraThatFailsIsReportedAndAskedAgain) {
  std::atomic<int> asked = 0;
  start(std::make_unique<ToldCamera>([&asked](std::stop_token) -> ToldCamera::Frame {
    ++asked;
    return make_error(ErrorCode::kDevice, "unplugged");
  }));
  EXPECT_TRUE(eventually([&] { return asked > 1; }));
  EXPECT_THAT(loop_->status().camera_error.value_or(""), HasSubstr("unplugged"));
}

TEST_F(LiveLoopTest, ACameraThatChangesItsSizeIsReported) {
  start(std::make_unique<ToldCamera>([](std::stop_token) -> ToldCamera::Frame {
    auto frame = std::make_shared<RgbdFrame>();
    frame->depth_mm = Image<std::uint16_t>(40, 30, 500);
    return frame;
  }));
  EXPECT_TRUE(eventually([this] { return loop_->status().camera_error.has_value(); }));
}

TEST_F(LiveLoopTest, TheEndOfARecordingIsSaid) {
  start(std::make_unique<ToldCamera>([](std::stop_token) -> ToldCamera::Frame { return nullptr; }));
  EXPECT_TRUE(
      eventually([this] { return loop_->status().camera_error == "the recording has ended"; }));
}

TEST(StatusJson, HasEveryMemberThePageReads) {
  LiveStatus status;
  const auto json = Json::parse(
      status_json(status, {}, {}, "field", "simulated:", {.source = "found with a board"}));
  for (const char* member : {"state",
                             "held",
                             "doubts",
                             "bound_mm",
                             "colors_age_ms",
                             "search",
                             "starting",
                             "frozen",
                             "rms_distance_mm",
                             "e_valid_mm",
                             "explained_fraction",
                             "frame_rate",
                             "latency_ms",
                             "stage_ms",
                             "frames",
                             "method",
                             "camera",
                             "camera_error",
                             "calibration",
                             "viewers",
                             "view"}) {
    EXPECT_TRUE(json.contains(member)) << member;
  }
  EXPECT_EQ(json["state"], "waiting");
  EXPECT_EQ(json["starting"], "automatic");
  status.search = {.is_searching = true,
                   .last = AutomaticStartStatus::kAmbiguous,
                   .reason = "the body looks alike"};
  const auto searching = Json::parse(status_json(status, {}, {}, "field", "simulated:", {}));
  EXPECT_EQ(searching["search"]["searching"], true);
  EXPECT_EQ(searching["search"]["last"], "ambiguous");
  EXPECT_TRUE(json["rms_distance_mm"].is_null());
  EXPECT_EQ(json["calibration"],
            (Json{{"source", "found with a board"},
                  {"made_at", nullptr},
                  {"age", nullptr},
                  {"depth_corrected", false},
                  {"hint", nullptr}}));
}

}  // namespace
}  // namespace mor
