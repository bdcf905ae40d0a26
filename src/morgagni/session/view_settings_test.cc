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
  view.structures = {{"bone", true}};
  return view;
}

TEST(ViewSettings, ChangesOnlyWhatIsNamed) {
  const auto view = changed(with_bone(), R"({"opacity": 0.25, "structures": {"bone": false}})");
  ASSERT_TRUE(view) << view.error().message;
  EXPECT_FLOAT_EQ(view->opacity, 0.25F);
  EXPECT_FALSE(view->structures.at("bone"));
  EXPECT_FLOAT_EQ(view->hole.radius, with_bone().hole.radius);
}

TEST(ViewSettings, ReadsWhatItWrites) {
  ViewSettings view = with_bone();
  view.hole.center = {0.25F, 0.75F};
  const auto again = changed(with_bone(), to_json(view));
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(to_json(*again), to_json(view));
}

TEST(ViewSettings, SaysWhatItDoesNotUnderstand) {
  const auto message = [](const char* json) { return changed(with_bone(), json).error().message; };
  EXPECT_THAT(message("{"), HasSubstr("JSON object"));
  EXPECT_THAT(message("[]"), HasSubstr("JSON object"));
  EXPECT_THAT(message(R"({"opacity": 2})"), HasSubstr("from 0 to 1, got 2"));
  EXPECT_THAT(message(R"({"opacity": "much"})"), HasSubstr("got \"much\""));
  EXPECT_THAT(message(R"({"zoom": 2})"), HasSubstr("no member \"zoom\""));
  EXPECT_THAT(message(R"({"structures": {"liver": true}})"), HasSubstr("no structure \"liver\""));
}

}  // namespace
}  // namespace mor
