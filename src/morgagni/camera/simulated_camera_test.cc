// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/simulated_camera.h"

#include <array>
#include <cmath>
#include <numbers>
#include <thread>

#include <gmock/gmock.h>

namespace mor {
namespace {

using testing::HasSubstr;

/// A ball of 80 mm radius, one kind of head.
std::shared_ptr<const TriangleMesh> head() {
  auto mesh = std::make_shared<TriangleMesh>();
  constexpr unsigned kRings = 60;
  constexpr unsigned kColumns = 120;
  for (unsigned ring = 0; ring <= kRings; ++ring) {
    for (unsigned column = 0; column < kColumns; ++column) {
      const double polar = std::numbers::pi * ring / kRings;
      const double azimuth = 2.0 * std::numbers::pi * column / kColumns;
      const Eigen::Vector3d direction(std::sin(polar) * std::cos(azimuth),
                                      std::sin(polar) * std::sin(azimuth),
                                      std::cos(polar));
      mesh->vertices.push_back(
          (Eigen::Vector3d(40.0, -120.0, 75.0) + 80.0 * direction).cast<float>());
    }
  }
  for (unsigned ring = 0; ring < kRings; ++ring) {
    for (unsigned column = 0; column < kColumns; ++column) {
      const unsigned next = (column + 1) % kColumns;
      const unsigned a = ring * kColumns + column;
      const unsigned b = ring * kColumns + next;
      mesh->triangles.push_back({a, a + kColumns, b});
      mesh->triangles.push_back({b, a + kColumns, b + kColumns});
    }
  }
  return mesh;
}

std::unique_ptr<SimulatedCamera> open(const SimulatedCameraOptions& options) {
  return SimulatedCamera::create(head(), options).value();
}

TEST(SimulatedCameraOptions, ReadEveryKey) {
  const auto options = SimulatedCameraOptions::parse(
      "seed=7,width=320,height=240,fps=15,distance=650,path=sway,clutter=towel,bias=2.5,focal=-1,"
      "noise=0,frames=9,speed=full,exposure=0.3,skin=marked,table=1.5");
  ASSERT_TRUE(options) << options.error().message;
  EXPECT_EQ(options->seed, 7U);
  EXPECT_EQ(options->width_px, 320);
  EXPECT_EQ(options->height_px, 240);
  EXPECT_EQ(options->frames_per_s, 15.0);
  EXPECT_EQ(options->distance_mm, 650.0);
  EXPECT_EQ(options->path, SimulatedPath::kSway);
  EXPECT_EQ(options->clutter, SimulatedClutter::kTowel);
  EXPECT_EQ(options->bias_mm, 2.5);
  EXPECT_EQ(options->focal_error_percent, -1.0);
  EXPECT_FALSE(options->has_noise);
  EXPECT_EQ(options->num_frames, 9U);
  EXPECT_FALSE(options->is_real_time);
  EXPECT_EQ(options->exposure_swing, 0.3);
  EXPECT_EQ(options->table_uneven_mm, 1.5);
  EXPECT_EQ(options->skin, SimulatedSkin::kMarked);
  EXPECT_TRUE(SimulatedCameraOptions::parse(""));
}

TEST(SimulatedCameraOptions, NameTheBadKeyOrValueAndWhatIsAllowed) {
  const auto error_of = [](const char* text) {
    const auto options = SimulatedCameraOptions::parse(text);
    return options ? "accepted" : options.error().message;
  };
  EXPECT_THAT(error_of("sed=1"), AllOf(HasSubstr("'sed'"), HasSubstr("seed, width")));
  EXPECT_THAT(error_of("seed"), HasSubstr("'seed' must be written key=value"));
  EXPECT_THAT(error_of("seed=-1"), HasSubstr("seed must be in"));
  EXPECT_THAT(error_of("seed=99999999999999999999999"), HasSubstr("seed must be in"));
  EXPECT_THAT(error_of("width=63"), HasSubstr("width must be in [64, 1920], got '63'"));
  EXPECT_THAT(error_of("height=99999"), HasSubstr("height must be in"));
  EXPECT_THAT(error_of("fps=nan"), HasSubstr("fps must be in"));
  EXPECT_THAT(error_of("fps=0"), HasSubstr("fps must be in"));
  EXPECT_THAT(error_of("distance=60 cm"), HasSubstr("distance must be in"));
  EXPECT_THAT(error_of("path=spiral"),
              HasSubstr("one of orbit, sway, still, views, pass, sweep, got 'spiral'"));
  EXPECT_THAT(error_of("walk=5"), HasSubstr("walk must be in [10, 1000], got '5'"));
  EXPECT_THAT(error_of("hold=0"), HasSubstr("hold must be in [1, 1000], got '0'"));
  for (const auto& wrong :
       {SimulatedCameraOptions{.frames_a_view = 2}, SimulatedCameraOptions{.walk_mm = 300.0}})
    EXPECT_THAT(wrong.check().error().message, HasSubstr("of path=views alone"));
  EXPECT_THAT(error_of("clutter=cat"),
              HasSubstr("one of none, hand, towel, parts, all, got 'cat'"));
  EXPECT_THAT(error_of("bias=-1"), HasSubstr("bias must be in [0, 20], got '-1'"));
  EXPECT_THAT(error_of("bias=inf"), HasSubstr("bias must be in"));
  EXPECT_THAT(error_of("focal=6"), HasSubstr("focal must be in [-5, 5], got '6'"));
  EXPECT_THAT(error_of("exposure=1"), HasSubstr("exposure must be in [0, 0.6], got '1'"));
  EXPECT_THAT(error_of("table=6"), HasSubstr("table must be in [0, 5], got '6'"));
  EXPECT_THAT(error_of("noise=yes"), HasSubstr("noise must be one of 0, 1"));
  EXPECT_THAT(error_of("speed=fast"), HasSubstr("real, full"));
}

TEST(SimulatedCamera, NeedsASkinAndGoodOptions) {
  EXPECT_THAT(SimulatedCamera::create(nullptr, {}).error().message, HasSubstr("skin"));
  EXPECT_THAT(SimulatedCamera::create(std::make_shared<TriangleMesh>(), {}).error().message,
              HasSubstr("skin"));
  EXPECT_THAT(SimulatedCamera::create(head(), {.width_px = 1}).error().message, HasSubstr("width"));
  EXPECT_THAT(SimulatedCamera::create(head(), {.frames_per_s = NAN}).error().message,
              HasSubstr("fps"));
  EXPECT_THAT(SimulatedCamera::create(head(), {.bias_mm = NAN}).error().message, HasSubstr("bias"));
  EXPECT_THAT(SimulatedCamera::create(head(), {.focal_error_percent = 9.0}).error().message,
              HasSubstr("focal"));
}

TEST(SimulatedCamera, SeesTheSkinWhereTheTruthPutsIt) {
  const auto camera = open({.has_noise = false});
  for (const std::uint64_t id : {0U, 100U, 1000U}) {
    const auto frame = camera->frame_at(id);
    const auto ct_from_camera = camera->ct_from_camera(id);
    int num_on_skin = 0;
    for (int y = 0; y < 480; y += 4) {
      for (int x = 0; x < 640; x += 4) {
        const double z_mm = frame->depth_mm(x, y);
        const Eigen::Vector2d ray = camera->calibration().depth.ray({x, y});
        const Eigen::Vector3d p =
            ct_from_camera * Eigen::Vector3d(ray.x() * z_mm, ray.y() * z_mm, z_mm);
        const double off_skin_mm = (p - Eigen::Vector3d(40.0, -120.0, 75.0)).norm() - 80.0;
        const double off_table_mm = std::abs(p.y() + 40.0);
        const double off_floor_mm = std::abs(p.y() - 740.0);
        // Half a millimetre of rounding, and the ball's facets.
        EXPECT_LT(std::min({std::abs(off_skin_mm), off_table_mm, off_floor_mm}), 1.0);
        num_on_skin += std::abs(off_skin_mm) < 1.0 ? 1 : 0;
      }
    }
    EXPECT_GT(num_on_skin, 300);
  }
}

TEST(SimulatedCamera, AnUnevenTableLiesInLongWavesAboutTheLevelOne) {
  const auto level = open({.has_noise = false});
  const auto uneven = open({.table_uneven_mm = 3.0, .has_noise = false});
  const auto frames = std::array{level->frame_at(0), uneven->frame_at(0)};
  const auto ct_from_camera = level->ct_from_camera(0);
  double squares = 0.0;
  int count = 0;
  for (int y = 0; y < 480; y += 4) {
    for (int x = 0; x < 640; x += 4) {
      const Eigen::Vector2d ray = level->calibration().depth.ray({x, y});
      const auto place = [&](double z_mm) {
        return Eigen::Vector3d(ct_from_camera *
                               Eigen::Vector3d(ray.x() * z_mm, ray.y() * z_mm, z_mm));
      };
      const Eigen::Vector3d on_level = place(frames[0]->depth_mm(x, y));
      const double up_mm = on_level.y() - place(frames[1]->depth_mm(x, y)).y();
      const bool is_table = std::abs(on_level.y() + 40.0) < 1.0;
      EXPECT_LT(std::abs(up_mm), is_table ? 12.0 : 0.01);
      if (!is_table) continue;
      squares += up_mm * up_mm;
      ++count;
    }
  }
  ASSERT_GT(count, 1000);
  EXPECT_NEAR(std::sqrt(squares / count), 3.0, 1.5);
}

TEST(SimulatedCamera, SeesClutterInFrontOfWhatItHides) {
  const auto plain = open({.path = SimulatedPath::kViews, .has_noise = false});
  for (const auto kind :
       {SimulatedClutter::kHand, SimulatedClutter::kTowel, SimulatedClutter::kAll}) {
    const auto cluttered =
        open({.path = SimulatedPath::kViews, .clutter = kind, .has_noise = false});
    int num_hidden = 0;
    for (std::uint64_t id = 0; id < 4; ++id) {
      ASSERT_TRUE(plain->ct_from_camera(id).isApprox(cluttered->ct_from_camera(id), 0.0));
      const auto without = plain->frame_at(id);
      const auto with = cluttered->frame_at(id);
      for (std::size_t i = 0; i < with->depth_mm.size(); ++i) {
        const int before_mm = without->depth_mm.data()[i];
        const int now_mm = with->depth_mm.data()[i];
        if (now_mm == before_mm) continue;
        ASSERT_TRUE(before_mm == 0 || now_mm < before_mm);
        num_hidden += without->color.data()[i] == with->color.data()[i] ? 0 : 1;
      }
    }
    EXPECT_GT(num_hidden, 4000) << static_cast<int>(kind);
  }
}

TEST(SimulatedCamera, BendsDepthByItsBiasAndNothingElse) {
  const auto plain = open({.has_noise = false});
  const auto biased = open({.bias_mm = 4.0, .has_noise = false});
  const auto without = plain->frame_at(0);
  const auto with = biased->frame_at(0);
  EXPECT_EQ(without->color, with->color);
  double squares = 0.0;
  for (std::size_t i = 0; i < with->depth_mm.size(); ++i) {
    const double z_mm = without->depth_mm.data()[i];
    const double error_mm = (with->depth_mm.data()[i] - z_mm) * 800.0 / z_mm;
    squares += error_mm * error_mm;
  }
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(with->depth_mm.size())), 4.0, 0.1);
}

