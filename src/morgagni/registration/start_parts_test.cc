// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// The automatic start's parts that are told apart from the outside only with difficulty.
#include <cmath>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/internal/start_decision.h"
#include "morgagni/registration/internal/start_evenness.h"
#include "morgagni/registration/internal/start_fusion.h"
#include "morgagni/registration/internal/start_mirror.h"
#include "morgagni/registration/internal/start_motion.h"
#include "morgagni/registration/internal/start_planes.h"
#include "morgagni/registration/internal/start_verification.h"

namespace mor::internal {
namespace {

const PinholeCamera kCamera{320, 240, 262.0, 262.0, 159.5, 119.5, {}};

/// What a camera measures of planes, the nearest at each pixel, with noise of 2 mm either way.
StartPicture picture_of(const std::vector<StartPlane>& planes, unsigned seed = 5) {
  StartPicture picture{kCamera, Image<float>(kCamera.width_px, kCamera.height_px), {}};
  std::mt19937 random(seed);
  for (int y = 0; y < kCamera.height_px; ++y) {
    for (int x = 0; x < kCamera.width_px; ++x) {
      float nearest = 0.0F;
      for (const auto& plane : planes) {
        const float z = plane.offset_mm / plane.normal.dot(picture.point_at(x, y, 1.0F));
        if (z > 0.0F && (nearest == 0.0F || z < nearest)) nearest = z;
      }
      const float noise_mm = static_cast<float>(random() % 401) / 100.0F - 2.0F;
      if (nearest > 0.0F) picture.z_mm(x, y) = nearest + noise_mm;
    }
  }
  return picture;
}

/// A table before the camera, tilted away from it, and a wall that rises from its far edge.
const Eigen::Vector3f kUp = Eigen::Vector3f(0.1F, -0.7F, -0.7F).normalized();
const Eigen::Vector3f kOffWall = Eigen::Vector3f::UnitX().cross(kUp).normalized();
const StartPlane kTable{kUp, kUp.dot(Eigen::Vector3f(0.0F, 0.0F, 900.0F))};
const StartPlane kWall{kOffWall, kOffWall.dot(Eigen::Vector3f(0.0F, -120.0F, 1000.0F))};

void expect_among(const std::vector<StartPlane>& planes, const StartPlane& expected) {
  for (const auto& plane : planes) {
    if (plane.normal.dot(expected.normal) > 0.9998F) {
      EXPECT_NEAR(plane.offset_mm, expected.offset_mm, 3.0F);
      return;
    }
  }
  ADD_FAILURE() << "no plane with the normal " << expected.normal.transpose();
}

TEST(StartPlanes, AreATableAndAWallToADegree) {
  ASSERT_LT(kOffWall.z(), 0.0F);
  const auto planes = find_planes(picture_of({kTable, kWall}), std::nullopt);
  ASSERT_GE(planes.size(), 2U);
  expect_among(planes, kTable);
  expect_among(planes, kWall);
  EXPECT_GE(planes[0].share, planes[1].share);
  EXPECT_NEAR(planes[0].share + planes[1].share, 1.0F, 0.1F);
}

TEST(StartPlanes, AreLevelWhereGravityIsKnown) {
  const auto planes = find_planes(picture_of({kTable, kWall}), kUp);
  ASSERT_FALSE(planes.empty());
  for (const auto& plane : planes) EXPECT_GT(plane.normal.dot(kUp), 0.97F);
  expect_among(planes, kTable);
}

TEST(StartPlanes, AreSupposedBelowTheHighestThingsSeen) {
  const float top_mm = kTable.offset_mm;
  const auto planes = suppose_planes(picture_of({kTable}), kUp, 200.0F, 20.0F);
  ASSERT_FALSE(planes.empty());
  EXPECT_NEAR(planes.front().offset_mm, top_mm - 60.0F, 5.0F);
  EXPECT_NEAR(planes.back().offset_mm, top_mm - 240.0F, 5.0F);
  for (const auto& plane : planes) {
    EXPECT_TRUE(plane.is_supposed);
    EXPECT_EQ(plane.normal, kUp);
  }
}

TEST(StartPlanes, AreNoneOfAnEmptyPicture) {
  const StartPicture empty{kCamera, Image<float>(kCamera.width_px, kCamera.height_px), {}};
  EXPECT_TRUE(suppose_planes(empty, kUp, 200.0F, 20.0F).empty());
  EXPECT_TRUE(find_planes(empty, std::nullopt).empty());
}

/// Misfits of a picture that is all skin: noise of `noise_mm`, and what `error_mm(u, v)` adds at
/// u, v in -1..1.
template <class F>
Image<float> skin_with(float noise_mm, const F& error_mm) {
  Image<float> misfit_mm(80, 60);
  std::mt19937_64 random(3);
  std::normal_distribution<float> noise(0.0F, noise_mm);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 80; ++x) {
      misfit_mm(x, y) = noise(random) + error_mm(static_cast<float>(x) / 40.0F - 1.0F,
                                                 static_cast<float>(y) / 30.0F - 1.0F);
    }
  }
  return misfit_mm;
}

