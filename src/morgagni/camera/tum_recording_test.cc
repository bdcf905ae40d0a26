// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/tum_recording.h"

#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <unistd.h>

#include "morgagni/camera/recording.h"
#include "morgagni/camera/tum_recorder.h"
#include "morgagni/core/files.h"
#include "morgagni/geometry/depth_levels.h"

namespace mor {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

class Tum : public testing::Test {
 protected:
  Tum()
      : home_(fs::temp_directory_path() / ("mor_tum_" + std::to_string(getpid()))),
        folder_(home_ / "recording") {
    fs::remove_all(home_);
    fs::create_directories(home_);
  }
  ~Tum() override { fs::remove_all(home_); }

  static RgbdFrame frame(std::uint64_t id) {
    static const auto kCalibration = [] {
      const PinholeCamera camera{.width_px = 8,
                                 .height_px = 6,
                                 .focal_x_px = 7.25,
                                 .focal_y_px = 7.5,
                                 .center_x_px = 3.5,
                                 .center_y_px = 2.5,
                                 .distortion = {0.1, -0.2, 0.001, 0.002, 0.05}};
      return std::make_shared<const RgbdCalibration>(
          RgbdCalibration{camera, camera, Eigen::Isometry3d::Identity()});
    }();
    RgbdFrame result;
    result.frame_id = id;
    result.calibration = kCalibration;
    result.depth_mm = Image<std::uint16_t>(8, 6, static_cast<std::uint16_t>(500 + id));
    result.depth_mm(1, 2) = 0;
    result.color = Image<Rgb8>(8, 6, Rgb8{static_cast<std::uint8_t>(id), 20, 30});
    return result;
  }

  /// A good recording of `count` frames, 1/30 s apart.
  void record(std::uint64_t count, double first_s = 100.0) const {
    auto recorder = TumRecorder::create(folder_).value();
    for (std::uint64_t i = 0; i < count; ++i) {
      ASSERT_TRUE(recorder.add(frame(i), first_s + static_cast<double>(i) / 30.0, std::nullopt));
    }
    ASSERT_TRUE(recorder.finish());
  }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  std::string text_of(const std::string& name) const {
    return read_text_file(folder_ / name, 1U << 20U).value();
  }
  std::string open_error() const {
    const auto recording = TumRecording::open(folder_);
    return recording ? "opened" : recording.error().message;
  }

  std::unique_ptr<const Recording> open_recording() const {
    return std::make_unique<const TumRecording>(TumRecording::open(folder_).value());
  }

  fs::path home_;
  fs::path folder_;
};

TEST_F(Tum, GivesBackWhatWasRecorded) {
  record(4);
  const auto recording = TumRecording::open(folder_);
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->size(), 4U);
  EXPECT_EQ(*recording->calibration()->depth.distortion.begin(), 0.1);
  for (std::uint64_t i = 0; i < 4; ++i) {
    const auto read = recording->read(i);
    ASSERT_TRUE(read) << read.error().message;
    const auto written = frame(i);
    EXPECT_EQ((*read)->frame_id, i);
    EXPECT_EQ((*read)->depth_mm, written.depth_mm);
    EXPECT_EQ((*read)->color, written.color);
    EXPECT_EQ((*read)->calibration->depth, written.calibration->depth);
    EXPECT_EQ((*read)->calibration->color, written.calibration->color);
    EXPECT_NEAR(recording->timestamp_s(i), 100.0 + static_cast<double>(i) / 30.0, 1e-6);
  }
  EXPECT_FALSE(fs::exists(folder_ / "groundtruth.txt"));
  EXPECT_FALSE(recording->read(4));
}

TEST_F(Tum, WritesTheTruthInRasAndMetres) {
  auto recorder = TumRecorder::create(folder_).value();
  Eigen::Isometry3d ct_from_camera(Eigen::Translation3d(100.0, -200.0, 300.0));
  ct_from_camera.rotate(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()));
  ASSERT_TRUE(recorder.add(frame(0), 1.5, ct_from_camera));
  ASSERT_TRUE(recorder.finish());
  const auto text = text_of("groundtruth.txt");
  std::istringstream in(text.substr(text.find('\n') + 1));
  double stamp = 0, x = 0, y = 0, z = 0, qx = 0, qy = 0, qz = 0, qw = 0;
  in >> stamp >> x >> y >> z >> qx >> qy >> qz >> qw;
  EXPECT_EQ(stamp, 1.5);
  EXPECT_TRUE(Eigen::Vector3d(x, y, z).isApprox(Eigen::Vector3d(-0.1, 0.2, 0.3), 1e-6));
  // Where the camera's own x and z axes point: x and y turn around, z stays.
  const Eigen::Quaterniond q(qw, qx, qy, qz);
  const Eigen::Vector3d axis_lps = ct_from_camera.linear() * Eigen::Vector3d::UnitX();
  EXPECT_TRUE((q * Eigen::Vector3d::UnitX())
                  .isApprox(Eigen::Vector3d(-axis_lps.x(), -axis_lps.y(), axis_lps.z()), 1e-6));
  EXPECT_TRUE((q * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitZ(), 1e-6));
}

