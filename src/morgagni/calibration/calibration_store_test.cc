// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/calibration_store.h"

#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "morgagni/core/files.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using std::chrono::system_clock;
using testing::HasSubstr;

class CalibrationStoreTest : public testing::Test {
 protected:
  CalibrationStoreTest()
      : folder_(fs::temp_directory_path() / ("mor_store_" + std::to_string(getpid()))) {
    fs::remove_all(folder_);
  }
  ~CalibrationStoreTest() override { fs::remove_all(folder_); }

  static KeptCalibration kept(double focal_px, int day) {
    KeptCalibration one{.device_id = "freenect-A0036",
                        .made_at = system_clock::from_time_t(1'800'000'000 + 86400 * day),
                        .made_by = "board",
                        .figures = {{"held out", "0.2 px"}, {"a first", "1 mm"}},
                        .calibration = {}};
    one.calibration.depth = {64, 48, focal_px, focal_px, 31.5, 23.5};
    one.calibration.color = {80, 60, 70.0, 70.0, 39.5, 29.5};
    DepthCorrection correction;
    correction.control = {{.c0_mm = 1.5}};
    one.calibration.depth_correction = std::make_shared<const DepthCorrection>(correction);
    return one;
  }

  fs::path folder_;
  CalibrationStore store_{folder_};
};

TEST_F(CalibrationStoreTest, TakesBackWhatItKept) {
  for (const auto& folder : {folder_, folder_ / ""}) {
    const CalibrationStore store(folder);
    const auto file = store.save(kept(50.0, 3));
    ASSERT_TRUE(file);
    EXPECT_TRUE(store.take_back(*file)) << folder;
    EXPECT_FALSE(store.newest("freenect-A0036"));
  }
  EXPECT_FALSE(store_.take_back(folder_.parent_path() / "a" / "b.json"));
}

TEST_F(CalibrationStoreTest, GivesBackTheNewestOfADevice) {
  EXPECT_FALSE(store_.newest("freenect-A0036"));
  ASSERT_TRUE(store_.save(kept(50.0, 3)));
  ASSERT_TRUE(store_.save(kept(51.0, 2)));
  const auto found = store_.newest("freenect-A0036");
  ASSERT_TRUE(found);
  EXPECT_EQ(found->calibration.depth.focal_x_px, 50.0);
  EXPECT_EQ(found->calibration.origin, "board, 2027-01-18T08:00:00Z");
  EXPECT_EQ(found->made_at, kept(50.0, 3).made_at);
  EXPECT_EQ(found->figures, kept(50.0, 3).figures);
  EXPECT_EQ(*found->calibration.depth_correction, *kept(1.0, 0).calibration.depth_correction);
  EXPECT_FALSE(store_.newest("freenect-B0036"));
  EXPECT_EQ(store_.list().size(), 1U);
}

TEST_F(CalibrationStoreTest, KeepsTheOlderOnes) {
  const auto first = store_.save(kept(50.0, 3)).value();
  const auto second = store_.save(kept(52.0, 3)).value();
  EXPECT_NE(first, second);
  EXPECT_TRUE(fs::exists(first));
  EXPECT_EQ(store_.newest("freenect-A0036")->calibration.depth.focal_x_px, 52.0);
}

TEST_F(CalibrationStoreTest, PassesOverADamagedFile) {
  ASSERT_TRUE(store_.save(kept(50.0, 3)));
  const auto newer = store_.save(kept(51.0, 4)).value();
  ASSERT_TRUE(write_file(newer, "{\"device_id\": "));
  EXPECT_EQ(store_.newest("freenect-A0036")->calibration.depth.focal_x_px, 50.0);
}

TEST_F(CalibrationStoreTest, OffersItToTheCameraWhereTheSizesFit) {
  const auto known = store_.known();
  auto by_design = kept(47.0, 0).calibration;
  by_design.depth_correction = nullptr;
  EXPECT_FALSE(known("freenect-A0036", by_design).value());
  ASSERT_TRUE(store_.save(kept(50.0, 3)));
  const auto found = known("freenect-A0036", by_design).value();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->depth.focal_x_px, 50.0);
  by_design.color.width_px = 160;
  EXPECT_FALSE(known("freenect-A0036", by_design).value());
}

TEST_F(CalibrationStoreTest, RefusesAnIdThatIsNoPlainName) {
  for (const char* id : {"", "../x", "a/b", ".", "a b"}) {
    auto one = kept(50.0, 1);
    one.device_id = id;
    EXPECT_THAT(store_.save(one).error().message, HasSubstr("no device's id")) << id;
    EXPECT_FALSE(store_.newest(id));
  }
}

TEST_F(CalibrationStoreTest, SaysWhatIsWrongWithAFile) {
  const auto message = [](const std::string& from, const std::string& to) {
    auto text = to_json(kept(50.0, 3));
    text.replace(text.find(from), from.size(), to);
    const auto parsed = kept_calibration_from_json(text);
    return parsed ? std::string() : parsed.error().message;
  };
  EXPECT_EQ(message("made_at", "made_at"), "");
  EXPECT_THAT(message("made_at", "when"), HasSubstr("no text made_at"));
  EXPECT_THAT(message("2027-01-18T", "2027-01-18 "), HasSubstr("no time in UTC"));
  EXPECT_THAT(message("freenect-A0036", "/etc"), HasSubstr("no device's id"));
  EXPECT_THAT(message("\"calibration\"", "\"other\""), HasSubstr("no calibration"));
  EXPECT_THAT(message("\"fx\"", "\"f\""), HasSubstr("depth has no fx"));
}

TEST(CalibrationStore, LiesWhereTheEnvironmentSays) {
  ASSERT_EQ(setenv("MORGAGNI_CAMERAS_DIR", "/tmp/here", 1), 0);
  EXPECT_EQ(CalibrationStore::default_folder(), "/tmp/here");
  ASSERT_EQ(unsetenv("MORGAGNI_CAMERAS_DIR"), 0);
  ASSERT_EQ(setenv("XDG_DATA_HOME", "/tmp/data", 1), 0);
  EXPECT_EQ(CalibrationStore::default_folder(), "/tmp/data/morgagni/cameras");
}

TEST(CalibrationStore, SaysAnAge) {
  using std::chrono::hours;
  EXPECT_EQ(age_text(hours(0)), "less than an hour old");
  EXPECT_EQ(age_text(hours(1)), "1 hour old");
  EXPECT_EQ(age_text(hours(47)), "47 hours old");
  EXPECT_EQ(age_text(hours(100)), "4 days old");
}

}  // namespace
}  // namespace mor
