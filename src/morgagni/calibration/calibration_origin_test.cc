// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/calibration_origin.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include "morgagni/calibration/calibration_store.h"
#include "morgagni/core/utc.h"

namespace mor {
namespace {

using std::chrono::hours;
using testing::HasSubstr;

const auto kNow = parse_utc("2026-11-26T16:00:00Z").value();

RgbdCalibration of(const std::string& origin) {
  RgbdCalibration calibration;
  calibration.origin = origin;
  return calibration;
}

TEST(CalibrationOrigin, SaysHowOneThatIsKeptWasFoundAndHowOldItIs) {
  auto kept = of("board, 2026-11-14T15:00:00Z");
  kept.depth_correction = std::make_shared<const DepthCorrection>();
  const auto origin = calibration_origin(kept, "freenect:", kNow);
  EXPECT_EQ(origin.source, "found with a board");
  EXPECT_EQ(origin.made_at, parse_utc("2026-11-14T15:00:00Z").value());
  EXPECT_EQ(origin.age, "12 days old");
  EXPECT_TRUE(origin.is_depth_corrected);
  EXPECT_EQ(origin.hint, "");
  EXPECT_EQ(calibration_origin(of("self-calibration on the CT skin, built on [board, "
                                  "2026-11-14T15:00:00Z], 2026-11-26T15:30:00Z"),
                               "push:1",
                               kNow)
                .source,
            "self-calibration on the CT skin, built on [board, 2026-11-14T15:00:00Z]");
}

TEST(CalibrationOrigin, UnderstandsWhatTheStoreWrites) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("mor_origin_" + std::to_string(getpid()));
  const CalibrationStore store(folder);
  KeptCalibration kept{.device_id = "a", .made_at = kNow - hours(72), .made_by = "board"};
  kept.calibration.depth = kept.calibration.color = {64, 48, 50.0, 50.0, 31.5, 23.5};
  ASSERT_TRUE(store.save(kept));
  const auto origin = calibration_origin(store.newest("a")->calibration, "v4l2:/dev/video0", kNow);
  EXPECT_EQ(origin.source, "found with a board");
  EXPECT_EQ(origin.age, "3 days old");
  std::filesystem::remove_all(folder);
}

TEST(CalibrationOrigin, HintsWhereADeviceHasNoneOrAnOldOne) {
  const auto hint = [](const char* origin, const char* camera) {
    return calibration_origin(of(origin), camera, kNow).hint;
  };
  EXPECT_THAT(hint("", "freenect:index=1"), HasSubstr("not calibrated"));
  EXPECT_THAT(hint("", "freenect:index=1"),
              HasSubstr("calibrate --camera freenect:index=1 --page"));
  EXPECT_THAT(hint("", "push:8765,token=geheim123"), testing::Not(HasSubstr("geheim")));
  EXPECT_THAT(hint("board, 2026-01-31T10:00:00Z", "openni2:"), HasSubstr("half a year old"));
  EXPECT_EQ(hint("board, 2026-08-31T10:00:00Z", "openni2:"), "");
  EXPECT_EQ(hint("mine.json", "openni2:"), "") << "no day is known";
  // What these saw by cannot be bettered any more.
  EXPECT_EQ(hint("", "simulated:"), "");
  EXPECT_EQ(hint("", "mcap:a.mcap"), "");
  EXPECT_EQ(hint("board, 2020-01-31T10:00:00Z", "tum:a"), "");
}

TEST(CalibrationOrigin, NamesAFileAndWhoSaysSoElse) {
  EXPECT_EQ(calibration_origin(of("my, own.json"), "freenect:", kNow).source, "my, own.json");
  EXPECT_EQ(calibration_origin(of(""), "freenect:", kNow).source, "the device's own word");
  EXPECT_EQ(calibration_origin(of(""), "simulated:seed=1", kNow).source, "the simulation's");
  EXPECT_EQ(calibration_origin(of(""), "tum:a", kNow).source, "the recording's");
}

}  // namespace
}  // namespace mor
