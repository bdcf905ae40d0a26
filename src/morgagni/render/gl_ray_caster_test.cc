// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The shader against the CPU's caster: the same picture, here with Mesa's software renderer as the
// device. Speed and drivers of GPUs are another matter.
#include <gtest/gtest.h>

#include "morgagni/render/testing/picture_difference.h"
#include "morgagni/render/testing/small_body.h"

namespace mor {
namespace {

constexpr PinholeCamera kCamera{161, 121, 148.0, 149.0, 80.5, 58.0, {-0.12, 0.04, 0.001, 0, 0}};

class GlRayCasterTest : public ::testing::TestWithParam<VolumePreset> {
 protected:
  static std::unique_ptr<OverlayRenderer> make(VolumeCaster caster) {
    auto renderer = OverlayRenderer::create(testing::small_body(), {.volume_caster = caster});
    if (!renderer) throw std::runtime_error(renderer.error().message);
    return *std::move(renderer);
  }

  static OverlayView view() {
    const auto [level_hu, window_hu] = volume_window(GetParam());
    return {.color_camera = kCamera,
            .color_from_ct = testing::small_body_pose(),
            .opacity = 1.0F,
            .structure_opacity = {{"ribs", 0.0F}, {"heart", 0.0F}, {"skin", 0.0F}},
            .volume = {GetParam(), level_hu, window_hu},
            .is_still = true};
  }

  void expect_same(const OverlayView& view) {
    static const auto kCpu = make(VolumeCaster::kCpu);
    static const auto kDevice = make(VolumeCaster::kOpenGl);
    const Image<Rgb8> color(kCamera.width_px, kCamera.height_px, Rgb8{150, 120, 100});
    const auto shown = testing::rendered(*kDevice, color, view);
    const auto off = testing::difference(without_alpha(shown),
                                         without_alpha(testing::rendered(*kCpu, color, view)));
    EXPECT_LT(off.mean, 0.25);
    EXPECT_LT(off.seen_share, 0.005);
    EXPECT_GT(testing::difference(without_alpha(shown), color).seen_share, 0.05) << "it is empty";
  }

  static Image<Rgb8> without_alpha(const Image<Rgba8>& picture) {
    Image<Rgb8> result(picture.width(), picture.height());
    for (std::size_t i = 0; i < picture.size(); ++i) {
      const Rgba8& pixel = picture.data()[i];
      result.data()[i] = {pixel.r, pixel.g, pixel.b};
    }
    return result;
  }
};

TEST_P(GlRayCasterTest, DrawsTheVolumeAsTheCpuDoes) {
  expect_same(view());
}

TEST_P(GlRayCasterTest, PutsStructuresAndTheHolesWallWhereTheCpuDoes) {
  OverlayView among = view();
  among.structure_opacity = {{"ribs", 0.5F}, {"heart", 1.0F}, {"skin", 0.2F}};
  expect_same(among);
}

TEST_P(GlRayCasterTest, CutsAtASliceAsTheCpuDoes) {
  OverlayView cut = view();
  cut.hole.radius = 2.0F;
  cut.slice.plane = SlicePlane::kSagittal;
  expect_same(cut);
}

TEST_P(GlRayCasterTest, TakesAsFewRaysAndAsCoarseVoxelsWhileThePictureMoves) {
  OverlayView moving = view();
  moving.color_camera = kCamera.scaled(4.0);
  moving.color_camera.width_px = 4 * kCamera.width_px;
  moving.color_camera.height_px = 4 * kCamera.height_px;
  moving.hole.radius = 2.0F;
  moving.is_still = false;
  static const auto kCpu = make(VolumeCaster::kCpu);
  static const auto kDevice = make(VolumeCaster::kOpenGl);
  const Image<Rgb8> color(
      moving.color_camera.width_px, moving.color_camera.height_px, Rgb8{150, 120, 100});
  const auto off = testing::difference(without_alpha(testing::rendered(*kDevice, color, moving)),
                                       without_alpha(testing::rendered(*kCpu, color, moving)));
  EXPECT_LT(off.mean, 0.25);
  EXPECT_LT(off.seen_share, 0.005);
}

INSTANTIATE_TEST_SUITE_P(Presets,
                         GlRayCasterTest,
                         ::testing::Values(VolumePreset::kBone,
                                           VolumePreset::kSoftTissue,
                                           VolumePreset::kLung,
                                           VolumePreset::kVessels,
                                           VolumePreset::kSkin),
                         [](const auto& info) {
                           std::string name(to_string(info.param));
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace mor
