// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Every mode as it looked when somebody last judged it (testdata/render). After a wanted change:
// MORGAGNI_WRITE_GOLDEN=1 render_golden_pictures_test, look at the pictures, commit.
#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/render/overlay_renderer.h"
#include "morgagni/render/testing/golden_picture.h"
#include "morgagni/render/testing/small_body.h"

namespace mor {
namespace {

constexpr PinholeCamera kCamera{160, 120, 148.0, 149.0, 80.5, 58.0, {-0.12, 0.04, 0.001, 0, 0}};

Image<Rgb8> table() {
  Image<Rgb8> picture(kCamera.width_px, kCamera.height_px);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const int shade = y / 4;
      picture(x, y) = {static_cast<std::uint8_t>(150 + shade),
                       static_cast<std::uint8_t>(118 + shade),
                       static_cast<std::uint8_t>(98 + shade)};
    }
  }
  return picture;
}

/// A hand's breadth in front of the left of the body; blue in the picture.
struct Hand {
  Image<Rgb8> color = table();
  Image<std::uint16_t> depth{kCamera.width_px, kCamera.height_px, 260};

  Hand() {
    for (int y = 30; y < 120; ++y) {
      for (int x = 40; x < 75; ++x) {
        color(x, y) = {40, 60, 130};
        depth(x, y) = 110;
      }
    }
  }
};

struct Mode {
  std::string name;
  std::function<void(OverlayView&)> set;
  bool has_hand = false;
};

void show_volume(OverlayView& view, VolumePreset preset) {
  const auto [level_hu, window_hu] = volume_window(preset);
  view.volume = {preset, level_hu, window_hu};
  view.structure_opacity = {{"ribs", 0.0F}, {"heart", 0.0F}, {"skin", 0.0F}};
}

std::vector<Mode> modes() {
  std::vector<Mode> modes = {
      {"surfaces", [](OverlayView&) {}},
      {"surfaces-everywhere", [](OverlayView& view) { view.hole.radius = 2.0F; }},
      {"glass",
       [](OverlayView& view) {
         view.hole.radius = 2.0F;
         view.structure_opacity = {{"skin", 0.25F}, {"ribs", 0.6F}, {"heart", 0.8F}};
       }},
      {"outlines",
       [](OverlayView& view) {
         view.hole.radius = 0.22F;
         view.has_outlines = true;
       }},
      {"outlines-behind-slice",
       [](OverlayView& view) {
         view.slice = {.plane = SlicePlane::kCamera, .depth_mm = 18.0F, .cuts = false};
         view.has_outlines = true;
       }},
      {"hand", [](OverlayView&) {}, true},
      {"ghost",
       [](OverlayView& view) { view.color_from_ghost = std::exchange(view.color_from_ct, {}); }},
      {"slice-axial", [](OverlayView& view) { view.slice.plane = SlicePlane::kAxial; }},
      {"slice-coronal", [](OverlayView& view) { view.slice.plane = SlicePlane::kCoronal; }},
      {"slice-sagittal",
       [](OverlayView& view) {
         view.slice.plane = SlicePlane::kSagittal;
         view.slice.position = 0.3F;
       }},
      {"slice-inverted",
       [](OverlayView& view) {
         view.slice = {.plane = SlicePlane::kCamera, .window_hu = -400.0F};
       }},
      {"volume-bone-moving",
       [](OverlayView& view) {
         show_volume(view, VolumePreset::kBone);
         view.is_still = false;
       }},
      {"volume-and-slice", [](OverlayView& view) {
         show_volume(view, VolumePreset::kBone);
         view.slice.plane = SlicePlane::kCoronal;
       }}};
  for (const VolumePreset preset : kVolumePresets) {
    if (preset == VolumePreset::kNone) continue;
    modes.push_back({"volume-" + std::string(to_string(preset)),
                     [preset](OverlayView& view) { show_volume(view, preset); }});
  }
  return modes;
}

class GoldenPictures : public ::testing::TestWithParam<Mode> {
 public:
  static Image<Rgb8> drawn(const Mode& mode) {
    static const auto kRenderer = testing::make_renderer(testing::small_body());
    OverlayView view{.color_camera = kCamera,
                     .color_from_ct = testing::small_body_pose(),
                     .opacity = 0.9F,
                     .hole = {.radius = 0.36F},
                     .structure_opacity = {{"skin", 0.0F}},
                     .is_still = true};
    mode.set(view);
    static const Hand kHand;
    static const Image<Rgb8> kTable = table();
    PinholeCamera depth_camera = kCamera;
    depth_camera.distortion = {};
    if (mode.has_hand) {
      view.measured =
          MeasuredDepth{kHand.depth.view(), depth_camera, Eigen::Isometry3d::Identity()};
    }
    return testing::without_alpha(
        testing::rendered(*kRenderer, mode.has_hand ? kHand.color : kTable, view).view());
  }
};

TEST_P(GoldenPictures, LooksAsItDid) {
  testing::expect_golden(GetParam().name, drawn(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(Modes, GoldenPictures, ::testing::ValuesIn(modes()), [](const auto& each) {
  std::string name = each.param.name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

/// What a fault would do to a picture, and what another driver would.
class PictureDifferenceTest : public ::testing::Test {
 protected:
  static testing::PictureDifference to_surfaces(const std::function<void(OverlayView&)>& change) {
    return testing::difference(GoldenPictures::drawn({"", change}),
                               GoldenPictures::drawn({"", [](OverlayView&) {}}));
  }
};

TEST_F(PictureDifferenceTest, SeesAMoveOfTwoPixels) {
  const double two_px_mm = 2.0 * 150.0 / 148.0;
  EXPECT_FALSE(to_surfaces([&](OverlayView& view) {
                 view.color_from_ct->translation().x() += two_px_mm;
               }).is_same());
}

TEST_F(PictureDifferenceTest, SeesATenthOfTheOpacity) {
  EXPECT_FALSE(to_surfaces([](OverlayView& view) { view.opacity = 0.8F; }).is_same());
}

TEST_F(PictureDifferenceTest, SeesAMissingStructureAndAMissingRim) {
  EXPECT_FALSE(
      to_surfaces([](OverlayView& view) { view.structure_opacity["heart"] = 0.0F; }).is_same());
  EXPECT_FALSE(to_surfaces([](OverlayView& view) { view.hole.rim = 0.0F; }).is_same());
}

TEST_F(PictureDifferenceTest, SeesNoRounding) {
  const Image<Rgb8> picture = GoldenPictures::drawn({"", [](OverlayView&) {}});
  Image<Rgb8> rounded = picture;
  for (std::size_t i = 0; i < rounded.size(); i += 2) rounded.data()[i].g ^= 1U;
  EXPECT_TRUE(testing::difference(picture, rounded).is_same());
}

}  // namespace
}  // namespace mor
