// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Through the real OpenNI2 with a driver of our own (testing/openni2_test_driver.cc), and an .oni
// file that OpenNI2's recorder made of it.

#include "morgagni/camera/openni2_camera.h"

#include <filesystem>
#include <fstream>
#include <thread>

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <openni2/OniCAPI.h>
#include <openni2/OniVersion.h>
#include <unistd.h>

#include "morgagni/camera/calibration_json.h"

namespace mor {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr const char* kInstalled = "/usr/lib/x86_64-linux-gnu";

/// OpenNI2 as installed, with our driver beside the stock player of .oni files.
class Openni2 : public testing::Test {
 protected:
  Openni2() {
    const auto drivers = home_ / "OpenNI2" / "Drivers";
    fs::create_directories(drivers);
    fs::create_symlink(fs::path(kInstalled) / "libOpenNI2.so.0", home_ / "libOpenNI2.so.0");
    fs::create_symlink(fs::path(kInstalled) / "OpenNI2/Drivers/libOniFile.so.0",
                       drivers / "libOniFile.so.0");
    fs::create_symlink(MORGAGNI_OPENNI2_TEST_DRIVER, drivers / "libMorgagniTest.so.0");
  }
  ~Openni2() override { fs::remove_all(home_); }

  Result<std::unique_ptr<RangeCamera>> open(const std::string& uri,
                                            const std::string& calibration = {}) const {
    return open_openni2({.uri = uri,
                         .calibration_file = calibration,
                         .library = (home_ / "libOpenNI2.so.0").string()});
  }

  /// Half a second of the device, by OpenNI2's own recorder.
  fs::path record() const {
    const auto library = dlopen((home_ / "libOpenNI2.so.0").c_str(), RTLD_NOW | RTLD_LOCAL);
    const auto f = [&]<class T>(T*, const char* name) {
      return reinterpret_cast<T*>(dlsym(library, name));
    };
#define MOR_ONI(name) f(static_cast<decltype(&::name)>(nullptr), #name)
    OniDeviceHandle device = nullptr;
    OniStreamHandle depth = nullptr, color = nullptr;
    OniRecorderHandle recorder = nullptr;
    const auto file = home_ / "test.oni";
    EXPECT_EQ(MOR_ONI(oniInitialize)(ONI_API_VERSION), ONI_STATUS_OK);
    EXPECT_EQ(MOR_ONI(oniDeviceOpen)("morgagni-test", &device), ONI_STATUS_OK);
    EXPECT_EQ(MOR_ONI(oniDeviceCreateStream)(device, ONI_SENSOR_DEPTH, &depth), ONI_STATUS_OK);
    EXPECT_EQ(MOR_ONI(oniDeviceCreateStream)(device, ONI_SENSOR_COLOR, &color), ONI_STATUS_OK);
    EXPECT_EQ(MOR_ONI(oniCreateRecorder)(file.c_str(), &recorder), ONI_STATUS_OK);
    EXPECT_EQ(MOR_ONI(oniRecorderAttachStream)(recorder, depth, 0), ONI_STATUS_OK);
    EXPECT_EQ(MOR_ONI(oniRecorderAttachStream)(recorder, color, 0), ONI_STATUS_OK);
    EXPECT_EQ(MOR_ONI(oniRecorderStart)(recorder), ONI_STATUS_OK);
    EXPECT_EQ(MOR_ONI(oniStreamStart)(depth), ONI_STATUS_OK);
    EXPECT_EQ(MOR_ONI(oniStreamStart)(color), ONI_STATUS_OK);
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    MOR_ONI(oniRecorderStop)(recorder);
    MOR_ONI(oniRecorderDestroy)(&recorder);
    MOR_ONI(oniStreamStop)(depth);
    MOR_ONI(oniStreamStop)(color);
    MOR_ONI(oniStreamDestroy)(depth);
    MOR_ONI(oniStreamDestroy)(color);
    MOR_ONI(oniDeviceClose)(device);
    MOR_ONI(oniShutdown)();
#undef MOR_ONI
    dlclose(library);
    return file;
  }

