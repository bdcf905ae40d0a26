// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/open_camera.h"

#include <filesystem>
#include <vector>

#include <gmock/gmock.h>

namespace mor {
namespace {

using testing::HasSubstr;

std::string error_of(const std::string& name) {
  const auto camera = open_camera(name, nullptr);
  return camera ? "opened" : camera.error().message;
}

TEST(OpenCamera, NamesTheKindsThatThereAre) {
  for (const char* name : {"", "kinect", "kinect:0", "simulated", "tum", ":", "TUM:x"}) {
    EXPECT_THAT(error_of(name),
                AllOf(HasSubstr("freenect:"),
                      HasSubstr("simulated:"),
                      HasSubstr("mcap:FILE"),
                      HasSubstr("push:PORT"),
                      HasSubstr("v4l2:/dev/videoN"),
                      HasSubstr("tum:DIR")))
        << name;
  }
}

TEST(OpenCamera, PassesOnWhatIsWrongWithTheOptions) {
  EXPECT_THAT(error_of("simulated:path=up"), HasSubstr("orbit"));
  EXPECT_THAT(error_of("simulated:"), HasSubstr("skin"));
  EXPECT_THAT(error_of("freenect:index=99"), HasSubstr("[0, 15]"));
  EXPECT_THAT(error_of("freenect:calibration=/nowhere.json,mode=1"), HasSubstr("'mode'"));
  EXPECT_THAT(error_of("openni2:x.oni,speed=full"), HasSubstr("calibration, device"));
  EXPECT_THAT(error_of("push:"), HasSubstr("needs a port"));
  EXPECT_THAT(error_of("push:65536"), HasSubstr("[0, 65535]"));
  EXPECT_THAT(error_of("push:here:0"), HasSubstr("'here' is no IP address"));
  EXPECT_THAT(error_of("push:0,token=short"), HasSubstr("at least 8"));
  EXPECT_THAT(error_of("push:0,tolerance_ms=0"), HasSubstr("[1, 1000]"));
  EXPECT_THAT(error_of("push:0,calibration=/nowhere.json"), HasSubstr("/nowhere.json"));
  EXPECT_THAT(error_of("push:0,speed=full"), HasSubstr("token, calibration, device, tolerance_ms"));
  EXPECT_THAT(error_of("v4l2:"), HasSubstr("needs a device"));
  EXPECT_THAT(error_of("v4l2:/dev/no_video"), HasSubstr("there is no /dev/no_video"));
  EXPECT_THAT(error_of("tum:"), HasSubstr("needs a folder"));
  EXPECT_THAT(error_of("tum:/nowhere"), HasSubstr("/nowhere"));
  EXPECT_THAT(error_of("tum:/nowhere,loop=2"), HasSubstr("loop must be one of 0, 1"));
  EXPECT_THAT(error_of("tum:/nowhere,speed=2"), HasSubstr("real, full"));
  EXPECT_THAT(error_of("tum:/nowhere,lop=1"), AllOf(HasSubstr("'lop'"), HasSubstr("loop, speed")));
}

TEST(OpenCamera, ShowsNoSecret) {
  EXPECT_EQ(shown_camera_name("push:8765,token=abc/def=1,tolerance_ms=5"),
            "push:8765,token=...,tolerance_ms=5");
  EXPECT_EQ(shown_camera_name("push:8765,token=abcdefgh"), "push:8765,token=...");
  EXPECT_EQ(shown_camera_name("simulated:seed=1"), "simulated:seed=1");
}

TEST(OpenCamera, TellsDevicesFromRecordings) {
  for (const char* name :
       {"freenect:", "openni2:", "openni2:calibration=a.json", "push:8765", "v4l2:/dev/video0"}) {
    EXPECT_TRUE(is_device_camera(name)) << name;
  }
  for (const char* name :
       {"simulated:", "tum:x", "mcap:x", "openni2:a.oni,device=x", "push", "", ":", "freenect"}) {
    EXPECT_FALSE(is_device_camera(name)) << name;
  }
}

TEST(OpenCamera, WaitsForADeviceWhereSomebodyIsTold) {
  std::stop_source stop;
  std::vector<std::string> said;
  const auto say = [&](const std::string& sentence) {
    said.push_back(sentence);
    stop.request_stop();
  };
  const auto camera = open_camera("v4l2:/dev/no_video", nullptr, stop.get_token(), {}, say);
  EXPECT_EQ(camera.error().code, ErrorCode::kCancelled);
  ASSERT_EQ(said.size(), 1U);
  EXPECT_THAT(said[0], HasSubstr("there is no /dev/no_video"));
  said.clear();
  // What does not come by waiting is an error at once.
  const auto wrong = [&](const char* name) {
    return open_camera(name, nullptr, std::stop_token(), {}, say).error().message;
  };
  EXPECT_THAT(wrong("v4l2:/dev/no_video,calibration=/nowhere.json"), HasSubstr("/nowhere.json"));
  EXPECT_THAT(wrong("v4l2:/dev/no_video,device=a/b"), HasSubstr("is no device's id"));
  EXPECT_THAT(said, testing::IsEmpty());
}

TEST(OpenCamera, StopsToWaitForADeviceThatPushesWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  const auto camera = open_camera("push:0", nullptr, stop.get_token());
  EXPECT_THAT(camera.error().message, HasSubstr("stopped before a device"));
}

TEST(OpenCamera, OpensTheSimulationAndARecording) {
  auto skin = std::make_shared<TriangleMesh>();
  skin->vertices = {{0, 0, 0}, {100, 0, 0}, {0, 10, 100}};
  skin->triangles = {{0, 1, 2}};
  const auto simulated = open_camera("simulated:width=64,height=48,speed=full", skin);
  ASSERT_TRUE(simulated) << simulated.error().message;
  EXPECT_EQ((*simulated)->calibration().depth.width_px, 64);
  EXPECT_TRUE((*simulated)->next_frame({}).value());

  const auto folder = std::filesystem::path(MORGAGNI_DATA_DIR) / "synthetic_rgbd" / "head_seq";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  const auto tum = open_camera("tum:" + folder.string() + ",loop=1,speed=full", nullptr);
  ASSERT_TRUE(tum) << tum.error().message;
  EXPECT_EQ((*tum)->next_frame({}).value()->frame_id, 0U);
}

}  // namespace
}  // namespace mor