TEST(StartEvenness, IsBlindToNoiseAndToASlowErrorOfTheSensor) {
  const auto noisy = judge_evenness(skin_with(2.0F, [](float, float) { return 0.0F; }));
  EXPECT_EQ(noisy.num_patches, 300);
  EXPECT_NEAR(noisy.uneven_mm, 0.5, 0.1);  // 2 mm over 16 readings.
  const auto biased = judge_evenness(
      skin_with(2.0F, [](float u, float v) { return 2.0F + 3.0F * u * u - 1.5F * v; }));
  EXPECT_NEAR(biased.uneven_mm, noisy.uneven_mm, 0.05);
}

TEST(StartEvenness, SeesSkinThatOnlyLooksAlike) {
  const auto waves = [](float u, float v) {
    return 2.0F * std::sin(9.0F * u) * std::cos(8.0F * v);
  };
  EXPECT_GT(judge_evenness(skin_with(2.0F, waves)).uneven_mm, 0.9);
}

TEST(StartEvenness, CountsPatchesThatAreNearlyWhole) {
  Image<float> misfit_mm(8, 4, 0.0F);
  for (int i = 0; i < 7; ++i) misfit_mm(i % 4, i / 4) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(judge_evenness(misfit_mm).num_patches, 1);
  EXPECT_EQ(judge_evenness(Image<float>(3, 3, 0.0F)).num_patches, 0);
  EXPECT_EQ(judge_evenness(Image<float>()).num_patches, 0);
}

/// A look at the right pose with a good part of the body in view.
SkinAgreement good_look() {
  SkinAgreement look;
  look.num_seen = 2000.0;
  look.num_agree = 920.0;
  look.num_hidden = 1000.0;
  look.num_floating = 8.0;
  look.area_share = 0.2;
  look.firmness = 0.02;
  look.num_patches = 50.0;
  look.uneven_mm = 0.4;
  return look;
}

AutomaticStartStatus status_of(const SkinAgreement& look,
                               double runner_up_share = 0.2,
                               double mirrored_share = 0.5) {
  const auto verdict = decide_start({look, runner_up_share, mirrored_share});
  EXPECT_EQ(verdict.reason.empty(), verdict.status == AutomaticStartStatus::kFound);
  return verdict.status;
}

TEST(StartDecision, FindsAPoseThatHalfTheSkinSpeaksFor) {
  EXPECT_EQ(status_of(good_look()), AutomaticStartStatus::kFound);
}

TEST(StartDecision, IsRefusedByEachDoubtAlone) {
  SkinAgreement look = good_look();
  look.num_floating = 150.0;
  EXPECT_EQ(status_of(look), AutomaticStartStatus::kNotFound);
  EXPECT_THAT(decide_start({look}).reason, testing::HasSubstr("looks through 8 %"));
  look = good_look();
  look.uneven_mm = 1.1;
  EXPECT_EQ(status_of(look), AutomaticStartStatus::kNotFound);
  EXPECT_THAT(decide_start({look}).reason, testing::HasSubstr("1.1 mm off it"));
  look = good_look();
  look.num_agree = 590.0;
  EXPECT_EQ(status_of(look), AutomaticStartStatus::kNotFound);
  EXPECT_THAT(decide_start({look}).reason, testing::HasSubstr("59 % of the skin"));
  look = good_look();
  look.num_patches = 2.0;
  EXPECT_EQ(status_of(look), AutomaticStartStatus::kNotFound);
  look = good_look();
  look.firmness = 2e-4;
  EXPECT_EQ(status_of(look), AutomaticStartStatus::kAmbiguous);
  EXPECT_EQ(status_of({}), AutomaticStartStatus::kNotFound);
}