TEST(SimulatedCamera, StatesAFocalLengthThatIsOffWhenAsked) {
  const auto camera = open({.focal_error_percent = 2.0, .has_noise = false});
  EXPECT_NEAR(camera->calibration().depth.focal_x_px, 525.0 * 1.02, 1e-9);
  EXPECT_EQ(camera->frame_at(0)->depth_mm, open({.has_noise = false})->frame_at(0)->depth_mm);
}

TEST(SimulatedCamera, StandsStillWhereAskedTo) {
  const auto camera = open({.path = SimulatedPath::kStill});
  EXPECT_TRUE(camera->ct_from_camera(0).isApprox(camera->ct_from_camera(999), 0.0));
}

TEST(SimulatedCamera, LooksFromAnotherPlaceInEveryFrameOfViews) {
  const auto camera = open({.path = SimulatedPath::kViews, .has_noise = false});
  const auto first = camera->ct_from_camera(0);
  const auto second = camera->ct_from_camera(1);
  EXPECT_GT((first.translation() - second.translation()).norm(), 50.0);
  const auto seen = camera->frame_at(1);
  int num_on_skin = 0;
  for (int y = 0; y < 480; y += 2) {
    for (int x = 0; x < 640; x += 2) {
      const double z_mm = seen->depth_mm(x, y);
      const Eigen::Vector2d ray = camera->calibration().depth.ray({x, y});
      const Eigen::Vector3d p = second * Eigen::Vector3d(ray.x() * z_mm, ray.y() * z_mm, z_mm);
      const double off_mm = (p - Eigen::Vector3d(40.0, -120.0, 75.0)).norm() - 80.0;
      num_on_skin += z_mm > 0.0 && std::abs(off_mm) < 1.0 ? 1 : 0;
    }
  }
  EXPECT_GT(num_on_skin, 600);
}

