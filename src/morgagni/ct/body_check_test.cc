// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/body_check.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/ct/test_volumes.h"

namespace mor {
namespace {

/// A trunk along z with an ear on its right (x < 0); beside it an arm that does not touch it, on
/// its left, and a table behind.
Volume trunk_with_arm() {
  return make_volume(120, 1.0, [](const Eigen::Vector3d& place) {
    const double trunk = 25.0 - std::hypot(place.x(), place.y());
    const double arm = 8.0 - std::hypot(place.x() - 42.0, place.y());
    const Eigen::Vector3d from_ear = place - Eigen::Vector3d(-29, 0, 0);
    const double ear = 4.0 * (1.0 - from_ear.cwiseQuotient(Eigen::Vector3d(14, 4, 14)).norm());
    const double table = 1.5 - std::abs(place.y() - 30.0);
    return std::max({trunk, arm, ear, table});
  });
}

const BodyPart* part_at(const BodyCheck& check, const std::string& place, bool stands_out) {
  const auto found =
      std::find_if(check.parts().begin(), check.parts().end(), [&](const BodyPart& part) {
        return part.what.place == place && part.stands_out == stands_out;
      });
  return found == check.parts().end() ? nullptr : &*found;
}

TEST(BodyCheck, ListsWhatIsCutAndWhatStandsOut) {
  BodyCheck check(std::make_shared<const Volume>(trunk_with_arm()));
  ASSERT_TRUE(check.find({}));
  const auto* arm = part_at(check, "left of", false);
  const auto* table = part_at(check, "behind", false);
  const auto* ear = part_at(check, "right of", true);
  ASSERT_NE(arm, nullptr);
  ASSERT_NE(table, nullptr);
  ASSERT_NE(ear, nullptr);
  EXPECT_FALSE(arm->is_kept);
  EXPECT_FALSE(table->is_kept);
  EXPECT_TRUE(ear->is_kept);
  EXPECT_NEAR(arm->what.volume_ml, 3.1416 * 64 * 120 / 1000, 3.0);
  EXPECT_EQ(arm->what.marks_mm.size(), 5U);
}

TEST(BodyCheck, KeepsAnArmAndCutsAnEarWhenTold) {
  const auto volume = std::make_shared<const Volume>(trunk_with_arm());
  BodyCheck check(volume);
  ASSERT_TRUE(check.find({}));
  const double before_ml = check.body_ml();
  SkinOptions told;
  told.num_vertices = 1500;
  told.sub_sampling = 1;
  told.keep_mm = part_at(check, "left of", false)->what.marks_mm;
  told.cut_mm = part_at(check, "right of", true)->what.marks_mm;
  const double arm_ml = part_at(check, "left of", false)->what.volume_ml;
  const double ear_ml = part_at(check, "right of", true)->what.volume_ml;
  ASSERT_TRUE(check.find(told));
  EXPECT_NEAR(check.body_ml(), before_ml + arm_ml - ear_ml, 0.02 * before_ml);
  EXPECT_TRUE(part_at(check, "left of", false)->is_kept);
  EXPECT_FALSE(part_at(check, "right of", true)->is_kept);
  // The case is made with the same marks on all voxels.
  const auto skin = extract_skin(*volume, told, {});
  ASSERT_TRUE(skin) << skin.error().message;
  const auto bounds = skin->full.bounds();
  EXPECT_NEAR(bounds.max().x(), 50.0F, 1.0F) << "the arm";
  EXPECT_NEAR(bounds.min().x(), -26.0F, 1.5F) << "no ear";
  EXPECT_LT(bounds.max().y(), 28.0F) << "no table";
  for (const auto& cut : skin->preview.cut) EXPECT_NE(cut.place, "left of");
}

TEST(BodyCheck, PassesOverMarksThatASliderLeftInTheAir) {
  BodyCheck check(std::make_shared<const Volume>(trunk_with_arm()));
  SkinOptions told;
  told.keep_mm = {Eigen::Vector3d(-50, -50, 0)};
  EXPECT_TRUE(check.find(told));
  const auto refused = extract_skin(trunk_with_arm(), told, {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message,
              testing::HasSubstr("nothing to keep within 3 mm of (-50.0, -50.0, 0.0)"));
}

TEST(BodyCheck, StaysWithWhatItFoundWhenTheThresholdFindsNothing) {
  BodyCheck check(std::make_shared<const Volume>(trunk_with_arm()));
  ASSERT_TRUE(check.find({}));
  const auto num_parts = check.parts().size();
  SkinOptions nothing;
  nothing.threshold_hu = 2000.0;
  EXPECT_FALSE(check.find(nothing));
  EXPECT_EQ(check.parts().size(), num_parts);
}

/// The patient's right is on the left of the picture, the front above.
TEST(BodyCheck, HangsSlicesAsRadiologistsDo) {
  BodyCheck check(std::make_shared<const Volume>(trunk_with_arm()));
  ASSERT_TRUE(check.find({}));
  const auto is_colored = [](Rgb8 pixel) { return pixel.r != pixel.g || pixel.g != pixel.b; };
  const auto axial = check.slice(BodyPlane::kAxial, 0.5, 120);
  ASSERT_EQ(axial.width(), 120);
  EXPECT_TRUE(is_colored(axial(101, 60))) << "the arm, cut, on the patient's left";
  EXPECT_TRUE(is_colored(axial(60, 89))) << "the table behind";
  EXPECT_FALSE(is_colored(axial(60, 30)));
  EXPECT_FALSE(is_colored(axial(60, 60))) << "inside of the body";
  const auto sagittal = check.slice(BodyPlane::kSagittal, 0.5, 120);
  EXPECT_TRUE(is_colored(sagittal(89, 20))) << "the table is behind, on the right";
  EXPECT_FALSE(is_colored(sagittal(30, 20)));
}

TEST(BodyCheck, ShowsSkinAndPartsWhereTheyAre) {
  BodyCheck check(std::make_shared<const Volume>(trunk_with_arm()));
  ASSERT_TRUE(check.find({}));
  EXPECT_NEAR(check.skin().bounds().min().x(), -43.0F, 1.5F);
  for (std::size_t i = 0; i < check.parts().size(); ++i) {
    const auto box = check.part_surface(i).bounds();
    if (check.parts()[i].what.place == "left of") {
      EXPECT_NEAR(box.center().x(), 42.0F, 1.0F);
    }
  }
}

}  // namespace
}  // namespace mor