TEST_F(Tum, KeepsAFurtherFileButNoneOfItsOwn) {
  auto recorder = TumRecorder::create(folder_).value();
  ASSERT_TRUE(recorder.add(frame(0), 1.0, std::nullopt));
  ASSERT_TRUE(recorder.add_file("targets.csv", "name\n"));
  EXPECT_FALSE(recorder.add_file("targets.csv", "again\n"));
  EXPECT_FALSE(recorder.add_file("../targets.csv", "outside\n"));
  EXPECT_FALSE(recorder.add_file("rgb", "a folder\n"));
  ASSERT_TRUE(recorder.finish());
  EXPECT_FALSE(recorder.add_file("late.csv", "late\n"));
  EXPECT_EQ(text_of("targets.csv"), "name\n");
}

TEST_F(Tum, HalfARecordingLeavesNothing) {
  {
    auto recorder = TumRecorder::create(folder_).value();
    ASSERT_TRUE(recorder.add(frame(0), 1.0, std::nullopt));
    EXPECT_FALSE(fs::exists(folder_));
  }
  EXPECT_TRUE(fs::is_empty(home_));
}

TEST_F(Tum, RecordsIntoAnEmptyFolderAndRefusesAFullOne) {
  fs::create_directories(folder_);
  record(1);
  const auto again = TumRecorder::create(folder_);
  ASSERT_FALSE(again);
  EXPECT_THAT(again.error().message, HasSubstr("not an empty folder"));
  EXPECT_EQ(TumRecording::open(folder_)->size(), 1U);
}

TEST_F(Tum, RefusesFramesThatTheLayoutCannotHold) {
  auto recorder = TumRecorder::create(folder_).value();
  EXPECT_THAT(recorder.finish().error().message, HasSubstr("no frames"));
  ASSERT_TRUE(recorder.add(frame(0), 1.0, std::nullopt));
  EXPECT_THAT(recorder.add(frame(1), 1.0, std::nullopt).error().message,
              HasSubstr("does not come after"));
  EXPECT_THAT(recorder.add(frame(1), 2.0, Eigen::Isometry3d::Identity()).error().message,
              HasSubstr("every frame or for none"));
  auto two = frame(1);
  auto calibration = *two.calibration;
  calibration.color_from_depth.translation().x() = 25.0;
  two.calibration = std::make_shared<const RgbdCalibration>(calibration);
  EXPECT_EQ(recorder.add(two, 2.0, std::nullopt).error().code, ErrorCode::kUnsupported);
  auto small = frame(1);
  small.color = Image<Rgb8>(4, 3);
  EXPECT_THAT(recorder.add(small, 2.0, std::nullopt).error().message, HasSubstr("8x6"));
}

TEST_F(Tum, KeepsTheDepthCorrectionAndWhatTheSensorGave) {
  auto sensed = std::make_shared<RgbdFrame>(frame(0));
  auto calibration = *sensed->calibration;
  DepthCorrection correction;
  correction.control = {{.c0_mm = 4.0, .c1 = 1.0 / 300.0}};
  calibration.depth_correction = std::make_shared<const DepthCorrection>(correction);
  sensed->calibration = std::make_shared<const RgbdCalibration>(calibration);
  auto recorder = TumRecorder::create(folder_).value();
  DepthLevels levels;
  ASSERT_TRUE(recorder.add(*depth_corrected(sensed, levels), 1.0, std::nullopt));
  EXPECT_THAT(recorder.add(frame(1), 2.0, std::nullopt).error().message,
              HasSubstr("calibration changed"));
  ASSERT_TRUE(recorder.finish());
  const auto recording = TumRecording::open(folder_).value();
  EXPECT_EQ(*recording.calibration(), calibration);
  EXPECT_EQ(recording.read(0).value()->depth_mm, sensed->depth_mm);

  auto text = text_of("intrinsics.json");
  text.replace(text.find("\"rows\": 1"), 9, "\"rows\": 2");
  write("intrinsics.json", text);
  EXPECT_THAT(open_error(), AllOf(HasSubstr("intrinsics.json"), HasSubstr("must hold 2 numbers")));
}