TEST(SimulatedCamera, HoldsAViewForAsManyFramesAsAsked) {
  const auto brief = open({.path = SimulatedPath::kViews, .clutter = SimulatedClutter::kAll});
  const auto held = open({.frames_per_s = 5.0,
                          .path = SimulatedPath::kViews,
                          .frames_a_view = 4,
                          .clutter = SimulatedClutter::kAll});
  for (const std::uint64_t view : {0, 1, 7}) {
    EXPECT_TRUE(held->ct_from_camera(4 * view).isApprox(brief->ct_from_camera(view), 0.0));
    const Eigen::Isometry3d moved =
        held->ct_from_camera(4 * view).inverse() * held->ct_from_camera(4 * view + 3);
    EXPECT_GT(moved.translation().norm(), 10.0);
    EXPECT_LT(moved.translation().norm(), 100.0);
  }
}

TEST(SimulatedCamera, GivesTheSameFrameInWhateverOrderItIsAsked) {
  const auto camera = open({.seed = 5, .width_px = 320, .height_px = 240});
  const auto first = camera->frame_at(3);
  (void)camera->frame_at(70);
  const auto again = open({.seed = 5, .width_px = 320, .height_px = 240})->frame_at(3);
  EXPECT_EQ(first->depth_mm, again->depth_mm);
  EXPECT_EQ(first->color, again->color);
  const auto other = open({.seed = 6, .width_px = 320, .height_px = 240})->frame_at(3);
  EXPECT_FALSE(first->depth_mm == other->depth_mm);
}

