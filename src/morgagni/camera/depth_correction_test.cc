// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/depth_correction.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/camera/calibration_json.h"
#include "morgagni/camera/range_camera.h"
#include "morgagni/camera/testing/sample_recording.h"
#include "morgagni/geometry/depth_levels.h"

namespace mor {
namespace {

using testing::HasSubstr;

/// A grid of 3 x 2 with other numbers at each point, and a curve.
DepthCorrection uneven_correction() {
  DepthCorrection correction{.columns = 3, .rows = 2, .near_mm = 400.0, .far_mm = 2000.0};
  correction.control.clear();
  for (int i = 0; i < 6; ++i) {
    correction.control.push_back({1.0 / 3.0 + i, 0.001 * i - 0.002, 1e-6 * (i - 3)});
  }
  correction.curve = {{500.0, 1.0}, {900.0, -2.0 / 7.0}, {1500.0, 3.0}};
  return correction;
}

TEST(DepthCorrection, AddsItsPolynomialAndCurveBilinearlyOverThePicture) {
  const auto correction = uneven_correction();
  const auto at_point = [&](std::size_t i, double z) {
    const auto& c = correction.control[i];
    return c.c0_mm + c.c1 * z + c.c2_per_mm * z * z;
  };
  // The middle control point of the upper row lies on the middle column.
  EXPECT_NEAR(correction.add_mm({50.0, 0.0}, 101, 81, 900.0), at_point(1, 900.0) - 2.0 / 7.0, 1e-9);
  // A quarter of the way from the second to the third column, half way down, half way on the curve.
  const double above = 0.75 * at_point(1, 1200.0) + 0.25 * at_point(2, 1200.0);
  const double below = 0.75 * at_point(4, 1200.0) + 0.25 * at_point(5, 1200.0);
  const double on_curve = 0.5 * (3.0 - 2.0 / 7.0);
  EXPECT_NEAR(
      correction.add_mm({62.5, 40.0}, 101, 81, 1200.0), 0.5 * (above + below) + on_curve, 1e-9);
}

TEST(DepthCorrection, HoldsItsAmountWhereNothingWasMeasured) {
  const auto correction = uneven_correction();
  EXPECT_DOUBLE_EQ(correction.add_mm({10.0, 10.0}, 101, 81, 9000.0),
                   correction.add_mm({10.0, 10.0}, 101, 81, 2000.0));
  EXPECT_DOUBLE_EQ(correction.add_mm({10.0, 10.0}, 101, 81, 100.0),
                   correction.add_mm({10.0, 10.0}, 101, 81, 400.0));
}

TEST(DepthCorrection, KeepsFractionsOfAMillimetreInSmallMeans) {
  for (const double fraction : {0.0, 0.1, 0.25, 0.5, 2.0 / 3.0, 0.9}) {
    DepthCorrection correction;
    correction.control = {{.c0_mm = 2.0 + fraction}};
    const auto corrected = correction.apply(Image<std::uint16_t>(160, 120, 1000).view());
    double sum_mm = 0.0;
    double worst_mm = 0.0;
    for (int y = 1; y + 1 < 120; ++y) {
      for (int x = 1; x + 1 < 160; ++x) {
        double around_mm = 0.0;
        for (int k = 0; k < 9; ++k) around_mm += corrected(x + k % 3 - 1, y + k / 3 - 1) / 9.0;
        worst_mm = std::max(worst_mm, std::abs(around_mm - 1002.0 - fraction));
        sum_mm += corrected(x, y);
      }
    }
    EXPECT_LT(worst_mm, 0.15) << fraction;
    EXPECT_NEAR(sum_mm / (158.0 * 118.0), 1002.0 + fraction, 0.01) << fraction;
    // Every third pixel, as a coarse grid without means takes them.
    sum_mm = 0.0;
    for (int y = 0; y < 120; y += 3) {
      for (int x = 0; x < 160; x += 3) sum_mm += corrected(x, y);
    }
    EXPECT_NEAR(sum_mm / (40.0 * 54.0), 1002.0 + fraction, 0.03) << fraction;
  }
}

TEST(DepthCorrection, IsAppliedToAPictureAsItSays) {
  const auto correction = uneven_correction();
  Image<std::uint16_t> depth(101, 81);
  for (std::size_t i = 0; i < depth.size(); ++i) {
    depth.data()[i] = static_cast<std::uint16_t>(i % 11 == 0 ? 0 : 300 + i % 2200);
  }
  const auto corrected = correction.apply(depth.view());
  EXPECT_EQ(corrected, correction.apply(depth.view()));
  for (int y = 0; y < 81; ++y) {
    for (int x = 0; x < 101; ++x) {
      const double z_mm = depth(x, y);
      if (z_mm == 0.0) {
        ASSERT_EQ(corrected(x, y), 0);
        continue;
      }
      const double wanted_mm = z_mm + correction.add_mm(Eigen::Vector2d(x, y), 101, 81, z_mm);
      ASSERT_LT(std::abs(corrected(x, y) - wanted_mm), 1.001) << x << " " << y;
    }
  }
}

TEST(DepthCorrection, KeepsAReadingAReading) {
  DepthCorrection correction{.near_mm = 1.0, .far_mm = 65535.0};
  correction.control = {{.c1 = 0.4}};
  Image<std::uint16_t> depth(2, 1);
  depth(0, 0) = 65000;
  depth(1, 0) = 1;
  EXPECT_EQ(correction.apply(depth.view())(0, 0), 65535);
  correction.control = {{.c1 = -0.5}};
  EXPECT_GE(correction.apply(depth.view())(1, 0), 1);
}

TEST(DepthCorrection, SaysWhatIsWrongWithIt) {
  const auto message = [](auto change) {
    auto correction = uneven_correction();
    change(correction);
    const auto checked = correction.check();
    return checked ? std::string() : checked.error().message;
  };
  EXPECT_EQ(message([](auto&) {}), "");
  EXPECT_THAT(message([](auto& c) { c.columns = 65; }), HasSubstr("1..64 columns"));
  EXPECT_THAT(message([](auto& c) { c.rows = 0; }), HasSubstr("1..64 columns"));
  EXPECT_THAT(message([](auto& c) { c.control.pop_back(); }), HasSubstr("got 5"));
  EXPECT_THAT(message([](auto& c) { c.near_mm = 0.0; }), HasSubstr("near_mm >= 1"));
  EXPECT_THAT(message([](auto& c) { c.far_mm = c.near_mm; }), HasSubstr("far_mm"));
  EXPECT_THAT(message([](auto& c) { c.curve[1].z_mm = 500.0; }), HasSubstr("knot 1"));
  EXPECT_THAT(message([](auto& c) { c.curve[2].add_mm = NAN; }), HasSubstr("not finite"));
  EXPECT_THAT(message([](auto& c) { c.curve.resize(2000); }), HasSubstr("2000 knots"));
  EXPECT_THAT(message([](auto& c) { c.control[4].c1 = 0.6; }), HasSubstr("control point 4"));
  EXPECT_THAT(message([](auto& c) { c.control[4].c0_mm = NAN; }), HasSubstr("control point 4"));
}

TEST(DepthCorrection, KeepsEveryBitInJson) {
  auto calibration = *internal::sample_calibration();
  EXPECT_THAT(calibration_to_json(calibration), testing::Not(HasSubstr("depth_correction")));
  EXPECT_THAT(calibration_to_json(calibration), testing::Not(HasSubstr("depth_sd")));
  calibration.depth_sd = PinholeSd{.focal_ratio = 0.0013, .center_px = 0.3};
  EXPECT_NE(calibration, *internal::sample_calibration());
  calibration.depth_correction = std::make_shared<const DepthCorrection>(uneven_correction());
  const auto again = calibration_from_json(calibration_to_json(calibration));
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(*again, calibration);
  EXPECT_EQ(depth_correction_from_json(depth_correction_to_json(uneven_correction())).value(),
            uneven_correction());
}

TEST(CalibrationJson, RefusesAPinholeThatIsKnownTooWellOrNotAtAll) {
  const auto message = [](const PinholeSd& sd) {
    auto calibration = *internal::sample_calibration();
    calibration.depth_sd = sd;
    const auto parsed = calibration_from_json(calibration_to_json(calibration));
    return parsed ? std::string() : parsed.error().message;
  };
  EXPECT_EQ(message({.focal_ratio = 0.1, .center_px = 100.0}), "");
  EXPECT_THAT(message({.focal_ratio = 0.0, .center_px = 1.0}), HasSubstr("focal_ratio"));
  EXPECT_THAT(message({.focal_ratio = 0.2, .center_px = 1.0}), HasSubstr("got 0.2"));
  EXPECT_THAT(message({.focal_ratio = 0.001, .center_px = -1.0}), HasSubstr("center_px"));
}

TEST(DepthCorrection, SaysWhatIsWrongWithItsJson) {
  const auto message = [](const char* from, const char* to) {
    auto text = depth_correction_to_json(uneven_correction());
    text.replace(text.find(from), std::string_view(from).size(), to);
    const auto parsed = depth_correction_from_json(text);
    return parsed ? std::string() : parsed.error().message;
  };
  EXPECT_EQ(message("near", "near"), "");
  EXPECT_THAT(message("near_mm", "near"), HasSubstr("no near_mm"));
  EXPECT_THAT(message("\"columns\": 3", "\"columns\": 2"), HasSubstr("c0_mm must hold 4"));
  EXPECT_THAT(message("\"columns\": 3", "\"columns\": 2.5"), HasSubstr("columns"));
  EXPECT_THAT(message("c2_per_mm", "c2"), HasSubstr("c2_per_mm"));
  EXPECT_THAT(message("500.0", "\"a\""), HasSubstr("curve"));
  EXPECT_THAT(message("500.0", "5000.0"), HasSubstr("knot 1"));
  EXPECT_THAT(depth_correction_from_json("[1").error().message, HasSubstr("no JSON object"));
}

TEST(DepthCorrection, MakesAFrameThatRemembersWhatTheSensorGave) {
  const auto plain = std::make_shared<const RgbdFrame>(internal::sample_frame(3));
  DepthLevels levels;
  EXPECT_EQ(depth_corrected(plain, levels), plain);
  EXPECT_EQ(&as_sensed(*plain), plain.get());

  auto sensed = std::make_shared<RgbdFrame>(*plain);
  auto calibration = std::make_shared<RgbdCalibration>(*plain->calibration);
  DepthCorrection correction;
  correction.control = {{.c0_mm = 5.0}};
  calibration->depth_correction = std::make_shared<const DepthCorrection>(correction);
  sensed->calibration = calibration;
  const auto corrected = depth_corrected(sensed, levels);
  EXPECT_EQ(corrected->depth_mm, correction.apply(sensed->depth_mm.view()));
  EXPECT_EQ(&as_sensed(*corrected), sensed.get());
  EXPECT_EQ(corrected->color, sensed->color);
  EXPECT_EQ(corrected->device_time, sensed->device_time);
  EXPECT_EQ(corrected->captured_at, sensed->captured_at);
  EXPECT_EQ(corrected->frame_id, sensed->frame_id);
  EXPECT_EQ(depth_corrected(corrected, levels), corrected) << "never twice";
}

// A disparity sensor's steps, each rounded always alike: the correction must not carry that along.
TEST(DepthCorrection, CorrectsWhatTheSensorMeantBeforeItRounded) {
  constexpr double kPerStep = 345300.0;
  Image<double> meant_mm(640, 480);
  auto sensed = std::make_shared<RgbdFrame>();
  sensed->depth_mm = Image<std::uint16_t>(640, 480);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      meant_mm(x, y) = kPerStep / std::round(kPerStep / (700.0 + 0.5 * x));
      sensed->depth_mm(x, y) = static_cast<std::uint16_t>(std::lround(meant_mm(x, y)));
    }
  }
  auto calibration = std::make_shared<RgbdCalibration>();
  DepthCorrection correction;
  correction.control = {{.c0_mm = 5.0, .c1 = 0.01}};
  calibration->depth_correction = std::make_shared<const DepthCorrection>(correction);
  sensed->calibration = calibration;
  DepthLevels levels;
  const auto corrected = depth_corrected(sensed, levels);
  ASSERT_TRUE(levels.has_steps());
  double worst_mm = 0.0;
  double worst_rounded_mm = 0.0;
  for (int x = 0; x < 640; ++x) {
    double mean_mm = 0.0;
    for (int y = 0; y < 480; ++y) mean_mm += corrected->depth_mm(x, y) / 480.0;
    const auto should_be = [](double mm) { return 1.01 * mm + 5.0; };
    worst_mm = std::max(worst_mm, std::abs(mean_mm - should_be(meant_mm(x, 0))));
    worst_rounded_mm = std::max(
        worst_rounded_mm, std::abs(should_be(sensed->depth_mm(x, 0)) - should_be(meant_mm(x, 0))));
  }
  EXPECT_GT(worst_rounded_mm, 0.45) << "else this shows nothing";
  EXPECT_LT(worst_mm, 0.1);
}

}  // namespace
}  // namespace mor
