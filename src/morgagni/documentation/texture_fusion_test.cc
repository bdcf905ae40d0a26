// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/texture_fusion.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/camera/simulated_camera.h"
#include "morgagni/documentation/skin_atlas.h"
#include "morgagni/documentation/skin_texture_io.h"
#include "morgagni/documentation/texture_coverage.h"
#include "morgagni/documentation/texture_view.h"
#include "morgagni/geometry/rigid.h"

namespace mor {
namespace {

using ::testing::HasSubstr;

/// As large as a head, egg-shaped, with a nose.
std::shared_ptr<const TriangleMesh> egg() {
  constexpr int kRings = 70;
  auto mesh = std::make_shared<TriangleMesh>();
  for (int ring = 0; ring <= kRings; ++ring) {
    for (int column = 0; column < kRings; ++column) {
      const float polar = std::numbers::pi_v<float> * static_cast<float>(ring) / kRings;
      const float around = 2.0F * std::numbers::pi_v<float> * static_cast<float>(column) / kRings;
      const Eigen::Vector3f d(
          std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar));
      const float nose = 18.0F * std::exp(-(d + Eigen::Vector3f::UnitY()).squaredNorm() / 0.06F);
      mesh->vertices.emplace_back(d.cwiseProduct(Eigen::Vector3f(75, 90, 110)) + nose * d);
    }
  }
  const auto at = [](int ring, int column) {
    return static_cast<std::uint32_t>(ring * kRings + column % kRings);
  };
  for (int ring = 0; ring < kRings; ++ring) {
    for (int column = 0; column < kRings; ++column) {
      const auto a = at(ring, column);
      const auto c = at(ring + 1, column + 1);
      if (ring + 1 < kRings) mesh->triangles.push_back({a, at(ring + 1, column), c});
      if (ring > 0) mesh->triangles.push_back({a, c, at(ring, column + 1)});
    }
  }
  mesh->normals = vertex_normals(*mesh);
  return mesh;
}

const std::shared_ptr<const TriangleMesh>& skin() {
  static const auto kSkin = egg();
  return kSkin;
}

const std::shared_ptr<const SkinAtlas>& atlas() {
  static const auto kAtlas = std::make_shared<const SkinAtlas>(unwrap_skin(*skin()).value());
  return kAtlas;
}

std::unique_ptr<SimulatedCamera> camera(const std::string& keys) {
  return SimulatedCamera::create(
             skin(), SimulatedCameraOptions::parse("skin=marked,distance=500," + keys).value())
      .value();
}

TextureFusion fusion(const TextureFusionOptions& options = {}) {
  return TextureFusion::create(atlas(), options).value();
}

FusionOutcome melt(TextureFusion& into, const SimulatedCamera& from, std::uint64_t id) {
  return into.add(*from.frame_at(id), from.ct_from_camera(id), 0.5, 1000).value();
}

double seen_share(const SkinTexture& texture) {
  std::size_t seen = 0;
  for (std::size_t i = 0; i < texture.sources.size(); ++i) {
    seen += texture.sources.data()[i].frame != TexelSource::kNeverSeen ? 1 : 0;
  }
  return static_cast<double>(seen) / static_cast<double>(texture.sources.size());
}

/// Differences of green where both were seen, after one gain, in order of size.
std::vector<double> differences(const SkinTexture& a, const SkinTexture& b) {
  std::vector<double> ratios;
  const auto for_both = [&](auto visit) {
    for (std::size_t i = 0; i < a.color.size(); ++i) {
      if (a.sources.data()[i].frame == TexelSource::kNeverSeen ||
          b.sources.data()[i].frame == TexelSource::kNeverSeen) {
        continue;
      }
      visit(static_cast<double>(a.color.data()[i].g), static_cast<double>(b.color.data()[i].g));
    }
  };
  for_both([&](double of_a, double of_b) { ratios.push_back(of_a / std::max(of_b, 1.0)); });
  std::nth_element(ratios.begin(), ratios.begin() + ratios.size() / 2, ratios.end());
  const double gain = ratios[ratios.size() / 2];
  std::vector<double> result;
  for_both([&](double of_a, double of_b) { result.push_back(std::abs(of_a - gain * of_b)); });
  std::sort(result.begin(), result.end());
  return result;
}

double share_at(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

/// Sum of squared steps between neighbouring texels that all of the textures have.
std::vector<double> gradient_energies(const std::vector<SkinTexture>& textures) {
  std::vector<double> energy(textures.size(), 0.0);
  const auto& first = textures.front();
  for (int y = 0; y + 1 < first.color.height(); ++y) {
    for (int x = 0; x + 1 < first.color.width(); ++x) {
      const bool is_seen = std::all_of(textures.begin(), textures.end(), [&](const auto& texture) {
        return texture.is_seen(x, y) && texture.is_seen(x + 1, y);
      });
      if (!is_seen) continue;
      for (std::size_t i = 0; i < textures.size(); ++i) {
        const double step = static_cast<double>(textures[i].color(x + 1, y).g) -
                            static_cast<double>(textures[i].color(x, y).g);
        energy[i] += step * step;
      }
    }
  }
  return energy;
}

/// Poses as a tracker has them: each off by its own, half a millimetre or so.
class Jitter {
 public:
  Eigen::Isometry3d operator()(const Eigen::Isometry3d& ct_from_camera) {
    Vector6d twist;
    for (int i = 0; i < 6; ++i) twist[i] = normal_(random_) * (i < 3 ? 0.004 : 0.5);
    return se3_exp(twist) * ct_from_camera;
  }

 private:
  std::mt19937 random_{7};
  std::normal_distribution<double> normal_;
};

TEST(TextureFusion, ShowsWhatTheCameraSawAndFromWhere) {
  const auto from = camera("noise=0,path=still");
  auto melting = fusion();
  EXPECT_EQ(melt(melting, *from, 0), FusionOutcome::kFused);
  const auto texture = melting.texture();
  EXPECT_GT(seen_share(texture), 0.1);
  ASSERT_EQ(texture.frames.size(), 1U);
  EXPECT_EQ(texture.frames[0].captured_unix_ms, 1000);
  EXPECT_TRUE(texture.frames[0].ct_from_color.isApprox(from->ct_from_camera(0), 1e-5));
  // The texel of the nose's tip, projected by hand.
  const auto frame = from->frame_at(0);
  const auto& mesh = atlas()->mesh;
  std::size_t tip = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.vertices[mesh.triangles[i][0]].y() < mesh.vertices[mesh.triangles[tip][0]].y())
      tip = i;
  }
  const auto& [a, b, c] = atlas()->corners_px[tip];
  const Eigen::Vector2f middle = (a + b + c) / 3.0F;
  const int x = static_cast<int>(std::lround(middle.x()));
  const int y = static_cast<int>(std::lround(middle.y()));
  ASSERT_TRUE(texture.is_seen(x, y));
  const auto& corners = mesh.triangles[tip];
  const Eigen::Vector3d at =
      ((mesh.vertices[corners[0]] + mesh.vertices[corners[1]] + mesh.vertices[corners[2]]) / 3.0F)
          .cast<double>();
  const auto pixel = frame->calibration->color.project(from->ct_from_camera(0).inverse() * at);
  const auto& shown = frame->color(static_cast<int>(std::lround(pixel->x())),
                                   static_cast<int>(std::lround(pixel->y())));
  EXPECT_NEAR(texture.color(x, y).r, shown.r, 12);
  EXPECT_NEAR(texture.color(x, y).g, shown.g, 12);
  const auto& source = texture.sources(x, y);
  const double distance_mm = (from->ct_from_camera(0).translation() - at).norm();
  EXPECT_NEAR(source.distance_mm, distance_mm, 2.0);
  EXPECT_NEAR(source.px_per_mm, 525.0 / distance_mm * std::cos(source.angle_rad), 0.01);
}

