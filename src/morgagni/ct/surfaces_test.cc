// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/surfaces.h"

#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/ct/mesh_quality.h"
#include "morgagni/ct/test_volumes.h"

namespace mor {
namespace {

constexpr SkinOptions kQuick = {.num_vertices = 1500, .sub_sampling = 1};

double body_depth_mm(const Eigen::Vector3d& place) {
  return 20.0 - std::hypot(place.x(), place.y());
}

/// A trunk along z with a lung in it, on a curved shell that is wider than it, as a CT table is.
Volume trunk_on_table() {
  return make_volume(100, 1.0, [](const Eigen::Vector3d& place) {
    const double lung = 10.0 - (place - Eigen::Vector3d(5, 0, -45)).norm();
    const double sideways = std::abs(place.x()) - 45.0;
    const double table =
        std::min(1.5 - std::abs(place.y() - 21.0 + 0.004 * place.x() * place.x()), -sideways);
    return std::max(std::min(body_depth_mm(place), -lung), table);
  });
}

TEST(ExtractSkin, DropsTheTableAndFillsTheLung) {
  const auto skin = extract_skin(trunk_on_table(), kQuick, {});
  ASSERT_TRUE(skin) << skin.error().message;
  int num_far = 0;
  for (const auto& vertex : skin->full.vertices) {
    const double radius_mm = std::hypot(vertex.x(), vertex.y());
    EXPECT_GT(radius_mm, 19.0) << "no surface inside";
    if (radius_mm > 24.0) ++num_far;
    const bool at_table = vertex.y() > 10.0F;
    if (!at_table) {
      EXPECT_NEAR(radius_mm, 19.83, 0.5);
    }
  }
  EXPECT_EQ(num_far, 0) << "of " << skin->full.vertices.size() << " vertices are table";
}

/// A trunk under a blanket, a tube along its side, a mattress' cover behind, an ear that stands
/// out.
TEST(ExtractSkin, DropsBlanketTubeAndCoverButNoEar) {
  const auto ear_mm = [](const Eigen::Vector3d& place) {
    const Eigen::Vector3d from = place - Eigen::Vector3d(-33, 0, 0);
    return 1.0 - from.cwiseQuotient(Eigen::Vector3d(16, 4, 16)).norm();
  };
  const auto volume = make_volume(120, 1.0, [&](const Eigen::Vector3d& place) {
    const double radius_mm = std::hypot(place.x(), place.y());
    const double blanket =
        place.y() < -8.0 ? 1.2 - std::abs(radius_mm - 31.0 - 0.1 * std::abs(place.x())) : -5.0;
    const double tube = 4.0 - std::hypot(place.x() - 33.0, place.y() + 3.0);
    const double cover = 1.0 - std::abs(place.y() - 30.5);
    return std::max({30.0 - radius_mm, 4.0 * ear_mm(place), blanket, tube, cover});
  });
  const auto skin = extract_skin(volume, kQuick, {});
  ASSERT_TRUE(skin) << skin.error().message;
  std::vector<double> errors_mm;
  float ear_reach_mm = 0.0F;
  for (const auto& vertex : skin->full.vertices) {
    ear_reach_mm = std::max(ear_reach_mm, -vertex.x());
    const bool at_ear = vertex.x() < -20.0F && std::abs(vertex.y()) < 12.0F;
    if (!at_ear) errors_mm.push_back(std::abs(std::hypot(vertex.x(), vertex.y()) - 29.83));
  }
  std::sort(errors_mm.begin(), errors_mm.end());
  // As dense as flesh and lying on half of the front, the blanket lifts the skin a little.
  EXPECT_LT(errors_mm[errors_mm.size() / 2], 0.1);
  EXPECT_LT(errors_mm[errors_mm.size() * 9 / 10], 1.4);
  EXPECT_LT(errors_mm.back(), 2.5);
  EXPECT_GT(ear_reach_mm, 46.0F);
  ASSERT_GE(skin->preview.cut.size(), 3U) << "blanket, tube and cover";
  EXPECT_EQ(skin->preview.cut[0].place, "in front of");
}

/// A trunk with fat beneath its skin; over its front half lies cloth.
Volume trunk_in_cloth(double cloth_mm, double cloth_hu) {
  Volume volume = make_volume(120, 0.9, [](const Eigen::Vector3d& place) {
    return 40.0 - std::hypot(place.x(), place.y());
  });
  for (int z = 0; z < volume.size[2]; ++z) {
    for (int y = 0; y < volume.size[1]; ++y) {
      for (int x = 0; x < volume.size[0]; ++x) {
        const Eigen::Vector3d place = volume.ct_from_grid * (0.9 * Eigen::Vector3d(x, y, z));
        const double depth_mm = 40.0 - std::hypot(place.x(), place.y());
        auto& hu = volume.hu[volume.index(x, y, z)];
        if (depth_mm > 3.0 && depth_mm < 9.0) hu = -90;
        if (place.y() > -10.0) continue;
        const double over = std::clamp((depth_mm + cloth_mm) / 0.9 + 0.5, 0.0, 1.0);
        const double air = std::clamp(0.5 - depth_mm / 0.9, 0.0, 1.0);
        hu = static_cast<std::int16_t>(std::lround(hu + over * air * (cloth_hu + 1000.0)));
      }
    }
  }
  return volume;
}

TEST(ExtractSkin, TakesClothOffAndSaysWhereItLay) {
  constexpr double kSkinMm = 39.84;  // -300 HU lie a sixth of a voxel outside of the middle.
  const auto skin = extract_skin(trunk_in_cloth(2.4, -180.0), kQuick, {});
  ASSERT_TRUE(skin) << skin.error().message;
  std::vector<double> errors_mm;
  for (const auto& vertex : skin->full.vertices)
    errors_mm.push_back(std::abs(std::hypot(vertex.x(), vertex.y()) - kSkinMm));
  std::sort(errors_mm.begin(), errors_mm.end());
  EXPECT_LT(errors_mm[errors_mm.size() / 2], 0.2);
  EXPECT_LT(errors_mm[errors_mm.size() * 95 / 100], 1.0) << "the cloth is 2.4 mm thick";
  ASSERT_FALSE(skin->preview.doubts.empty());
  const auto& doubt = skin->preview.doubts.front();
  EXPECT_EQ(doubt.why, SkinDoubt::Why::kLayerTaken);
  EXPECT_EQ(doubt.place, "front");
  const double covered_cm2 = 2.0 * 40.0 * std::acos(10.0 / 40.0) * 108.0 / 100.0;
  EXPECT_NEAR(doubt.area_cm2, covered_cm2, 0.2 * covered_cm2);
  EXPECT_LT(doubt.middle_mm.y(), -10.0);
}

/// A shell that comes down to a trunk of 30 mm from both sides; `out_mm` is along its middle.
double shell_mm(double out_mm, double across_mm, double lifted_mm) {
  const double middle_mm = 31.2 + lifted_mm - (0.011 + 0.0025 * lifted_mm) * across_mm * across_mm;
  return std::min(1.3 - std::abs(out_mm - middle_mm), out_mm - 5.0);
}

/// A trunk with a shell behind it that has its HU.
Volume trunk_on_shell() {
  return make_volume(120, 0.9, [](const Eigen::Vector3d& place) {
    const double trunk = 30.0 - std::hypot(place.x(), place.y());
    return std::max(trunk, shell_mm(place.y(), place.x(), 0.0));
  });
}

/// Another over that, which hides it, and one in front.
Volume trunk_in_three_shells() {
  return make_volume(120, 0.9, [](const Eigen::Vector3d& place) {
    const double trunk = 30.0 - std::hypot(place.x(), place.y());
    return std::max({trunk,
                     shell_mm(place.y(), place.x(), 0.0),
                     shell_mm(place.y(), place.x(), 14.0),
                     shell_mm(-place.y(), place.x(), 0.0)});
  });
}

TEST(ExtractSkin, TakesALayerOffWhereAskedTo) {
  const auto volume = trunk_on_shell();
  auto options = kQuick;
  const auto farthest_mm = [&](const SkinSurfaces& skin) {
    float most = 0.0F;
    for (const auto& vertex : skin.full.vertices)
      if (std::abs(vertex.x()) < 5.0F) most = std::max(most, vertex.y());
    return most;
  };
  const auto layer_left = [](const SkinSurfaces& skin) -> std::optional<Eigen::Vector3d> {
    for (const auto& doubt : skin.preview.doubts)
      if (doubt.why == SkinDoubt::Why::kLayerLeft && doubt.middle_mm.y() > 20.0)
        return doubt.middle_mm;
    return std::nullopt;
  };
  auto skin = extract_skin(volume, options, {});
  ASSERT_TRUE(skin) << skin.error().message;
  EXPECT_GT(farthest_mm(*skin), 31.5F);
  // It lies on the skin farther than it is told at once: from both sides.
  for (int ask = 0; ask < 3; ++ask) {
    const auto place = layer_left(*skin);
    if (!place) break;
    options.take_off_mm.push_back(*place);
    skin = extract_skin(volume, options, {});
    ASSERT_TRUE(skin) << skin.error().message;
  }
  EXPECT_FALSE(options.take_off_mm.empty());
  EXPECT_LT(farthest_mm(*skin), 30.6F);
  const auto& doubts = skin->preview.doubts;
  EXPECT_TRUE(std::any_of(doubts.begin(), doubts.end(), [](const SkinDoubt& doubt) {
    return doubt.why == SkinDoubt::Why::kTakenOff;
  }));
  options.take_off_mm = {Eigen::Vector3d(0.0, -30.0, -50.0)};
  const auto nothing = extract_skin(volume, options, {});
  ASSERT_FALSE(nothing);
  EXPECT_NE(nothing.error().message.find("no thin layer to take off near (0.0, -30.0, -50.0)"),
            std::string::npos);
}

TEST(ExtractSkin, TakesALayerOffThatLiesBeneathAnother) {
  const auto volume = trunk_in_three_shells();
  auto options = kQuick;
  auto skin = extract_skin(volume, options, {});
  ASSERT_TRUE(skin) << skin.error().message;
  for (int ask = 0; ask < 3; ++ask) {
    for (const auto& doubt : skin->preview.doubts)
      if (doubt.why == SkinDoubt::Why::kLayerLeft) options.take_off_mm.push_back(doubt.middle_mm);
    skin = extract_skin(volume, options, {});
    ASSERT_TRUE(skin) << skin.error().message;
  }
  float most_off_mm = 0.0F;
  for (const auto& vertex : skin->full.vertices)
    if (std::abs(vertex.x()) < 5.0F) most_off_mm = std::max(most_off_mm, std::abs(vertex.y()));
  EXPECT_LT(most_off_mm, 30.6F) << "the shells are 2.6 mm thick";
}

TEST(ExtractSkin, IsCertainOfABareBody) {
  const auto skin = extract_skin(trunk_in_cloth(0.0, -1000.0), kQuick, {});
  ASSERT_TRUE(skin) << skin.error().message;
  EXPECT_TRUE(skin->preview.doubts.empty());
}

/// A trunk of flesh in which a layer of light stuff begins `skin_mm` beneath the surface on one
/// side.
Volume trunk_with_light_layer(double skin_mm) {
  auto volume = make_volume(100, 1.0, [](const Eigen::Vector3d& place) {
    return 40.0 - std::hypot(place.x(), place.y());
  });
  for (int z = 0; z < volume.size[2]; ++z) {
    for (int y = 0; y < volume.size[1]; ++y) {
      for (int x = 0; x < volume.size[0]; ++x) {
        const Eigen::Vector3d place = volume.ct_from_grid * Eigen::Vector3d(x, y, z);
        const double depth_mm = 40.0 - std::hypot(place.x(), place.y());
        const int noise_hu = (x * 31 + y * 17 + z * 7) % 80 - 40;
        if (depth_mm > skin_mm && depth_mm < 15.0 && place.x() > 0.0)
          volume.hu[volume.index(x, y, z)] = static_cast<std::int16_t>(-270 + noise_hu);
      }
    }
  }
  return volume;
}

/// Gas in the fat of a dead body has skin over it; a folded blanket has not.
TEST(ExtractSkin, TellsGasInTheFatFromABlanket) {
  const auto reach_mm = [](const Volume& volume) {
    float farthest = 0.0F;
    const auto skin = extract_skin(volume, kQuick, {}).value();
    for (const auto& vertex : skin.full.vertices)
      if (std::abs(vertex.y()) < 10.0F) farthest = std::max(farthest, vertex.x());
    return farthest;
  };
  EXPECT_NEAR(reach_mm(trunk_with_light_layer(2.5)), 39.83, 0.3);
  EXPECT_NEAR(reach_mm(trunk_with_light_layer(-1.0)), 25.0, 1.5);
}

/// Where cloth touches it, the skin lies where it lies bare: to a part of a voxel.
TEST(ExtractSkin, PutsTheSkinUnderABlanketWhereItLiesBare) {
  constexpr double kSkinMm = 30.0;
  for (const double cloth_hu : {-400.0, -250.0, -150.0, 500.0}) {
    auto volume = make_volume(100, 1.0, [](const Eigen::Vector3d& place) {
      return kSkinMm - std::hypot(place.x(), place.y());
    });
    for (int z = 0; z < volume.size[2]; ++z) {
      for (int y = 0; y < volume.size[1]; ++y) {
        for (int x = 0; x < volume.size[0]; ++x) {
          const Eigen::Vector3d place = volume.ct_from_grid * Eigen::Vector3d(x, y, z);
          const double beneath_mm = 42.0 - std::hypot(place.x(), place.y());
          const double cloth = std::clamp(std::min(beneath_mm, place.x()) + 0.5, 0.0, 1.0);
          auto& hu = volume.hu[volume.index(x, y, z)];
          const double air = (kTissueHu - hu) / static_cast<double>(kTissueHu - kAirHu);
          hu = static_cast<std::int16_t>(std::lround(hu + cloth * air * (cloth_hu - kAirHu)));
        }
      }
    }
    const auto skin = extract_skin(volume, kQuick, {});
    ASSERT_TRUE(skin) << skin.error().message;
    std::vector<double> errors_mm;
    for (const auto& vertex : skin->full.vertices)
      errors_mm.push_back(std::abs(std::hypot(vertex.x(), vertex.y()) - (kSkinMm - 0.17)));
    std::sort(errors_mm.begin(), errors_mm.end());
    EXPECT_LT(errors_mm[errors_mm.size() / 2], 0.15) << cloth_hu << " HU";
    EXPECT_LT(errors_mm[errors_mm.size() * 99 / 100], 0.6) << cloth_hu << " HU";
    EXPECT_LT(errors_mm.back(), 2.0) << cloth_hu << " HU";
  }
}

TEST(PreviewBody, ShowsWhatIsCutInRed) {
  const auto body = preview_body(trunk_on_table(), kQuick, {});
  ASSERT_TRUE(body) << body.error().message;
  ASSERT_EQ(body->cut.size(), 2U) << "the table's two sides";
  for (const auto& part : body->cut) {
    EXPECT_NEAR(part.size_mm.x(), 45.0, 5.0);
    EXPECT_NEAR(part.size_mm.z(), 100.0, 1.0);
    EXPECT_THAT(part.place, testing::AnyOf("left of", "right of"));
  }
  int num_red = 0;
  int num_green = 0;
  for (int y = 0; y < body->picture.height(); ++y) {
    for (int x = 0; x < body->picture.width(); ++x) {
      const Rgb8 pixel = body->picture(x, y);
      if (pixel.r > 2 * pixel.g && pixel.r > 100) ++num_red;
      if (pixel.g > 2 * pixel.r) ++num_green;
    }
  }
  EXPECT_GT(num_red, 2000);
  EXPECT_GT(num_green, 500);
}

TEST(ExtractSkin, PutsVerticesOnTheThreshold) {
  const auto volume = make_volume(80, 1.0, [](const auto& place) { return 25.0 - place.norm(); });
  const auto skin = extract_skin(volume, kQuick, {});
  ASSERT_TRUE(skin);
  // -300 HU lies 0.17 of a voxel inside of half way.
  for (const auto& vertex : skin->full.vertices) EXPECT_NEAR(vertex.norm(), 24.83, 0.2);
  EXPECT_GT(enclosed_volume_mm3(skin->remeshed), 0.0);
  EXPECT_EQ(mesh_topology(skin->remeshed).num_open_edges, 0);
}

TEST(ExtractSkin, ReportsEveryStageUpToItsEnd) {
  std::map<std::string, double, std::less<>> last;
  const auto volume = make_volume(60, 1.0, [](const auto& place) { return 20.0 - place.norm(); });
  ASSERT_TRUE(extract_skin(volume, kQuick, [&](std::string_view stage, double fraction) {
    EXPECT_GE(fraction, last.emplace(stage, 0.0).first->second) << stage;
    last.find(stage)->second = fraction;
  }));
  EXPECT_THAT(last,
              testing::UnorderedElementsAre(testing::Pair("covers", 1.0),
                                            testing::Pair("threshold", 1.0),
                                            testing::Pair("closing", 1.0),
                                            testing::Pair("body", 1.0),
                                            testing::Pair("surface", 1.0),
                                            testing::Pair("remesh", 1.0)));
}

TEST(ExtractSkin, SaysWhatToDoWhenThereIsNothing) {
  const auto air = make_volume(20, 1.0, [](const auto&) { return -10.0; });
  const auto nothing = extract_skin(air, kQuick, {});
  ASSERT_FALSE(nothing);
  EXPECT_THAT(nothing.error().message, testing::HasSubstr("no voxel lies between -300 and 3071"));

  const auto tissue = make_volume(20, 1.0, [](const auto&) { return 10.0; });
  const auto no_air = extract_skin(tissue, kQuick, {});
  ASSERT_FALSE(no_air);
  EXPECT_THAT(no_air.error().message, testing::HasSubstr("no air around the body"));
}

TEST(ExtractSkin, RefusesAirThatIsOnlyInside) {
  const auto volume = make_volume(40, 1.0, [](const auto& place) { return place.norm() - 10.0; });
  const auto skin = extract_skin(volume, kQuick, {});
  ASSERT_FALSE(skin);
  EXPECT_THAT(skin.error().message, testing::HasSubstr("no air around the body"));
}

TEST(SkinOptions, NameTheValueAndTheLimit) {
  const auto message = [](const SkinOptions& options) {
    const auto checked = options.check();
    return checked ? std::string() : checked.error().message;
  };
  EXPECT_EQ(message({}), "");
  EXPECT_THAT(message({.threshold_hu = NAN}), testing::HasSubstr("threshold_hu"));
  EXPECT_THAT(message({.upper_hu = -500.0}), testing::HasSubstr("upper_hu"));
  EXPECT_THAT(message({.closing_mm = -1.0}), testing::HasSubstr("closing_mm must be in [0, 30]"));
  EXPECT_THAT(message({.num_vertices = 5}), testing::HasSubstr("got 5"));
  EXPECT_THAT(message({.sub_sampling = 0}), testing::HasSubstr("sub_sampling"));
}

TEST(ExtractBone, FindsBoneInsideTheBodyOnly) {
  auto volume = make_volume(80, 1.0, [](const auto& place) { return 30.0 - place.norm(); });
  for (int z = 0; z < 80; ++z) {
    for (int y = 0; y < 80; ++y) {
      for (int x = 0; x < 80; ++x) {
        const Eigen::Vector3d place = volume.ct_from_grid * Eigen::Vector3d(x, y, z);
        if ((place - Eigen::Vector3d(5, 0, 0)).norm() < 10.0)
          volume.hu[volume.index(x, y, z)] = 800;
        if ((place - Eigen::Vector3d(36, 36, 0)).norm() < 3.0)
          volume.hu[volume.index(x, y, z)] = 800;
      }
    }
  }
  const auto bone =
      extract_bone(extract_skin(volume, kQuick, {})->body, {.num_triangles = 500}, {});
  ASSERT_TRUE(bone) << bone.error().message;
  EXPECT_LE(bone->triangles.size(), 520U);
  EXPECT_EQ(bone->normals.size(), bone->vertices.size());
  for (const auto& vertex : bone->vertices)
    EXPECT_NEAR((vertex - Eigen::Vector3f(5, 0, 0)).norm(), 10.0, 1.0);
  EXPECT_GT(enclosed_volume_mm3(*bone), 0.0);
}

TEST(ExtractBone, IsEmptyWhereThereIsNone) {
  const auto volume = make_volume(40, 1.0, [](const auto& place) { return 15.0 - place.norm(); });
  const auto bone = extract_bone(volume, {}, {});
  ASSERT_TRUE(bone);
  EXPECT_TRUE(bone->empty());
}

TEST(BoneOptions, NameTheValueAndTheLimit) {
  EXPECT_TRUE(BoneOptions{}.check());
  EXPECT_FALSE(BoneOptions{.threshold_hu = 5000.0}.check());
  EXPECT_FALSE(BoneOptions{.min_component_mm3 = -1.0}.check());
  EXPECT_FALSE(BoneOptions{.num_triangles = 1}.check());
}

}  // namespace
}  // namespace mor
