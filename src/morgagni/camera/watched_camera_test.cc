// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/watched_camera.h"

#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>

#include "morgagni/camera/testing/sample_recording.h"

namespace mor {
namespace {

using testing::HasSubstr;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

/// Ten times as fast as it is used, for tests that pull the plug often.
const WatchOptions kQuick{
    .silence = milliseconds(70), .retry = milliseconds(10), .give_up = milliseconds(200)};

enum class Behaviour { kGood, kUnplugged, kHangs, kWrongSize, kFromTheFuture, kGoesBack, kEnds };

/// A device on a desk: what it does can be changed from outside.
struct Desk {
  std::atomic<Behaviour> behaviour = Behaviour::kGood;
  std::atomic<bool> is_let_go = false;  ///< Drivers that hang return.
  std::atomic<int> num_open = 0;
  std::atomic<int> num_opened = 0;
  std::atomic<std::uint64_t> next_id = 0;
};

class FakeDevice : public RangeCamera {
 public:
  explicit FakeDevice(std::shared_ptr<Desk> desk) : desk_(std::move(desk)) {
    ++desk_->num_open;
    ++desk_->num_opened;
  }
  ~FakeDevice() override { --desk_->num_open; }

  Result<std::shared_ptr<const RgbdFrame>> next_frame(std::stop_token stop) override {
    std::this_thread::sleep_for(milliseconds(2));
    auto frame = std::make_shared<RgbdFrame>(internal::sample_frame(desk_->next_id++));
    frame->captured_at = Clock::now();
    switch (desk_->behaviour.load()) {
      case Behaviour::kGood:
        break;
      case Behaviour::kUnplugged:
        return make_error(ErrorCode::kDevice, "the plug is out");
      case Behaviour::kHangs:
        while (!desk_->is_let_go && desk_->behaviour == Behaviour::kHangs) {
          std::this_thread::sleep_for(milliseconds(1));
        }
        break;
      case Behaviour::kWrongSize:
        frame->depth_mm = Image<std::uint16_t>(3, 3);
        break;
      case Behaviour::kFromTheFuture:
        frame->captured_at += std::chrono::hours(1);
        break;
      case Behaviour::kGoesBack:
        frame->captured_at -= std::chrono::hours(1);
        break;
      case Behaviour::kEnds:
        return nullptr;
    }
    if (stop.stop_requested()) return nullptr;
    return frame;
  }
  const RgbdCalibration& calibration() const override { return *internal::sample_calibration(); }

 private:
  std::shared_ptr<Desk> desk_;
  std::ifstream file_{"/dev/null"};  ///< As a driver has its device open.
};

class WatchedCameraTest : public testing::Test {
 protected:
  ~WatchedCameraTest() override { desk_->is_let_go = true; }

  std::unique_ptr<RangeCamera> watch(const WatchOptions& options = kQuick) const {
    return watch_camera(
               [desk = desk_]() -> Result<std::unique_ptr<RangeCamera>> {
                 if (desk->behaviour == Behaviour::kUnplugged) {
                   return make_error(ErrorCode::kNotFound, "no device");
                 }
                 return std::make_unique<FakeDevice>(desk);
               },
               options)
        .value();
  }

  /// The sentence, once there is one.
  static std::string complaint(RangeCamera& camera) {
    const auto until = Clock::now() + std::chrono::seconds(20);
    while (Clock::now() < until) {
      const auto frame = camera.next_frame({});
      if (!frame) return frame.error().message;
    }
    return "no complaint";
  }
  static bool comes_back(RangeCamera& camera) {
    const auto until = Clock::now() + std::chrono::seconds(20);
    while (Clock::now() < until) {
      const auto frame = camera.next_frame({});
      if (frame && *frame) return true;
    }
    return false;
  }