  const fs::path home_ = fs::temp_directory_path() / ("mor_openni2_" + std::to_string(getpid()));
};

TEST_F(Openni2, GivesDepthColourAndTheDevicesClock) {
  const auto camera = open("morgagni-test");
  ASSERT_TRUE(camera) << camera.error().message;
  EXPECT_NEAR((*camera)->calibration().depth.focal_x_px, 64.0, 1e-3);
  EXPECT_NEAR((*camera)->calibration().color.focal_y_px, 48.0, 1e-3);
  EXPECT_EQ((*camera)->calibration().color_from_depth.translation().x(), -25.0);
  std::shared_ptr<const RgbdFrame> last;
  for (int i = 0; i < 20; ++i) {
    const auto frame = (*camera)->next_frame({});
    ASSERT_TRUE(frame && *frame);
    EXPECT_EQ((*frame)->depth_mm(5, 5) - 700, (*frame)->device_time->count() / 10'000'000 % 100);
    if (last) {
      EXPECT_GT(*(*frame)->device_time, *last->device_time);
    }
    last = *frame;
  }
  EXPECT_EQ(last->depth_mm(0, 0), 0);
  EXPECT_EQ(last->depth_mm(1, 0), 1000);
  EXPECT_EQ(last->color(0, 0), (Rgb8{200, 0, 0}));
}

TEST_F(Openni2, AMirrorIsTurnedBack) {
  const auto camera = open("morgagni-test/mirrored").value();
  const auto frame = camera->next_frame({}).value();
  EXPECT_EQ(frame->depth_mm(63, 0), 0);
  EXPECT_EQ(frame->depth_mm(62, 0), 1000);
  EXPECT_EQ(frame->color(63, 0), (Rgb8{200, 0, 0}));
}

TEST_F(Openni2, ADeviceThatFallsSilentIsSaid) {
  const auto camera = open("morgagni-test/silent").value();
  auto frame = camera->next_frame({});
  ASSERT_TRUE(frame);
  while (frame && *frame) frame = camera->next_frame({});
  ASSERT_FALSE(frame);
  EXPECT_THAT(frame.error().message, HasSubstr("is its plug out?"));
}

TEST_F(Openni2, ADeviceThatSendsButNoWholeFramesIsSaidAndOpensAgain) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"colour-only", "sends no depth pictures"},
      {"damaged", "sends damaged depth pictures"},
      {"apart", "stamped too far apart"}};
  for (const auto& [kind, sentence] : cases) {
    for (int i = 0; i < 2; ++i) {
      const auto camera = open("morgagni-test/" + kind);
      ASSERT_TRUE(camera) << camera.error().message;
      auto frame = (*camera)->next_frame({});
      while (frame && *frame) frame = (*camera)->next_frame({});
      ASSERT_FALSE(frame);
      EXPECT_THAT(frame.error().message, HasSubstr(sentence));
    }
  }
}

TEST_F(Openni2, PlaysAnOniFileToItsEnd) {
  const auto file = record();
  ASSERT_TRUE(fs::exists(file));
  const auto camera = open(file.string());
  ASSERT_TRUE(camera) << camera.error().message;
  EXPECT_NEAR((*camera)->calibration().depth.focal_x_px, 64.0, 1e-3);
  int num_frames = 0;
  auto frame = (*camera)->next_frame({});
  for (; frame && *frame; frame = (*camera)->next_frame({})) {
    EXPECT_EQ((*frame)->depth_mm(1, 0), 1000);
    EXPECT_EQ((*frame)->color(0, 0), (Rgb8{200, 0, 0}));
    ++num_frames;
  }
  EXPECT_TRUE(frame) << "it ends, and does not fail";
  EXPECT_GE(num_frames, 5);
}

TEST_F(Openni2, SaysWhatIsMissing) {
  EXPECT_THAT(open("/nowhere.oni").error().message, HasSubstr("/nowhere.oni: no such file"));
  const auto file = home_ / "bad.oni";
  std::ofstream(file) << std::string(5000, 'x');
  EXPECT_THAT(open(file.string()).error().message, HasSubstr("bad.oni: OpenNI2 cannot play it"));
  EXPECT_THAT(open("no-such-device").error().message, HasSubstr("there is no OpenNI2 camera"));
  EXPECT_THAT(open_openni2({.library = "libOpenNI2.so.none"}).error().message,
              HasSubstr("package libopenni2-0"));
  EXPECT_THAT(open("morgagni-test", "/nowhere.json").error().message, HasSubstr("/nowhere.json"));
  EXPECT_THAT(Openni2Options::parse("a.oni,loop=1").error().message, HasSubstr("calibration"));
  const auto options = Openni2Options::parse("a.oni,calibration=c.json").value();
  EXPECT_EQ(options.uri, "a.oni");
  EXPECT_EQ(options.calibration_file, "c.json");
  EXPECT_EQ(Openni2Options::parse("")->uri, "");
}

}  // namespace
}  // namespace mor
