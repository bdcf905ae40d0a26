// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Through fakenect, libfreenect's player of dumps, with dumps written here.

#include "morgagni/camera/freenect_camera.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <unistd.h>

#include "morgagni/camera/calibration_json.h"
#include "morgagni/camera/internal/kinect/kinect_depth.h"

namespace mor {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr const char* kFakenect = "/usr/lib/x86_64-linux-gnu/fakenect/libfreenect.so.0.5";
constexpr std::uint32_t kTicksPerFrame = 2'000'000;

TEST(KinectDepth, TriangulatesAsThoseWhoMeasuredItFound) {
  const auto mm = internal::kinect_mm_from_raw({});
  EXPECT_EQ(mm[internal::kKinectNoReading], 0);
  EXPECT_EQ(mm[801], 1198) << "three eighths of a pixel off the reference plane";
  EXPECT_EQ(mm[802], 1202);
  for (std::size_t raw = 500; raw < 1000; ++raw) {
    // The fit that S. Magnenat published, good to a few centimetres.
    const double fitted_mm = 123.6 * std::tan(static_cast<double>(raw) / 2842.5 + 1.1863);
    EXPECT_NEAR(mm[raw], fitted_mm, 0.025 * fitted_mm) << raw;
    EXPECT_GE(mm[raw], mm[raw - 1]);
  }
  EXPECT_EQ(mm[1200], 0) << "beyond ten metres";
}

TEST(KinectDepth, RefusesAMemoryThatHoldsNonsense) {
  EXPECT_TRUE(internal::KinectGeometry{}.check());
  internal::KinectGeometry geometry;
  geometry.emitter_distance_mm = 0.0;
  EXPECT_THAT(geometry.check().error().message, HasSubstr("emitter 0 mm"));
  geometry = {};
  geometry.raw_at_reference = std::nan("");
  EXPECT_FALSE(geometry.check());
}

class Fakenect : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kFakenect)) GTEST_SKIP() << kFakenect << " is absent (libfreenect-dev)";
    fs::remove_all(home_);
    fs::create_directories(home_);
    setenv("FAKENECT_PATH", home_.c_str(), 1);
  }
  ~Fakenect() override { fs::remove_all(home_); }

  /// @param first_ticks  Of the device's clock.
  void write_dump(int num_frames, std::uint32_t first_ticks) const {
    std::ofstream index(home_ / "INDEX.txt");
    for (int i = 0; i < num_frames; ++i) {
      const auto ticks = first_ticks + static_cast<std::uint32_t>(i) * kTicksPerFrame;
      // Almost no time between: a replay as fast as it goes.
      const auto time = "1300000000.00" + std::to_string(1000 + 2 * i);
      write_picture(
          index, "r-" + time + "-" + std::to_string(ticks + 5000) + ".ppm", [&](auto& out) {
            out << "P6 640 480 255\n";
            std::vector<char> rgb(internal::kKinectPixels * 3, static_cast<char>(10 + i));
            rgb[3] = 99;
            out.write(rgb.data(), static_cast<std::streamsize>(rgb.size()));
          });
      write_picture(index, "d-" + time + "-" + std::to_string(ticks) + ".pgm", [&](auto& out) {
        out << "P5 640 480 65535\n";
        std::vector<std::uint16_t> raw(internal::kKinectPixels,
                                       static_cast<std::uint16_t>(700 + i));
        raw[7] = internal::kKinectNoReading;
        raw[8] = 802;
        out.write(reinterpret_cast<const char*>(raw.data()),
                  static_cast<std::streamsize>(raw.size() * 2));
      });
    }
  }

  /// Three seconds with depth ('d') or colour ('r') alone.
  void write_dump_of(char letter) const {
    std::ofstream index(home_ / "INDEX.txt");
    for (int i = 0; i < 30; ++i) {
      const auto name = std::string(1, letter) + "-" + std::to_string(1.3e9 + 0.1 * i) + "-" +
                        std::to_string(i) + (letter == 'd' ? ".pgm" : ".ppm");
      write_picture(index, name, [&](auto& out) {
        out << (letter == 'd' ? "P5 640 480 65535\n" : "P6 640 480 255\n")
            << std::string(internal::kKinectPixels * (letter == 'd' ? 2 : 3), '\1');
      });
    }
  }

  template <class Write>
  void write_picture(std::ofstream& index, const std::string& name, const Write& write) const {
    index << name << "\n";
    std::ofstream out(home_ / name, std::ios::binary);
    write(out);
  }

  const fs::path home_ = fs::temp_directory_path() / ("mor_fakenect_" + std::to_string(getpid()));
};