  std::shared_ptr<Desk> desk_ = std::make_shared<Desk>();
};

TEST_F(WatchedCameraTest, PassesGoodFramesOn) {
  const auto camera = watch();
  EXPECT_EQ(camera->calibration(), *internal::sample_calibration());
  std::uint64_t last = 0;
  for (int i = 0; i < 20; ++i) {
    const auto frame = camera->next_frame({}).value();
    EXPECT_TRUE(i == 0 || frame->frame_id > last);
    last = frame->frame_id;
  }
  EXPECT_EQ(desk_->num_opened, 1);
}

TEST_F(WatchedCameraTest, SaysWhatIsWrongAndComesBack) {
  const std::vector<std::pair<Behaviour, std::string>> cases = {
      {Behaviour::kUnplugged, "no device"},
      {Behaviour::kWrongSize, "wrong size"},
      {Behaviour::kFromTheFuture, "ahead of ours"},
      {Behaviour::kGoesBack, "goes backward"}};
  const auto camera = watch();
  for (const auto& [behaviour, sentence] : cases) {
    ASSERT_TRUE(comes_back(*camera));
    desk_->behaviour = behaviour;
    EXPECT_THAT(complaint(*camera), HasSubstr(sentence));
    // One that sends nothing but garbage is opened anew.
    const auto opened = desk_->num_opened.load();
    while (behaviour != Behaviour::kUnplugged && desk_->num_opened == opened) {
      EXPECT_THAT(complaint(*camera), HasSubstr(sentence));
    }
    desk_->behaviour = Behaviour::kGood;
    EXPECT_TRUE(comes_back(*camera)) << sentence;
  }
}

TEST_F(WatchedCameraTest, AsUsedItSaysSoWithinASecondAndIsBackWithinThree) {
  const auto camera = watch({});
  ASSERT_TRUE(comes_back(*camera));
  const auto pulled_at = Clock::now();
  desk_->behaviour = Behaviour::kUnplugged;
  EXPECT_THAT(complaint(*camera), HasSubstr("no device"));
  EXPECT_LT(Clock::now() - pulled_at, std::chrono::seconds(1));
  const auto back_at = Clock::now();
  desk_->behaviour = Behaviour::kGood;
  ASSERT_TRUE(comes_back(*camera));
  EXPECT_LT(Clock::now() - back_at, std::chrono::seconds(3));
}

TEST_F(WatchedCameraTest, ADriverThatHangsIsLeftBehindAndTheDeviceOpenedAnew) {
  const auto camera = watch();
  ASSERT_TRUE(comes_back(*camera));
  desk_->behaviour = Behaviour::kHangs;
  EXPECT_THAT(complaint(*camera), HasSubstr("sends nothing"));
  std::string sentence;
  for (int i = 0; i < 100 && sentence.find("driver hangs") == std::string::npos; ++i) {
    sentence = complaint(*camera);
  }
  EXPECT_THAT(sentence, HasSubstr("unplug the camera"));
  for (int i = 0; i < 60; ++i) (void)complaint(*camera);
  EXPECT_LE(desk_->num_open, kQuick.max_left_behind + 1) << "bounded, however long it hangs";
  desk_->behaviour = Behaviour::kGood;
  EXPECT_TRUE(comes_back(*camera));
}

TEST_F(WatchedCameraTest, AnotherCalibrationIsNotTakenForTheSameCamera) {
  int num_opened = 0;
  const auto camera =
      watch_camera(
          [&, desk = desk_]() -> Result<std::unique_ptr<RangeCamera>> {
            if (num_opened++ > 0) {
              class Other : public FakeDevice {
               public:
                using FakeDevice::FakeDevice;
                Result<std::shared_ptr<const RgbdFrame>> next_frame(std::stop_token stop) override {
                  MOR_TRY(const auto given, FakeDevice::next_frame(stop));
                  if (!given) return nullptr;
                  auto frame = std::make_shared<RgbdFrame>(*given);
                  auto calibration = *frame->calibration;
                  calibration.depth.focal_x_px += 1.0;
                  frame->calibration = std::make_shared<const RgbdCalibration>(calibration);
                  return frame;
                }
              };
              desk->behaviour = Behaviour::kGood;
              return std::make_unique<Other>(desk);
            }
            return std::make_unique<FakeDevice>(desk);
          },
          kQuick)
          .value();
  ASSERT_TRUE(comes_back(*camera));
  desk_->behaviour = Behaviour::kUnplugged;
  EXPECT_THAT(complaint(*camera), HasSubstr("start again"));
}

TEST_F(WatchedCameraTest, EndsWithItsCameraAndWhenAsked) {
  const auto camera = watch();
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(camera->next_frame(stop.get_token()).value_or(nullptr), nullptr);
  desk_->behaviour = Behaviour::kEnds;
  auto frame = camera->next_frame({}).value();
  while (frame) frame = camera->next_frame({}).value();
  EXPECT_EQ(camera->next_frame({}).value(), nullptr);
}

TEST_F(WatchedCameraTest, SaysWhenThereIsNoneAtFirst) {
  const auto none = watch_camera([]() -> Result<std::unique_ptr<RangeCamera>> {
    return make_error(ErrorCode::kNotFound, "no device");
  });
  EXPECT_THAT(none.error().message, HasSubstr("no device"));
  EXPECT_THAT(watch_camera(nullptr, {.silence = milliseconds(0)}).error().message,
              HasSubstr("silence"));
}

int num_threads() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("Threads:")) return std::stoi(line.substr(8));
  }
  return -1;
}

std::ptrdiff_t num_files() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
}

TEST_F(WatchedCameraTest, FiveHundredTimesUnpluggedAndBackLeavesNothingBehind) {
  const int threads_before = num_threads();
  const auto files_before = num_files();
  {
    const auto camera = watch(
        {.silence = milliseconds(40), .retry = milliseconds(1), .give_up = milliseconds(5000)});
    for (int i = 0; i < 500; ++i) {
      desk_->behaviour = Behaviour::kUnplugged;
      const auto opened = desk_->num_opened.load();
      while (desk_->num_open > 0) std::this_thread::yield();
      desk_->behaviour = Behaviour::kGood;
      ASSERT_TRUE(comes_back(*camera)) << i;
      while (desk_->num_opened == opened) std::this_thread::yield();
    }
    EXPECT_EQ(desk_->num_open, 1);
    EXPECT_EQ(desk_->num_opened, 501);
    EXPECT_LE(num_threads(), threads_before + 1);
    EXPECT_EQ(num_files(), files_before + 1) << "the device that is open";
  }
  EXPECT_EQ(desk_->num_open, 0);
  EXPECT_EQ(num_files(), files_before);
}

}  // namespace
}  // namespace mor