TEST(StartDecision, AddsDoubtsUp) {
  SkinAgreement look = good_look();
  look.num_floating = 20.0;
  EXPECT_EQ(status_of(look), AutomaticStartStatus::kFound);
  look.firmness = 0.001;
  EXPECT_NE(status_of(look), AutomaticStartStatus::kFound);
}

TEST(StartDecision, IsAmbiguousBesideAnotherPoseOrTheMirrorImage) {
  SkinAgreement look = good_look();
  look.num_floating = 20.0;
  EXPECT_EQ(status_of(look, 0.1), AutomaticStartStatus::kFound);
  EXPECT_EQ(status_of(look, 1.0), AutomaticStartStatus::kAmbiguous);
  EXPECT_EQ(status_of(look, 0.1, 1.05), AutomaticStartStatus::kAmbiguous);
  EXPECT_THAT(decide_start({look, 0.1, 1.05}).reason, testing::HasSubstr("mirror image"));
  EXPECT_EQ(status_of(look, 0.1, 0.5), AutomaticStartStatus::kFound);
  look.uneven_mm = 0.7;  // With little to spare, a mirror image that fits half as well is too much.
  EXPECT_EQ(status_of(look, 0.1, 0.0), AutomaticStartStatus::kFound);
  EXPECT_EQ(status_of(look, 0.1, 0.5), AutomaticStartStatus::kAmbiguous);
}

TEST(StartDecision, AsksMoreOfFurtherPictures) {
  SkinAgreement weak = good_look();
  weak.uneven_mm = 0.86;
  EXPECT_EQ(decide_start({.look = weak, .num_tries = 1}).status, AutomaticStartStatus::kFound);
  EXPECT_EQ(decide_start({.look = weak, .num_tries = 2}).status, AutomaticStartStatus::kNotFound);
}

TEST(StartDecision, HoldsTheMeanOfSeveralPicturesToItsNoise) {
  SkinAgreement look = good_look();
  look.noise_mm = 1.5;
  look.noise_share = 0.5;
  look.uneven_mm = 0.3;
  EXPECT_EQ(status_of(look), AutomaticStartStatus::kFound);
  look.uneven_mm = 0.45;  // Much for what is left of 1.5 mm, little where the noise is 3 mm.
  EXPECT_EQ(status_of(look), AutomaticStartStatus::kNotFound);
  look.noise_mm = 3.0;
  EXPECT_EQ(status_of(look), AutomaticStartStatus::kFound);
}

TEST(StartDecision, RanksPosesWithoutTrustByIt) {
  SkinAgreement bad = good_look();
  bad.uneven_mm = 1.2;
  SkinAgreement worse = bad;
  worse.uneven_mm = 1.3;
  SkinAgreement nothing = bad;
  nothing.num_agree = 100.0;
  EXPECT_GT(believed_evidence(good_look()), 0.0);
  EXPECT_LT(believed_evidence(bad), 0.0);
  EXPECT_LT(believed_evidence(worse), believed_evidence(bad));
  EXPECT_LT(believed_evidence(nothing), believed_evidence(worse));
}

/// The planes as a camera sees them that has moved.
std::vector<StartPlane> seen_after(const Eigen::Isometry3d& earlier_from_later,
                                   std::vector<StartPlane> planes) {
  const Eigen::Isometry3f moved = earlier_from_later.cast<float>();
  for (auto& plane : planes) {
    plane.offset_mm -= plane.normal.dot(moved.translation());
    plane.normal = moved.linear().transpose() * plane.normal;
  }
  return planes;
}

