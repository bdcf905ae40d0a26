// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/matroska_recorder.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "morgagni/camera/calibration_json.h"
#include "morgagni/camera/testing/sample_recording.h"
#include "morgagni/core/files.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr std::uint64_t kNumFrames = 7;

class MatroskaTest : public testing::Test {
 protected:
  MatroskaTest() { fs::create_directories(folder_); }
  ~MatroskaTest() override { fs::remove_all(folder_); }

  Result<void> record(ColorCoding color) const {
    MOR_TRY(auto recorder, MatroskaRecorder::create(file_, color));
    for (std::uint64_t i = 0; i < kNumFrames; ++i) {
      MOR_CHECK(recorder.add(internal::sample_frame(i)));
    }
    return recorder.finish();
  }
  /// What ffmpeg makes of it. @param how  Its options, after the input's.
  std::string ffmpeg(const std::string& before, const std::string& how) const {
    const auto out = (folder_ / "out").string();
    fs::remove(out);
    const auto command = fmt::format(
        "ffmpeg -v error -y {} -i {} {} {} </dev/null", before, file_.string(), how, out);
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    return read_text_file(out, 1U << 26U).value_or("");
  }

  const fs::path folder_ = fs::temp_directory_path() / ("mor_matroska_" + std::to_string(getpid()));
  const fs::path file_ = folder_ / "sample.mkv";
};

TEST_F(MatroskaTest, FfmpegFindsEveryBitOfTheDepth) {
  ASSERT_TRUE(record(ColorCoding::kJpeg));
  const auto pixels = ffmpeg("", "-map 0:v:0 -vsync 0 -f rawvideo -pix_fmt gray16le");
  std::string expected;
  for (std::uint64_t i = 0; i < kNumFrames; ++i) {
    const auto frame = internal::sample_frame(i);
    expected.append(reinterpret_cast<const char*>(frame.depth_mm.data()),
                    frame.depth_mm.size() * 2);
  }
  EXPECT_EQ(pixels.size(), expected.size());
  EXPECT_TRUE(pixels == expected);
  // And the colour, nearly as it was.
  const auto color = ffmpeg("", "-map 0:v:1 -vsync 0 -f rawvideo -pix_fmt rgb24");
  ASSERT_EQ(color.size(), kNumFrames * 40 * 30 * 3);
  EXPECT_NEAR(static_cast<unsigned char>(color[3 * 620]), 620 % 256, 40);
}

TEST_F(MatroskaTest, FfmpegFindsEveryBitOfLosslessColour) {
  ASSERT_TRUE(record(ColorCoding::kLossless));
  const auto pixels = ffmpeg("", "-map 0:v:1 -vsync 0 -f rawvideo -pix_fmt rgb24");
  std::string expected;
  for (std::uint64_t i = 0; i < kNumFrames; ++i) {
    const auto frame = internal::sample_frame(i);
    expected.append(reinterpret_cast<const char*>(frame.color.data()), frame.color.size() * 3);
  }
  EXPECT_TRUE(pixels == expected);
}

TEST_F(MatroskaTest, KeepsTheCalibrationAndTheTimes) {
  ASSERT_TRUE(record(ColorCoding::kJpeg));
  const auto attachment = (folder_ / "calibration.json").string();
  (void)ffmpeg("-dump_attachment:t:0 " + attachment, "-map 0:v:0 -f null");
  const auto calibration = calibration_from_json(read_text_file(attachment, 1U << 20U).value());
  ASSERT_TRUE(calibration) << calibration.error().message;
  EXPECT_EQ(*calibration, *internal::sample_calibration());

  const auto lines = ffmpeg("", "-map 0:s:0 -c copy -f data");
  std::uint64_t next = 0;
  for (std::size_t at = 0; (at = lines.find('{', at)) != std::string::npos; ++next) {
    const auto end = lines.find('}', at);
    const auto times = nlohmann::json::parse(lines.substr(at, end + 1 - at));
    EXPECT_EQ(times["frame"], next);
    EXPECT_EQ(times["time_ns"], next * 33'333'333);
    EXPECT_EQ(times["device_ns"], 7'000'000'123 + next * 33'333'000);
    at = end;
  }
  EXPECT_EQ(next, kNumFrames);
}

TEST_F(MatroskaTest, IsThereWhenItIsWholeAndNotBefore) {
  {
    auto recorder = MatroskaRecorder::create(file_, ColorCoding::kJpeg).value();
    ASSERT_TRUE(recorder.add(internal::sample_frame(0)));
    EXPECT_FALSE(fs::exists(file_));
  }
  EXPECT_TRUE(fs::is_empty(folder_)) << "what was not finished is removed";
  ASSERT_TRUE(record(ColorCoding::kJpeg));
  EXPECT_THAT(MatroskaRecorder::create(file_, ColorCoding::kJpeg).error().message,
              HasSubstr("exists already"));
  EXPECT_FALSE(MatroskaRecorder::create("/nowhere/x.mkv", ColorCoding::kJpeg));
}

TEST_F(MatroskaTest, RefusesWhatDoesNotBelongToIt) {
  auto recorder = MatroskaRecorder::create(file_, ColorCoding::kJpeg).value();
  EXPECT_THAT(recorder.finish().error().message, HasSubstr("no frames"));
  auto frame = internal::sample_frame(3);
  ASSERT_TRUE(recorder.add(frame));
  EXPECT_THAT(recorder.add(frame).error().message, HasSubstr("before the last"));
  frame = internal::sample_frame(4);
  frame.depth_mm = Image<std::uint16_t>(3, 3);
  EXPECT_THAT(recorder.add(frame).error().message, HasSubstr("size"));
  frame.calibration = nullptr;
  EXPECT_THAT(recorder.add(frame).error().message, HasSubstr("without calibration"));
}

}  // namespace
}  // namespace mor