TEST_F(Tum, SaysWhatIsMissing) {
  EXPECT_THAT(open_error(), HasSubstr("no such folder"));
  for (const char* name : {"rgb.txt", "depth.txt", "intrinsics.json"}) {
    fs::remove_all(folder_);
    record(3);
    fs::remove(folder_ / name);
    EXPECT_THAT(open_error(), AllOf(HasSubstr(name), HasSubstr("no such file")));
  }
}

TEST_F(Tum, RefusesIntrinsicsThatAreNone) {
  record(1);
  const auto good = text_of("intrinsics.json");
  const auto with = [&](const std::string& from, const std::string& to) {
    auto text = good;
    text.replace(text.find(from), from.size(), to);
    write("intrinsics.json", text);
    return open_error();
  };
  EXPECT_THAT(with("\"fx\"", "\"focal\""), HasSubstr("no number 'fx'"));
  EXPECT_THAT(with("7.25", "\"wide\""), HasSubstr("no number 'fx'"));
  EXPECT_THAT(with("7.25", "-7.25"), HasSubstr("intrinsics.json"));
  EXPECT_THAT(with("\"width\": 8", "\"width\": 0"), HasSubstr("width must be in"));
  EXPECT_THAT(with("\"width\": 8", "\"width\": 1e300"), HasSubstr("width must be in"));
  EXPECT_THAT(with("1000.0", "0"), HasSubstr("depth_scale"));
  EXPECT_THAT(with("0.1,", ""), HasSubstr("five numbers"));
  EXPECT_THAT(with("0.1,", "null,"), HasSubstr("distortion number 0"));
  write("intrinsics.json", "{");
  EXPECT_THAT(open_error(), HasSubstr("not a JSON object"));
  write("intrinsics.json", std::string(100000, '['));
  EXPECT_THAT(open_error(), HasSubstr("not a JSON object"));
}

TEST_F(Tum, RefusesListsThatAreWrongOrDoNotMatch) {
  record(5);
  const auto good = text_of("rgb.txt");
  const auto with = [&](const std::string& text) {
    write("rgb.txt", text);
    return open_error();
  };
  EXPECT_EQ(with("# a comment\n\n" + good), "opened");
  EXPECT_THAT(with("# nothing\n"), HasSubstr("lists no pictures"));
  EXPECT_THAT(with("now rgb/000000.png\n"), HasSubstr("'now rgb/000000.png'"));
  EXPECT_THAT(with("nan rgb/000000.png\n"), HasSubstr("not a time stamp"));
  EXPECT_THAT(with("1e300 rgb/000000.png\n"), HasSubstr("not a time stamp"));
  EXPECT_THAT(with("1.0\n"), HasSubstr("not a time stamp"));
  EXPECT_THAT(with("1.0 rgb/000000.png more\n"), HasSubstr("not a time stamp"));
  EXPECT_THAT(with("2 rgb/000000.png\n1 rgb/000001.png\n"), HasSubstr("does not come after"));
  EXPECT_THAT(with(good.substr(0, good.rfind("100."))), HasSubstr("do not match: only 4 pairs"));
  EXPECT_THAT(with("5.0 rgb/000000.png\n"), HasSubstr("do not match: only 0 pairs"));
}

TEST_F(Tum, RefusesPathsThatLeaveTheFolder) {
  record(1);
  std::ofstream(home_ / "secret.png") << "secret";
  fs::create_symlink(home_ / "secret.png", folder_ / "link.png");
  for (const std::string path :
       {"../secret.png", "/etc/passwd", "rgb/../../secret.png", "link.png", "."}) {
    write("rgb.txt", "100.0 " + path + "\n");
    EXPECT_THAT(open_error(), AllOf(HasSubstr("rgb.txt"), HasSubstr("leaves"))) << path;
  }
}

TEST_F(Tum, ToleratesAPictureWithoutPartnerInALongRecording) {
  record(30);
  auto colors = text_of("rgb.txt");
  write("rgb.txt", colors.substr(0, colors.rfind("100.")));
  const auto recording = TumRecording::open(folder_);
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->size(), 29U);
}