const Eigen::Isometry3d kMoved =
    Eigen::Translation3d(25.0, -15.0, 20.0) *
    Eigen::AngleAxisd(0.05, Eigen::Vector3d(0.3, 1.0, 0.5).normalized());

TEST(StartMotion, IsFoundInACorner) {
  const StartPlane side{-Eigen::Vector3f::UnitX(), -300.0F};
  const std::vector<StartPlane> corner{kTable, kWall, side};
  const auto found = camera_motion(picture_of(corner), picture_of(seen_after(kMoved, corner)));
  ASSERT_TRUE(found);
  const Eigen::Vector3d seen(0.0, 0.0, 900.0);
  EXPECT_LT(displacement_mm(*found, kMoved, seen), 1.0);
  EXPECT_LT(rotation_angle_rad(*found * kMoved.inverse()), 0.002);
}

TEST(StartMotion, IsNotGuessedOverABareTableNorWhereAllHasChanged) {
  EXPECT_FALSE(camera_motion(picture_of({kTable}), picture_of(seen_after(kMoved, {kTable}))));
  EXPECT_FALSE(camera_motion(picture_of({kTable, kWall}), picture_of({kWall})));
  const StartPicture empty{kCamera, Image<float>(kCamera.width_px, kCamera.height_px), {}};
  EXPECT_FALSE(camera_motion(picture_of({kTable}), empty));
  EXPECT_FALSE(camera_motion(empty, picture_of({kTable})));
}

TEST(StartMotion, IsHeldByEarlierPicturesToo) {
  const StartPlane side{-Eigen::Vector3f::UnitX(), -300.0F};
  const std::vector<StartPlane> corner{kTable, kWall, side};
  const StartPicture last = picture_of(corner);
  const StartPicture newest = picture_of(seen_after(kMoved, corner), 6);
  std::vector<StartPicture> before;
  for (unsigned seed = 7; seed < 11; ++seed) {
    before.push_back(picture_of(seen_after(kMoved.inverse(), corner), seed));
  }
  std::vector<OtherPicture> others;
  for (const auto& picture : before) others.push_back({&picture, kMoved});
  const auto alone = camera_motion(last, newest);
  const auto held = camera_motion(last, newest, others);
  ASSERT_TRUE(alone && held);
  const Eigen::Vector3d seen(0.0, 0.0, 900.0);
  EXPECT_LT(displacement_mm(*held, kMoved, seen), 0.7);
  EXPECT_FALSE(held->isApprox(*alone, 0.0));
}

TEST(SeenViews, KeepThePlacesThatDifferMostAndTheNewest) {
  const StartPlane side{-Eigen::Vector3f::UnitX(), -300.0F};
  const std::vector<StartPlane> corner{kTable, kWall, side};
  // A hand that goes to one side, stays there for a while, and goes on.
  const std::vector<double> at_mm{0.0, 30.0, 60.0, 61.0, 60.5, 61.5, 60.0, 90.0};
  SeenViews views;
  for (std::size_t i = 0; i < at_mm.size(); ++i) {
    const Eigen::Isometry3d moved(Eigen::Translation3d(at_mm[i], 0.0, 0.0));
    StartPicture picture = picture_of(seen_after(moved, corner), static_cast<unsigned>(i));
    picture.even_mm = evened(picture.z_mm);
    const auto motion = views.add(picture, {}, 300.0F);
    ASSERT_EQ(motion.has_value(), i > 0) << i;
    if (motion) EXPECT_NEAR(motion->translation().x(), at_mm[i] - at_mm[i - 1], 1.0) << i;
  }
  ASSERT_EQ(views.all().size(), SeenViews::kMostViews);
  const std::vector<double> kept_mm{0.0, 30.0, 60.0, 60.0, 90.0};
  for (std::size_t i = 0; i < kept_mm.size(); ++i) {
    const Eigen::Isometry3d place = views.all()[i].newest_from_this;
    EXPECT_NEAR(90.0 + place.translation().x(), kept_mm[i], 2.5) << i;
  }
  EXPECT_EQ(views.newest().age, 0);
  EXPECT_EQ(views.all().front().age, 7);
}