TEST(TextureFusion, PassesOverWhatIsNotSure) {
  const auto from = camera("path=still");
  auto melting = fusion();
  const auto frame = from->frame_at(0);
  const auto pose = from->ct_from_camera(0);
  EXPECT_EQ(melting.add(*frame, pose, std::nullopt, 0).value(), FusionOutcome::kUncertain);
  EXPECT_EQ(melting.add(*frame, pose, 20.0, 0).value(), FusionOutcome::kUncertain);
  // A pose from which the depth picture shows something else than skin.
  const Eigen::Isometry3d beside = Eigen::Translation3d(0, 60, 0) * pose;
  EXPECT_EQ(melting.add(*frame, beside, 0.5, 0).value(), FusionOutcome::kNoSkin);
  EXPECT_EQ(melting.num_frames(), 0U);
  EXPECT_EQ(seen_share(melting.texture()), 0.0);
}

TEST(TextureFusion, PassesOverAFrameOfAFastCamera) {
  const auto from = camera("path=still");
  auto melting = fusion();
  EXPECT_EQ(melt(melting, *from, 0), FusionOutcome::kFused);
  auto next = *from->frame_at(1);
  const Eigen::Isometry3d swung =
      from->ct_from_camera(1) * Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY());
  EXPECT_EQ(melting.add(next, swung, 0.5, 0).value(), FusionOutcome::kMoving);
}