TEST_F(Tum, NamesThePictureThatCannotBeRead) {
  record(3);
  const auto picture = text_of("depth/000001.png");
  write("depth/000001.png", picture.substr(0, picture.size() / 2));
  fs::copy_file(folder_ / "rgb/000000.png",
                folder_ / "depth/000000.png",
                fs::copy_options::overwrite_existing);
  fs::remove(folder_ / "rgb/000002.png");
  const auto recording = TumRecording::open(folder_).value();
  EXPECT_THAT(recording.read(0).error().message,
              AllOf(HasSubstr("000000.png"), HasSubstr("16-bit")));
  EXPECT_THAT(recording.read(1).error().message, HasSubstr("depth/000001.png"));
  EXPECT_THAT(recording.read(2).error().message, HasSubstr("rgb/000002.png"));
}

TEST_F(Tum, ScalesDepthByTheFilesUnit) {
  record(1);
  auto text = text_of("intrinsics.json");
  text.replace(text.find("1000.0"), 6, "5000.0");
  write("intrinsics.json", text);
  EXPECT_EQ((*TumRecording::open(folder_)->read(0))->depth_mm(0, 0), 100);
}

TEST_F(Tum, PlaysAtFullSpeedToItsEndOrRoundAndRound) {
  record(3);
  for (const bool is_looped : {false, true}) {
    const auto camera =
        play_recording(open_recording(), {.is_looped = is_looped, .is_real_time = false});
    for (std::uint64_t i = 0; i < (is_looped ? 7U : 3U); ++i) {
      EXPECT_EQ(camera->next_frame({}).value()->frame_id, i % 3);
    }
    if (!is_looped) {
      EXPECT_EQ(camera->next_frame({}).value(), nullptr);
    }
  }
}

TEST_F(Tum, AtFullSpeedTheTimesBetweenFramesAreTheRecordings) {
  record(3);
  const auto camera = play_recording(open_recording(), {.is_looped = true, .is_real_time = false});
  const auto first = camera->next_frame({}).value()->captured_at;
  for (int i = 1; i < 7; ++i) {
    if (i == 2) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const std::chrono::duration<double> since = camera->next_frame({}).value()->captured_at - first;
    EXPECT_NEAR(since.count(), i / 30.0, 1e-6) << i;
  }
}

TEST_F(Tum, PlaysByItsStampsAndSkipsWhatASlowCallerMissed) {
  record(30);
  const auto camera = play_recording(open_recording(), {});
  const auto first = camera->next_frame({}).value();
  const auto second = camera->next_frame({}).value();
  EXPECT_EQ(first->frame_id, 0U);
  const std::chrono::duration<double> gap = second->captured_at - first->captured_at;
  EXPECT_NEAR(gap.count(), static_cast<double>(second->frame_id) / 30.0, 1e-4);
  std::this_thread::sleep_for(std::chrono::milliseconds(210));  // A caller that is busy.
  EXPECT_GE(camera->next_frame({}).value()->frame_id, second->frame_id + 6);
}

TEST_F(Tum, StopsWaitingWhenAsked) {
  auto recorder = TumRecorder::create(folder_).value();
  ASSERT_TRUE(recorder.add(frame(0), 0.0, std::nullopt));
  ASSERT_TRUE(recorder.add(frame(1), 3600.0, std::nullopt));
  ASSERT_TRUE(recorder.finish());
  const auto camera = play_recording(open_recording(), {});
  ASSERT_TRUE(camera->next_frame({}).value());
  std::stop_source stop;
  const std::jthread stopper([&] { stop.request_stop(); });
  EXPECT_EQ(camera->next_frame(stop.get_token()).value(), nullptr);
}

TEST_F(Tum, GoesOnAfterAFrameThatCannotBeRead) {
  record(3);
  fs::remove(folder_ / "rgb/000001.png");
  const auto camera = play_recording(open_recording(), {.is_real_time = false});
  EXPECT_TRUE(camera->next_frame({}));
  EXPECT_FALSE(camera->next_frame({}));
  EXPECT_EQ(camera->next_frame({}).value()->frame_id, 2U);
}

TEST(TumRecording, OpensEveryCaseOfTheRealData) {
  const fs::path root = fs::path(MORGAGNI_DATA_DIR) / "synthetic_rgbd";
  if (!fs::exists(root)) GTEST_SKIP() << root << " is absent";
  int num_cases = 0;
  for (const auto& entry : fs::directory_iterator(root)) {
    if (!entry.is_directory()) continue;
    const auto recording = TumRecording::open(entry.path());
    ASSERT_TRUE(recording) << recording.error().message;
    EXPECT_GE(recording->size(), 5U);
    const auto frame = recording->read(recording->size() - 1);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ((*frame)->depth_mm.width(), 640);
    ++num_cases;
  }
  EXPECT_EQ(num_cases, 6);
}

}  // namespace
}  // namespace mor