/// A sheet of skin, 200 x 200 mm, 800 mm before the camera, whose pose is the CT's frame.
std::shared_ptr<const FixedSurface> sheet() {
  auto surface = std::make_shared<FixedSurface>();
  surface->mesh.vertices = {{-100.0F, -100.0F, 800.0F},
                            {100.0F, -100.0F, 800.0F},
                            {100.0F, 100.0F, 800.0F},
                            {-100.0F, 100.0F, 800.0F}};
  surface->mesh.normals.assign(4, -Eigen::Vector3f::UnitZ());
  surface->mesh.triangles = {{0, 2, 1}, {0, 3, 2}};
  return surface;
}

/// What a sensor sees of the sheet before a wall far behind it.
StartPicture picture_of_sheet(float skin_mm) {
  StartPicture picture{kCamera, Image<float>(kCamera.width_px, kCamera.height_px, 1200.0F), {}};
  for (int y = 0; y < kCamera.height_px; ++y) {
    for (int x = 0; x < kCamera.width_px; ++x) {
      const Eigen::Vector3f at = picture.point_at(x, y, 800.0F);
      if (std::abs(at.x()) <= 100.0F && std::abs(at.y()) <= 100.0F) picture.z_mm(x, y) = skin_mm;
    }
  }
  return picture;
}

TEST(StartVerifier, LooksThroughNoSkinThatIsThere) {
  const StartVerifier verifier(sheet(), 200.0F);
  StartPicture picture = picture_of_sheet(800.0F);
  // A rod before it, at whose edges readings have strayed to the wall and to the skin.
  for (int y = 0; y < kCamera.height_px; ++y) {
    for (int x = 150; x < 156; ++x) picture.z_mm(x, y) = 700.0F;
    picture.z_mm(y % 3 == 0 ? 149 : 151, y) = 1200.0F;
  }
  const auto look = verifier.look(picture, {}, Eigen::Isometry3d::Identity(), 1.0F);
  EXPECT_EQ(look.num_floating, 0.0);
  EXPECT_GT(look.num_agree, 3000.0);
  EXPECT_GT(look.num_hidden, 100.0);
}

TEST(StartVerifier, SeesThatTheCameraLooksThrough) {
  const StartVerifier verifier(sheet(), 200.0F);
  StartPicture picture = picture_of_sheet(800.0F);
  for (int y = 100; y < 110; ++y) {
    for (int x = 150; x < 170; ++x) picture.z_mm(x, y) = 1200.0F;
  }
  const auto look = verifier.look(picture, {}, Eigen::Isometry3d::Identity(), 1.0F);
  EXPECT_NEAR(look.num_floating, 8.0 * 18.0, 1.0) << "but for the rim of what is missing";
}

TEST(StartVerifier, DoesNotJudgeByTheOutlineOfTheSkin) {
  const StartVerifier verifier(sheet(), 200.0F);
  StartPicture picture = picture_of_sheet(800.0F);
  const auto right = verifier.look(picture, {}, Eigen::Isometry3d::Identity(), 1.0F);
  // The outline strays inwards by a pixel, as lateral noise makes it.
  for (int y = 1; y + 1 < kCamera.height_px; ++y) {
    for (int x = 1; x < kCamera.width_px / 2; ++x) {
      if (picture.z_mm(x, y) == 800.0F && picture.z_mm(x - 1, y) == 1200.0F) {
        picture.z_mm(x, y) = 1200.0F;
        break;
      }
    }
  }
  const auto strayed = verifier.look(picture, {}, Eigen::Isometry3d::Identity(), 1.0F);
  EXPECT_EQ(strayed.num_floating, 0.0);
  EXPECT_EQ(strayed.num_agree, right.num_agree);
}