TEST(TextureFusion, RefusesAFrameThatIsNotWhatItSays) {
  auto melting = fusion();
  RgbdFrame frame = *camera("path=still")->frame_at(0);
  frame.color = Image<Rgb8>(639, 480);
  const auto refused = melting.add(frame, Eigen::Isometry3d::Identity(), 1.0, 0);
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message, HasSubstr("639x480 px, its calibration says 640x480"));
  frame.calibration = nullptr;
  EXPECT_FALSE(melting.add(frame, Eigen::Isometry3d::Identity(), 1.0, 0).has_value());
}

TEST(TextureFusion, DoesNotBakeInWhatStandsBeforeTheSkin) {
  // The hand stays where it is; what it hides stays unseen, and no part of it is taken for skin.
  const auto clean = camera("path=orbit,fps=2");
  const auto handed = camera("path=orbit,fps=2,clutter=hand");
  auto without = fusion();
  auto with = fusion();
  for (std::uint64_t id = 0; id < 40; ++id) {
    melt(without, *clean, id);
    melt(with, *handed, id);
  }
  const auto texture = with.texture();
  const auto off = differences(texture, without.texture());
  ASSERT_GT(off.size(), 10'000U);
  EXPECT_LT(share_at(off, 0.5), 5.0);
  // The glove is blue-green: half as bright in red as skin. Nothing of it shows.
  EXPECT_LT(share_at(off, 0.99), 30.0);
}

TEST(TextureFusion, LevelsExposureAndWhiteBalance) {
  const auto steady = camera("path=orbit,fps=2");
  const auto swinging = camera("path=orbit,fps=2,exposure=0.5");
  auto expected = fusion();
  auto melting = fusion();
  for (std::uint64_t id = 0; id < 30; ++id) {
    melt(expected, *steady, id);
    melt(melting, *swinging, id);
  }
  const auto off = differences(melting.texture(), expected.texture());
  EXPECT_LT(share_at(off, 0.5), 4.0);
  EXPECT_LT(share_at(off, 0.95), 14.0);
}

TEST(TextureFusion, StaysSharpWhenPosesJitter) {
  const auto from = camera("path=sway,fps=5");
  Jitter jitter;
  auto melting = fusion();
  auto held = fusion({.aligns_frames = false});
  auto single = fusion();
  melt(single, *from, 20);
  std::vector<double> shifts;
  for (std::uint64_t id = 0; id < 40; ++id) {
    const auto frame = from->frame_at(id);
    const auto pose = jitter(from->ct_from_camera(id));
    ASSERT_TRUE(melting.add(*frame, pose, 1.5, 0).has_value());
    ASSERT_TRUE(held.add(*frame, pose, 1.5, 0).has_value());
  }
  const auto energies = gradient_energies({melting.texture(), single.texture()});
  EXPECT_GT(energies[0], 0.9 * energies[1]);
  // Aligned, the frames agree with each other better than as they were tracked.
  const auto texture = melting.texture();
  const auto scatter = [&](const SkinTexture& of) {
    std::vector<double> off;
    const Eigen::Vector3d tip(0, -100, 0);
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    std::vector<Eigen::Vector3d> all;
    for (const auto& entry : of.frames) {
      const auto truth = from->ct_from_camera(entry.frame_id);
      all.emplace_back(entry.ct_from_color * truth.inverse() * tip - tip);
      mean += all.back();
    }
    mean /= static_cast<double>(all.size());
    double sum = 0.0;
    for (const auto& each : all) sum += (each - mean).head<1>().squaredNorm();
    return std::sqrt(sum / static_cast<double>(all.size()));
  };
  ASSERT_GT(texture.frames.size(), 3U);
  EXPECT_LT(scatter(texture), 0.5 * scatter(held.texture()));
}

/// Out of focus: each pixel the mean of those around it.
RgbdFrame blurred(const RgbdFrame& frame) {
  RgbdFrame result = frame;
  constexpr int kRadius = 3;
  for (int y = kRadius; y + kRadius < frame.color.height(); ++y) {
    for (int x = kRadius; x + kRadius < frame.color.width(); ++x) {
      Eigen::Vector3i sum = Eigen::Vector3i::Zero();
      for (int dy = -kRadius; dy <= kRadius; ++dy) {
        for (int dx = -kRadius; dx <= kRadius; ++dx) {
          const auto& [r, g, b] = frame.color(x + dx, y + dy);
          sum += Eigen::Vector3i(r, g, b);
        }
      }
      sum /= (2 * kRadius + 1) * (2 * kRadius + 1);
      result.color(x, y) = {static_cast<std::uint8_t>(sum.x()),
                            static_cast<std::uint8_t>(sum.y()),
                            static_cast<std::uint8_t>(sum.z())};
    }
  }
  return result;
}

TEST(TextureFusion, SharpensWhenASharperPictureComesAndStaysSharp) {
  const auto from = camera("path=still");
  auto sharp = fusion();
  melt(sharp, *from, 0);
  auto melting = fusion();
  const auto pose = from->ct_from_camera(0);
  EXPECT_EQ(melting.add(blurred(*from->frame_at(0)), pose, 0.5, 0).value(), FusionOutcome::kFused);
  const auto soft = melting.texture();
  EXPECT_EQ(melt(melting, *from, 1), FusionOutcome::kFused);
  const auto first = gradient_energies({soft, melting.texture(), sharp.texture()});
  EXPECT_LT(first[0], 0.5 * first[2]);
  EXPECT_GT(first[1], 0.9 * first[2]);
  // A blurred one after it gives what was not seen at all, and nothing else.
  ASSERT_TRUE(melting.add(blurred(*from->frame_at(2)), pose, 0.5, 0).has_value());
  const auto last = gradient_energies({melting.texture(), sharp.texture()});
  EXPECT_GT(last[0], 0.9 * last[1]);
}

TEST(TextureFusion, TakesTwoCamerasThatLookFromDifferentPlaces) {
  // Depth from a quarter of an orbit further than colour: each is right at its own pose.
  const auto from = camera("path=orbit,fps=2");
  const auto color = from->frame_at(0);
  const auto depth = from->frame_at(16);
  RgbdFrame frame = *color;
  frame.depth_mm = depth->depth_mm;
  auto calibration = *color->calibration;
  calibration.color_from_depth = from->ct_from_camera(0).inverse() * from->ct_from_camera(16);
  frame.calibration = std::make_shared<const RgbdCalibration>(calibration);
  auto melting = fusion();
  ASSERT_EQ(melting.add(frame, from->ct_from_camera(16), 0.5, 0).value(), FusionOutcome::kFused);
  auto expected = fusion();
  melt(expected, *from, 0);
  const auto texture = melting.texture();
  EXPECT_TRUE(texture.frames[0].ct_from_color.isApprox(from->ct_from_camera(0), 1e-5));
  EXPECT_GT(seen_share(texture), 0.5 * seen_share(expected.texture()));
  EXPECT_LT(share_at(differences(texture, expected.texture()), 0.99), 6.0);
}

TEST(TextureFusion, UndoesLensDistortion) {
  const auto from = camera("path=still,noise=0");
  const RgbdFrame ideal = *from->frame_at(0);
  // The colour camera looks past the body, which lies where the lens bends by some pixels.
  auto calibration = *ideal.calibration;
  const Eigen::AngleAxisd turned(0.33, Eigen::Vector3d::UnitY());
  calibration.color_from_depth = turned * calibration.color_from_depth;
  const auto straight = calibration;
  calibration.color.distortion = {-0.28, 0.09, 0.001, -0.0008, 0.0};
  RgbdFrame bent = ideal;
  bent.calibration = std::make_shared<const RgbdCalibration>(calibration);
  for (int y = 0; y < ideal.color.height(); ++y) {
    for (int x = 0; x < ideal.color.width(); ++x) {
      const Eigen::Vector2d ray = calibration.color.ray({x, y});
      const Eigen::Vector3d as_before = turned.inverse() * Eigen::Vector3d(ray.x(), ray.y(), 1.0);
      const auto at = ideal.calibration->color.project(as_before).value_or(Eigen::Vector2d(-9, -9));
      const int column = static_cast<int>(std::lround(at.x()));
      const int row = static_cast<int>(std::lround(at.y()));
      const bool is_inside = ideal.color.view().contains(column, row);
      bent.color(x, y) = is_inside ? ideal.color(column, row) : Rgb8{};
    }
  }
  auto expected = fusion();
  ASSERT_EQ(melt(expected, *from, 0), FusionOutcome::kFused);
  auto melting = fusion();
  ASSERT_EQ(melting.add(bent, from->ct_from_camera(0), 0.5, 0).value(), FusionOutcome::kFused);
  const auto off = differences(melting.texture(), expected.texture());
  ASSERT_GT(off.size(), 5'000U);
  EXPECT_LT(share_at(off, 0.9), 10.0) << "a pixel of rounding, no more";
  // Read as if the lens were straight, the same picture lies out of place.
  bent.calibration = std::make_shared<const RgbdCalibration>(straight);
  auto unaware = fusion();
  ASSERT_EQ(unaware.add(bent, from->ct_from_camera(0), 0.5, 0).value(), FusionOutcome::kFused);
  const auto out_of_place = differences(unaware.texture(), expected.texture());
  EXPECT_GT(share_at(out_of_place, 0.9), 2.0 * share_at(off, 0.9));
}

TEST(TextureFusion, UsesAFinerColourCameraFully) {
  const auto depth = camera("path=still,seed=3")->frame_at(0);
  const auto fine = camera("path=still,seed=3,width=1280,height=960");
  RgbdFrame frame = *fine->frame_at(0);
  frame.depth_mm = depth->depth_mm;
  frame.calibration = std::make_shared<const RgbdCalibration>(RgbdCalibration{
      depth->calibration->depth, frame.calibration->color, Eigen::Isometry3d::Identity()});
  auto melting = fusion();
  ASSERT_EQ(melting.add(frame, fine->ct_from_camera(0), 0.5, 0).value(), FusionOutcome::kFused);
  auto coarse = fusion();
  ASSERT_EQ(coarse.add(*depth, fine->ct_from_camera(0), 0.5, 0).value(), FusionOutcome::kFused);
  const auto energies = gradient_energies({melting.texture(), coarse.texture()});
  EXPECT_GT(energies[0], 1.1 * energies[1]);
}

TEST(TextureFusion, TakesColourPicturesOfOddSizes) {
  for (const char* keys : {"path=still,width=641,height=479", "path=still,width=1281,height=721"}) {
    const auto from = camera(keys);
    auto melting = fusion();
    EXPECT_EQ(melt(melting, *from, 0), FusionOutcome::kFused) << keys;
  }
}

TEST(TextureFusion, GoesOnFromASavedTexture) {
  const auto from = camera("path=orbit,fps=1");
  auto melting = fusion();
  for (std::uint64_t id = 0; id < 6; ++id) melt(melting, *from, id);
  const auto folder = std::filesystem::path(::testing::TempDir()) / "goes_on";
  ASSERT_TRUE(write_skin_texture(folder, melting.texture()).has_value());
  const auto saved = read_skin_texture(folder);
  ASSERT_TRUE(saved.has_value());
  auto later = fusion();
  ASSERT_TRUE(later.restore(*saved).has_value());
  const auto again = differences(later.texture(), *saved);
  EXPECT_LE(again.back(), 1.0) << "restoring changes no colour";
  for (std::uint64_t id = 20; id < 26; ++id) melt(later, *from, id);
  EXPECT_GT(later.num_frames(), 6U);
  EXPECT_GT(seen_share(later.texture()), seen_share(*saved));
  auto other = *saved;
  auto moved = *other.atlas;
  moved.corners_px[0][0].x() += 0.5F;
  other.atlas = std::make_shared<const SkinAtlas>(moved);
  const auto refused = later.restore(other);
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message, HasSubstr("another skin"));
}

TEST(TextureFusion, ForgetsEverything) {
  const auto from = camera("path=still");
  auto melting = fusion();
  melt(melting, *from, 0);
  melting.clear();
  EXPECT_EQ(melting.num_frames(), 0U);
  EXPECT_EQ(seen_share(melting.texture()), 0.0);
}

TEST(SkinCoverage, GrowsFromNothingAndCountsTheBackAsUnseen) {
  const SkinCoverage coverage(atlas());
  auto melting = fusion();
  EXPECT_EQ(coverage.share(melting.texture()), 0.0);
  const auto from = camera("path=still,noise=0");
  melt(melting, *from, 0);
  const double share = coverage.share(melting.texture());
  EXPECT_GT(share, 0.2);
  EXPECT_LT(share, 0.5);
  // All of an egg can be seen from somewhere.
  std::size_t reachable = 0;
  for (std::size_t i = 0; i < skin()->triangles.size(); ++i) reachable += coverage.could_be_seen(i);
  EXPECT_GT(reachable, skin()->triangles.size() * 97 / 100);
}

TEST(TextureView, ShowsTheFrontSeenAndTheBackMissing) {
  const auto from = camera("path=still,noise=0");
  auto melting = fusion();
  melt(melting, *from, 0);
  const auto sides = draw_four_sides(melting.texture(), 100, 140);
  ASSERT_EQ(sides.width(), 400);
  const auto orange = [&](int first_x) {
    int count = 0;
    for (int y = 0; y < 140; ++y) {
      for (int x = first_x; x < first_x + 100; ++x) {
        const auto& [r, g, b] = sides(x, y);
        count += r > 2 * b && r > 100 && g > 90 * r / 200 ? 1 : 0;
      }
    }
    return count;
  };
  EXPECT_LT(orange(0), orange(200) / 3);
  EXPECT_EQ(sides(0, 0), (Rgb8{255, 255, 255}));
}

}  // namespace
}  // namespace mor
