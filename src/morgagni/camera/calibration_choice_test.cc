// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Which calibration a device gets: its file's, the one known of it, or its design's.
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "morgagni/camera/calibration_json.h"
#include "morgagni/camera/internal/calibration_file.h"
#include "morgagni/camera/testing/sample_recording.h"
#include "morgagni/core/files.h"

namespace mor {
namespace {

using internal::choose_calibration;

RgbdCalibration with_focal(double focal_px) {
  auto calibration = *internal::sample_calibration();
  calibration.depth.focal_x_px = focal_px;
  return calibration;
}

TEST(CalibrationChoice, TakesWhatIsKnownOfADeviceWithAnId) {
  const auto design = with_focal(30.0);
  const KnownCalibration known =
      [](const std::string& id, const RgbdCalibration&) -> Result<std::optional<RgbdCalibration>> {
    if (id == "freenect-A1") return with_focal(31.0);
    return std::nullopt;
  };
  EXPECT_EQ(choose_calibration("", known, "freenect-A1", design)->depth.focal_x_px, 31.0);
  EXPECT_EQ(choose_calibration("", known, "freenect-B2", design)->depth.focal_x_px, 30.0);
  EXPECT_EQ(choose_calibration("", known, "", design)->depth.focal_x_px, 30.0);
  EXPECT_EQ(choose_calibration("", {}, "freenect-A1", design)->depth.focal_x_px, 30.0);
}

TEST(CalibrationChoice, TakesAFileBeforeWhatIsKnown) {
  const auto file =
      std::filesystem::temp_directory_path() / ("mor_choice_" + std::to_string(getpid()) + ".json");
  ASSERT_TRUE(write_file(file, calibration_to_json(with_focal(32.0))));
  const KnownCalibration known =
      [](const std::string&, const RgbdCalibration&) -> Result<std::optional<RgbdCalibration>> {
    return with_focal(31.0);
  };
  const auto chosen = choose_calibration(file.string(), known, "freenect-A1", with_focal(30.0));
  EXPECT_EQ(chosen->depth.focal_x_px, 32.0);
  EXPECT_EQ(chosen->origin, file.string());
  std::filesystem::remove(file);
  EXPECT_FALSE(choose_calibration(file.string(), known, "freenect-A1", with_focal(30.0)));
}

}  // namespace
}  // namespace mor