TEST(StartPicture, HasNoReadingsThatBelongToNoSurface) {
  const PinholeCamera camera{320, 240, 262.0, 262.0, 159.5, 119.5, {}};
  Image<std::uint16_t> depth_mm(320, 240, std::uint16_t{0});
  for (int y = 100; y < 200; ++y) {
    for (int x = 100; x < 200; ++x) depth_mm(x, y) = 800;
  }
  depth_mm(150, 150) = 900;                               // On a surface, but not of it.
  depth_mm(20, 20) = 800;                                 // Alone.
  for (int y = 100; y < 200; ++y) depth_mm(97, y) = 800;  // A line is no surface.
  const StartPicture picture = StartPictureMaker(camera).make(depth_mm.view(), 2000.0F);
  EXPECT_EQ(picture.z_mm(150, 150), 0.0F);
  EXPECT_EQ(picture.z_mm(20, 20), 0.0F);
  EXPECT_EQ(picture.z_mm(97, 150), 0.0F);
  EXPECT_EQ(picture.z_mm(120, 120), 800.0F);
  EXPECT_EQ(picture.z_mm(100, 150), 800.0F) << "its straight edge is one";
}

TEST(StartPicture, EvenedHasLessNoiseAndKeepsSlopesAndEdges) {
  StartPicture picture = picture_of({kTable, kWall});
  for (int y = 0; y < kCamera.height_px; ++y) picture.z_mm(100, y) = 0.0F;
  for (int y = 0; y < kCamera.height_px; ++y) {
    for (int x = 200; x < kCamera.width_px; ++x)
      picture.z_mm(x, y) = 400.0F;  // Something before it.
  }
  const Image<float> even_mm = evened(picture.z_mm);
  double sum_mm2 = 0.0;
  int count = 0;
  for (int y = 150; y < 235; ++y) {
    EXPECT_EQ(even_mm(100, y), 0.0F);
    EXPECT_EQ(even_mm(203, y), 400.0F);
    for (int x = 5; x < 195; ++x) {
      if (x > 96 && x < 104) continue;
      const double off_mm = kTable.height_mm(picture.point_at(x, y, even_mm(x, y)));
      sum_mm2 += off_mm * off_mm;
      ++count;
    }
  }
  EXPECT_LT(std::sqrt(sum_mm2 / count), 0.35);  // Even over +-2 mm it is 1.15 along the ray.
}

/// Root mean square distance of the readings from the table, in a part of the picture that shows
/// nothing else.
double off_table_mm(const StartPicture& picture) {
  double sum_mm2 = 0.0;
  int count = 0;
  for (int y = 180; y < 220; ++y) {
    for (int x = 100; x < 220; ++x) {
      const double off_mm = kTable.height_mm(picture.point(x, y));
      sum_mm2 += off_mm * off_mm;
      ++count;
    }
  }
  return std::sqrt(sum_mm2 / count);
}

TEST(StartFusion, AveragesTheNoiseOfAMovedCameraAway) {
  StartPicture own = picture_of({kTable, kWall});
  own.even_mm = evened(own.z_mm);
  std::vector<StartPicture> moved;
  for (unsigned seed = 6; seed < 10; ++seed) {
    moved.push_back(picture_of(seen_after(kMoved, {kTable, kWall}), seed));
  }
  std::vector<OtherPicture> others;
  for (const auto& picture : moved) others.push_back({&picture, kMoved.inverse()});
  const StartPicture all = fused(own, others);
  EXPECT_LT(off_table_mm(all), 0.5 * off_table_mm(own));
  EXPECT_NEAR(all.noise_share, 1.0 / std::sqrt(5.0), 1e-6);
}

TEST(StartFusion, LeavesOutWhatAnotherPictureSeesInFront) {
  StartPicture own = picture_of({kTable});
  own.even_mm = evened(own.z_mm);
  const StartPlane hand{kTable.normal, kTable.offset_mm + 30.0F};
  const StartPicture other = picture_of({kTable, hand}, 6);
  const StartPicture all = fused(own, {{&other, Eigen::Isometry3d::Identity()}});
  EXPECT_EQ(off_table_mm(all), off_table_mm(own));
}

TEST(SkinAgreement, OfSeveralPicturesAddsUpButForTheHold) {
  SkinAgreement first = good_look();
  SkinAgreement second = good_look();
  second.num_patches = 150.0;
  second.uneven_mm = 0.8;
  second.area_share = 0.1;
  const SkinAgreement both = pooled({first, second});
  EXPECT_EQ(both.num_agree, first.num_agree + second.num_agree);
  EXPECT_EQ(both.num_floating, first.num_floating + second.num_floating);
  EXPECT_EQ(both.num_patches, 150.0);  // The same skin seen twice is no more skin.
  EXPECT_NEAR(both.uneven_mm, std::sqrt(0.25 * 0.16 + 0.75 * 0.64), 1e-9);
  EXPECT_EQ(both.area_share, first.area_share);
  EXPECT_EQ(pooled({}).num_seen, 0.0);
}