TEST(SimulatedCamera, CountsEveryFrameAtFullSpeedAndEnds) {
  const auto camera =
      open({.width_px = 64, .height_px = 48, .num_frames = 5, .is_real_time = false});
  for (std::uint64_t id = 0; id < 5; ++id) {
    const auto frame = camera->next_frame({});
    ASSERT_TRUE(frame && *frame);
    EXPECT_EQ((*frame)->frame_id, id);
    EXPECT_EQ((*frame)->depth_mm, camera->frame_at(id)->depth_mm);
  }
  EXPECT_EQ(camera->next_frame({}).value(), nullptr);
}

TEST(SimulatedCamera, IsPacedByTheClockAndSkipsWhatASlowCallerMissed) {
  const auto camera = open({.width_px = 64, .height_px = 48, .frames_per_s = 50.0});
  const auto first = camera->next_frame({}).value();
  const auto second = camera->next_frame({}).value();
  EXPECT_EQ(first->frame_id, 0U);
  EXPECT_EQ(second->captured_at - first->captured_at,
            std::chrono::milliseconds(20) * (second->frame_id - first->frame_id));
  EXPECT_GE(std::chrono::steady_clock::now(), second->captured_at);
  std::this_thread::sleep_for(std::chrono::milliseconds(110));  // A caller that is busy.
  EXPECT_GE(camera->next_frame({}).value()->frame_id, second->frame_id + 5);
}

TEST(SimulatedCamera, StopsWaitingWhenAsked) {
  const auto camera = open({.width_px = 64, .height_px = 48, .frames_per_s = 1.0});
  ASSERT_TRUE(camera->next_frame({}).value());
  std::stop_source stop;
  const auto begin = std::chrono::steady_clock::now();
  const std::jthread stopper([&] { stop.request_stop(); });
  EXPECT_EQ(camera->next_frame(stop.get_token()).value(), nullptr);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(800));
}

}  // namespace
}  // namespace mor
