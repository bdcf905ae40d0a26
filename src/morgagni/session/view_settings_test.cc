// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/view_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

using testing::HasSubstr;

ViewSettings with_bone() {
  ViewSettings view;
  view.structures = {{"bone", {true, 1.0F}}};
  view.has_ct = true;
  return view;
}

TEST(ViewSettings, ChangesOnlyWhatIsNamed) {
  const auto view = changed(with_bone(), R"({"opacity": 0.25, "structures": {"bone": false}})");
  ASSERT_TRUE(view) << view.error().message;
  EXPECT_FLOAT_EQ(view->opacity, 0.25F);
  EXPECT_FALSE(view->structures.at("bone").is_shown);
  EXPECT_FLOAT_EQ(view->hole.radius, with_bone().hole.radius);
}

TEST(ViewSettings, ReadsWhatItWrites) {
  ViewSettings view = with_bone();
  view.hole.center = {0.25F, 0.75F};
  const auto again = changed(with_bone(), to_json(view));
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(to_json(*again), to_json(view));
}

TEST(ViewSettings, APresetBringsItsOwnWindowUnlessOneIsNamed) {
  const auto bone = changed(with_bone(), R"({"volume": "bone"})");
  ASSERT_TRUE(bone) << bone.error().message;
  EXPECT_EQ(bone->volume.window_hu, volume_window(VolumePreset::kBone).window_hu);
  const auto narrow = changed(with_bone(), R"({"volume_window_hu": 50, "volume": "bone"})");
  ASSERT_TRUE(narrow) << narrow.error().message;
  EXPECT_EQ(narrow->volume.window_hu, 50.0F);
}

TEST(ViewSettings, ASliceCanBeInvertedButNotEmpty) {
  const auto inverted = changed(with_bone(), R"({"slice": "axial", "slice_window_hu": -400})");
  ASSERT_TRUE(inverted) << inverted.error().message;
  EXPECT_EQ(inverted->slice.plane, SlicePlane::kAxial);
  EXPECT_EQ(inverted->slice.window_hu, -400.0F);
  EXPECT_THAT(changed(with_bone(), R"({"slice_window_hu": 0})").error().message,
              HasSubstr("at least 1 HU"));
}

TEST(ViewSettings, ACaseWithoutVoxelsSaysSo) {
  ViewSettings view = with_bone();
  view.has_ct = false;
  EXPECT_TRUE(changed(view, R"({"slice": "none", "volume": "none"})"));
  for (const char* json : {R"({"slice": "coronal"})", R"({"volume": "lung"})"}) {
    EXPECT_THAT(changed(view, json).error().message, HasSubstr("prepare it again")) << json;
  }
}

TEST(ViewSettings, SaysWhatItDoesNotUnderstand) {
  const auto message = [](const char* json) { return changed(with_bone(), json).error().message; };
  EXPECT_THAT(message("{"), HasSubstr("JSON object"));
  EXPECT_THAT(message("[]"), HasSubstr("JSON object"));
  EXPECT_THAT(message(R"({"opacity": 2})"), HasSubstr("from 0 to 1, got 2"));
  EXPECT_THAT(message(R"({"opacity": "much"})"), HasSubstr("got \"much\""));
  EXPECT_THAT(message(R"({"slice": "oblique"})"), HasSubstr("got \"oblique\""));
  EXPECT_THAT(message(R"({"volume": 3})"), HasSubstr("got 3"));
  EXPECT_THAT(message(R"({"volume": "bone", "volume_window_hu": -1})"), HasSubstr("from 1 to"));
  EXPECT_THAT(message(R"({"structure_opacity": {"bone": 1.5}})"), HasSubstr("from 0 to 1"));
  EXPECT_THAT(message(R"({"hands_in_front": 1})"), HasSubstr("true or false"));
  EXPECT_THAT(message(R"({"outlines": "all"})"), HasSubstr("outlines must be true or false"));
  EXPECT_THAT(message(R"({"zoom": 2})"), HasSubstr("no member \"zoom\""));
  EXPECT_THAT(message(R"({"structures": {"liver": true}})"), HasSubstr("no structure \"liver\""));
}

TEST(ViewSettings, TheFreeViewIsReadBackAsItWasSaid) {
  const auto view = changed({}, R"({"picture": "free", "free_yaw": -1.5, "free_pitch": 0.25,
      "free_zoom": 4, "free_target_mm": [10, -20, 30.5], "free_hole": true, "free_bare_skin": true,
      "free_colors": "fused"})");
  ASSERT_TRUE(view) << view.error().message;
  EXPECT_TRUE(view->free.is_shown);
  EXPECT_TRUE(view->free.wears_fused);
  EXPECT_EQ(view->free.target_mm, Eigen::Vector3d(10, -20, 30.5));
  const auto again = changed({}, to_json(*view));
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(to_json(*again), to_json(*view));
}

TEST(ViewSettings, RefusesAFreeViewThatIsNone) {
  const auto why = [](const std::string& json) {
    const auto view = changed({}, json);
    return view ? std::string("taken") : view.error().message;
  };
  EXPECT_THAT(why(R"({"picture": "side"})"),
              HasSubstr("picture must be camera or free, got \"side\""));
  EXPECT_THAT(why(R"({"free_pitch": 2})"),
              HasSubstr("free_pitch must be a number from -1.5708 to 1.5708"));
  EXPECT_THAT(why(R"({"free_zoom": 0})"),
              HasSubstr("free_zoom must be a number from 0.3 to 20, got 0"));
  EXPECT_THAT(why(R"({"free_target_mm": [1, 2]})"),
              HasSubstr("free_target_mm must be three numbers"));
  EXPECT_THAT(why(R"({"free_target_mm": [1, 2, 1e9]})"), HasSubstr("from -3000 to 3000"));
  EXPECT_THAT(why(R"({"free_colors": "red"})"), HasSubstr("free_colors must be live or fused"));
  EXPECT_THAT(why(R"({"free_hole": 1})"), HasSubstr("free_hole must be true or false"));
}

}  // namespace
}  // namespace mor