TEST(StartMirror, TurnsAPoseIntoOneOfTheMirroredPicture) {
  const Eigen::Vector3d middle(40.0, -20.0, 300.0);
  const Eigen::Isometry3d pose =
      Eigen::Translation3d(10.0, -600.0, 250.0) *
      Eigen::AngleAxisd(1.2, Eigen::Vector3d(1.0, 0.4, -0.2).normalized());
  const Eigen::Isometry3d other = mirrored(pose, middle);
  EXPECT_NEAR(other.linear().determinant(), 1.0, 1e-9);
  const Eigen::Vector3d seen(30.0, -50.0, 700.0);
  const Eigen::Vector3d in_ct = pose * seen;
  const Eigen::Vector3d mirrored_seen(-seen.x(), seen.y(), seen.z());
  const Eigen::Vector3d mirrored_in_ct(2.0 * middle.x() - in_ct.x(), in_ct.y(), in_ct.z());
  EXPECT_LT((other * mirrored_seen - mirrored_in_ct).norm(), 1e-9);
  EXPECT_LT((mirrored(other, middle).matrix() - pose.matrix()).norm(), 1e-9);
}

TEST(StartMirror, MovesWithTheMirroredCamera) {
  const StartPicture picture = picture_of({kTable});
  Eigen::Isometry3d motion = Eigen::Translation3d(12.0, -5.0, 20.0) *
                             Eigen::Isometry3d(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()));
  const SeenViews views(
      {{picture, picture, {kTable}, {}, motion, 1}, {picture, picture, {kTable}, {}, {}, 0}});
  const SeenViews others = mirrored(views);
  ASSERT_EQ(others.all().size(), 2U);
  const Eigen::Vector3d moved = motion * Eigen::Vector3d(30.0, -50.0, 700.0);
  const Eigen::Vector3d there =
      others.all()[0].newest_from_this * Eigen::Vector3d(-30.0, -50.0, 700.0);
  EXPECT_LT((there - Eigen::Vector3d(-moved.x(), moved.y(), moved.z())).norm(), 1e-9);
}

TEST(StartFinding, KnowsThePlaneItWasFoundOnWhereverTheCameraHasMoved) {
  auto scene = std::make_shared<StartScene>();
  scene->plane = kTable;
  StartFinding finding;
  finding.scene = scene;
  finding.on_plane = Eigen::Translation3d(10.0, -600.0, 250.0) *
                     Eigen::AngleAxisd(1.2, Eigen::Vector3d(1.0, 0.4, -0.2).normalized());
  finding.up_ct = finding.on_plane.linear() * kTable.normal.cast<double>();
  finding.foot_ct_mm =
      static_cast<double>(kTable.offset_mm) + finding.up_ct.dot(finding.on_plane.translation());
  const Eigen::Isometry3d last_from_newest =
      Eigen::Translation3d(12.0, -5.0, 20.0) *
      Eigen::Isometry3d(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()));
  finding.on_plane = finding.on_plane * last_from_newest;
  const StartPlane plane = plane_of(finding);
  const Eigen::Vector3f seen(40.0F, 30.0F, 800.0F);
  EXPECT_NEAR(plane.height_mm(seen), kTable.height_mm(last_from_newest.cast<float>() * seen), 1e-2);
}

TEST(StartMirror, SeesAPixelsPointOnTheOtherSide) {
  StartPicture picture = picture_of({kTable});
  picture.camera.center_x_px = 150.25;
  const StartPicture other = mirrored(picture);
  const Eigen::Vector3f point = picture.point(20, 30);
  const Eigen::Vector3f there = other.point(kCamera.width_px - 1 - 20, 30);
  EXPECT_LT((there - Eigen::Vector3f(-point.x(), point.y(), point.z())).norm(), 1e-2F);
}

}  // namespace
}  // namespace mor::internal