TEST_F(Fakenect, GivesMillimetresColourAndTheDevicesClock) {
  // The clock of 32 bits wraps between the second and the third frame.
  write_dump(20, 0U - kTicksPerFrame - kTicksPerFrame / 2);
  auto opened = open_freenect({.library = kFakenect});
  ASSERT_TRUE(opened) << opened.error().message;
  auto& camera = **opened;
  EXPECT_NEAR(camera.calibration().depth.focal_x_px, 575.8, 0.1);
  EXPECT_EQ(camera.calibration().color_from_depth.translation().x(), -23.0);
  const auto mm = internal::kinect_mm_from_raw({});
  std::uint64_t num_frames = 0;
  std::shared_ptr<const RgbdFrame> last;
  auto frame = camera.next_frame({});
  for (; frame; frame = camera.next_frame({})) {
    const auto& f = **frame;
    const int i = f.color(0, 0).r - 10;  // Which one of the dump: a slow caller misses some.
    ASSERT_TRUE(i >= 0 && i < 20);
    EXPECT_EQ(f.depth_mm(100, 100), mm[static_cast<std::size_t>(700 + i)]);
    EXPECT_EQ(f.depth_mm(7, 0), 0);
    EXPECT_EQ(f.depth_mm(8, 0), mm[802]);
    EXPECT_EQ(f.color(1, 0).r, 99);
    if (last) {
      const auto since = *f.device_time - *last->device_time;
      const auto frames = i - (last->color(0, 0).r - 10);
      EXPECT_NEAR(static_cast<double>(since.count()), frames * 1e9 / 30.0, 20.0);
      EXPECT_GE(f.captured_at, last->captured_at);
    }
    last = *frame;
    ++num_frames;
  }
  EXPECT_GE(num_frames, 1U);
  EXPECT_THAT(frame.error().message, HasSubstr("the Kinect is gone"));
  EXPECT_EQ(frame.error().code, ErrorCode::kDevice);
}

TEST_F(Fakenect, AKinectOfWhichOnePictureIsMissingIsSaidAndOpensAgain) {
  for (const auto& [letter, sentence] :
       {std::pair{'r', "sends no depth pictures"}, {'d', "sends no colour pictures"}}) {
    write_dump_of(letter);
    for (int i = 0; i < 2; ++i) {
      const auto camera = open_freenect({.library = kFakenect}).value();
      const auto frame = camera->next_frame({});
      ASSERT_FALSE(frame);
      EXPECT_EQ(frame.error().code, ErrorCode::kDevice);
      EXPECT_THAT(frame.error().message, HasSubstr(sentence));
    }
  }
}

TEST_F(Fakenect, TakesACalibrationFile) {
  write_dump(2, 0);
  auto calibration = internal::kinect_calibration({});
  calibration.color.focal_x_px = 521.5;
  const auto file = home_ / "kinect.json";
  std::ofstream(file) << calibration_to_json(calibration);
  const auto camera =
      open_freenect({.calibration_file = file.string(), .library = kFakenect}).value();
  // It says where it is from.
  calibration.origin = file.string();
  EXPECT_EQ(camera->calibration(), calibration);
  calibration.depth.width_px = 320;
  std::ofstream(file) << calibration_to_json(calibration);
  EXPECT_THAT(
      open_freenect({.calibration_file = file.string(), .library = kFakenect}).error().message,
      AllOf(HasSubstr("kinect.json"), HasSubstr("320x480")));
  std::ofstream(file) << "{}";
  EXPECT_THAT(
      open_freenect({.calibration_file = file.string(), .library = kFakenect}).error().message,
      AllOf(HasSubstr("kinect.json"), HasSubstr("has no depth")));
}

TEST_F(Fakenect, ThereIsOneKinectOnly) {
  write_dump(2, 0);
  EXPECT_EQ(count_freenect_devices(kFakenect).value(), 1);
  EXPECT_THAT(open_freenect({.index = 3, .library = kFakenect}).error().message,
              HasSubstr("no Kinect 3, only 1"));
}

TEST(Freenect, SaysWhatIsMissing) {
  EXPECT_THAT(open_freenect({.library = "libfreenect.so.none"}).error().message,
              HasSubstr("package libfreenect0.5"));
  EXPECT_THAT(open_freenect({.library = "libz.so.1"}).error().message, HasSubstr("no libfreenect"));
  EXPECT_THAT(FreenectOptions::parse("index=16").error().message, HasSubstr("[0, 15]"));
  EXPECT_THAT(FreenectOptions::parse("serial=1").error().message, HasSubstr("index, calibration"));
  EXPECT_EQ(FreenectOptions::parse("index=2,calibration=k.json")->calibration_file, "k.json");
}

}  // namespace
}  // namespace mor
