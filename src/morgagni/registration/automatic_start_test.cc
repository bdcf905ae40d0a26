// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/automatic_start.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/geometry/depth_raster.h"
#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/testing/test_body.h"

namespace mor {
namespace {

using Picture = Image<std::uint16_t>;

const PinholeCamera kCamera{320, 240, 262.0, 262.0, 159.5, 119.5, {}};

/// The bumpy body with a head and a hip of its own: without them its two ends look alike.
std::shared_ptr<const FixedSurface> lopsided_surface() {
  auto surface = std::make_shared<FixedSurface>();
  surface->mesh = internal::bumpy_body(80, Eigen::Vector3f::Zero());
  for (auto& vertex : surface->mesh.vertices) {
    const Eigen::Vector3f d = vertex.normalized();
    const auto near = [&d](const Eigen::Vector3f& at) {
      return std::exp(-(d - at.normalized()).squaredNorm() / 0.18F);
    };
    vertex += 60.0F * near({0.3F, -0.2F, 0.9F}) * Eigen::Vector3f(0.3F, -0.1F, 0.9F) +
              45.0F * near({-0.9F, -0.2F, -0.4F}) * Eigen::Vector3f(-1.0F, 0.0F, -0.2F) +
              Eigen::Vector3f(30.0F, -200.0F, 400.0F);
  }
  surface->mesh.normals = vertex_normals(surface->mesh);
  surface->field = *DistanceField::build(surface->mesh);
  return surface;
}

/// The body with a table of 1.4 x 1.8 m below, y down. In small pieces: the raster drops triangles
/// that reach behind the camera.
TriangleMesh on_table(TriangleMesh body) {
  constexpr int kPieces = 12;
  const Eigen::AlignedBox3f bounds = body.bounds();
  const Eigen::Vector3f center = bounds.center();
  const auto first = static_cast<std::uint32_t>(body.vertices.size());
  for (int row = 0; row <= kPieces; ++row) {
    for (int column = 0; column <= kPieces; ++column) {
      const float x = 1400.0F * (static_cast<float>(column) / kPieces - 0.5F);
      const float z = 1800.0F * (static_cast<float>(row) / kPieces - 0.5F);
      body.vertices.emplace_back(center.x() + x, bounds.max().y(), center.z() + z);
    }
  }
  for (std::uint32_t row = 0; row < kPieces; ++row) {
    for (std::uint32_t column = 0; column < kPieces; ++column) {
      const std::uint32_t corner = first + row * (kPieces + 1) + column;
      body.triangles.push_back({corner, corner + 1, corner + kPieces + 1});
      body.triangles.push_back({corner + 1, corner + kPieces + 2, corner + kPieces + 1});
    }
  }
  return body;
}

/// What a camera at `ct_from_depth` measures of `mesh`, with some noise.
Picture picture_of(const TriangleMesh& mesh, const Eigen::Isometry3d& ct_from_depth) {
  const DepthRaster raster = rasterize_depth(mesh, kCamera, ct_from_depth.inverse());
  std::mt19937 random(7);
  Picture picture(kCamera.width_px, kCamera.height_px, 0);
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const float z = raster.depth_mm.data()[i];
    const float noise_mm = static_cast<float>(random() % 401) / 100.0F - 2.0F;
    if (z > 0.0F) picture.data()[i] = static_cast<std::uint16_t>(std::lround(z + noise_mm));
  }
  return picture;
}

/// A camera that looks at `target` from above, `tilt_rad` from straight down.
Eigen::Isometry3d looking_at(const Eigen::Vector3d& target,
                             double azimuth_rad,
                             double tilt_rad,
                             double roll_rad,
                             double distance_mm) {
  const Eigen::Vector3d to_camera(std::sin(tilt_rad) * std::cos(azimuth_rad),
                                  -std::cos(tilt_rad),
                                  std::sin(tilt_rad) * std::sin(azimuth_rad));
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear().col(2) = -to_camera;
  pose.linear().col(0) = to_camera.unitOrthogonal();
  pose.linear().col(1) = pose.linear().col(2).cross(pose.linear().col(0));
  pose.linear() *= Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() = target + distance_mm * to_camera;
  return pose;
}

class AutomaticStartOfTestBody : public testing::Test {
 protected:
  static void SetUpTestSuite() { body_ = lopsided_surface(); }
  static void TearDownTestSuite() { body_.reset(); }

  [[nodiscard]] static AutomaticStart starter(const AutomaticStartOptions& options = {}) {
    auto start = AutomaticStart::create(body_, kCamera, options);
    EXPECT_TRUE(start) << start.error().message;
    return std::move(*start);
  }
  [[nodiscard]] static Eigen::Vector3d center() {
    return body_->mesh.bounds().center().cast<double>();
  }

  static std::shared_ptr<const FixedSurface> body_;
};

std::shared_ptr<const FixedSurface> AutomaticStartOfTestBody::body_;

TEST_F(AutomaticStartOfTestBody, IsRightFromManySides) {
  const auto start = starter();
  const TriangleMesh scene = on_table(body_->mesh);
  for (int i = 0; i < 6; ++i) {
    const auto truth = looking_at(center(), 1.1 * i, 0.2 * i, 2.3 * i, 600.0 + 80.0 * i);
    const auto result = start.find(picture_of(scene, truth).view());
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_EQ(result->status, AutomaticStartStatus::kFound)
        << "view " << i << ": " << result->reason;
    EXPECT_LT(displacement_mm(result->ct_from_depth, truth, truth.inverse() * center()), 3.0)
        << "view " << i;
    EXPECT_LT(rotation_angle_rad(result->ct_from_depth * truth.inverse()), 0.05) << "view " << i;
  }
}

/// What the starter says of `scene` from three sides; the last status that is not `expected` fails.
void expect_from_all_sides(const AutomaticStart& start,
                           const TriangleMesh& scene,
                           const Eigen::Vector3d& target,
                           const testing::Matcher<AutomaticStartStatus>& expected) {
  for (int i = 0; i < 3; ++i) {
    const auto camera = looking_at(target, 0.4 + 2.0 * i, 0.15 + 0.4 * i, 1.9 * i, 700.0);
    const auto result = start.find(picture_of(scene, camera).view());
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_THAT(result->status, expected) << "view " << i << ", scores " << result->score << " and "
                                          << result->runner_up_score << ": " << result->reason;
    EXPECT_EQ(result->reason.empty(), result->status == AutomaticStartStatus::kFound);
  }
}

TEST_F(AutomaticStartOfTestBody, RefusesTheMirroredBody) {
  TriangleMesh mirrored = body_->mesh;
  const auto twice_center = 2.0F * body_->mesh.bounds().center().x();
  for (auto& vertex : mirrored.vertices) vertex.x() = twice_center - vertex.x();
  expect_from_all_sides(
      starter(), on_table(mirrored), center(), testing::Ne(AutomaticStartStatus::kFound));
}

TEST_F(AutomaticStartOfTestBody, RefusesAnotherBody) {
  TriangleMesh other = body_->mesh;
  for (auto& vertex : other.vertices) {
    vertex = center().cast<float>() +
             Eigen::Vector3f(1.3F, 0.8F, 0.7F).cwiseProduct(vertex - center().cast<float>());
  }
  expect_from_all_sides(
      starter(), on_table(other), center(), testing::Ne(AutomaticStartStatus::kFound));
}

TEST_F(AutomaticStartOfTestBody, RefusesAnEmptyTableAndAWall) {
  TriangleMesh table = on_table(body_->mesh);
  const auto num_body = static_cast<std::ptrdiff_t>(body_->mesh.triangles.size());
  table.triangles.erase(table.triangles.begin(), table.triangles.begin() + num_body);
  expect_from_all_sides(starter(), table, center(), AutomaticStartStatus::kNotFound);
  const Picture wall(kCamera.width_px, kCamera.height_px, 900);
  const auto result = starter().find(wall.view());
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, AutomaticStartStatus::kNotFound);
}

TEST_F(AutomaticStartOfTestBody, IsRightBelowASlabThatHidesAThird) {
  TriangleMesh scene = on_table(body_->mesh);
  const Eigen::Vector3f above = center().cast<float>() - Eigen::Vector3f(0.0F, 180.0F, 0.0F);
  const auto first = static_cast<std::uint32_t>(scene.vertices.size());
  for (const auto& [x, z] :
       {std::pair{-400.0F, 40.0F}, {400.0F, 40.0F}, {400.0F, 120.0F}, {-400.0F, 120.0F}}) {
    scene.vertices.push_back(above + Eigen::Vector3f(x, 0.0F, z));
  }
  scene.triangles.push_back({first, first + 1, first + 2});
  scene.triangles.push_back({first, first + 2, first + 3});
  const auto truth = looking_at(center(), 0.9, 0.3, 2.0, 800.0);
  const auto result = starter().find(picture_of(scene, truth).view());
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, AutomaticStartStatus::kFound) << result->reason;
  EXPECT_LT(displacement_mm(result->ct_from_depth, truth, truth.inverse() * center()), 3.0);
}

TEST_F(AutomaticStartOfTestBody, TakesNoPlaneForATableThatGravityForbids) {
  const auto truth = looking_at(center(), 0.7, 0.6, 1.0, 800.0);
  const Picture picture = picture_of(on_table(body_->mesh), truth);
  const Eigen::Vector3d down = truth.linear().transpose() * Eigen::Vector3d::UnitY();
  const auto level = starter({.gravity = 9.81 * down}).find(picture.view());
  ASSERT_TRUE(level);
  EXPECT_EQ(level->status, AutomaticStartStatus::kFound) << level->reason;
  const auto sideways = starter({.gravity = down.unitOrthogonal()}).find(picture.view());
  ASSERT_TRUE(sideways);
  EXPECT_NE(sideways->status, AutomaticStartStatus::kFound);
}

TEST_F(AutomaticStartOfTestBody, NeedsNoTableInThePictureWhereGravityIsKnown) {
  const auto truth = looking_at(center(), 0.7, 0.5, 1.0, 800.0);
  const Picture picture = picture_of(body_->mesh, truth);
  const Eigen::Vector3d down = truth.linear().transpose() * Eigen::Vector3d::UnitY();
  const auto result = starter({.gravity = down}).find(picture.view());
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, AutomaticStartStatus::kFound) << result->reason;
  EXPECT_LT(displacement_mm(result->ct_from_depth, truth, truth.inverse() * center()), 3.0);
  EXPECT_LT(rotation_angle_rad(result->ct_from_depth * truth.inverse()), 0.05);
}

TEST(AutomaticStart, FindsASphereAmbiguous) {
  auto ball = std::make_shared<FixedSurface>();
  ball->mesh = internal::bumpy_body(60, Eigen::Vector3f::Zero());
  for (auto& vertex : ball->mesh.vertices) vertex = 110.0F * vertex.normalized();
  ball->mesh.normals = vertex_normals(ball->mesh);
  ball->field = *DistanceField::build(ball->mesh);
  const auto start = AutomaticStart::create(ball, kCamera, {});
  ASSERT_TRUE(start) << start.error().message;
  expect_from_all_sides(
      *start, on_table(ball->mesh), Eigen::Vector3d::Zero(), AutomaticStartStatus::kAmbiguous);
}

TEST(AutomaticStart, RefusesPicturesTooSmallToTell) {
  const auto surface = internal::bumpy_surface(40);
  const PinholeCamera tiny{4, 3, 3.0, 3.0, 1.5, 1.0, {}};
  const auto start = AutomaticStart::create(surface, tiny, {});
  ASSERT_TRUE(start) << start.error().message;
  const auto result = start->find(Picture(4, 3, 700).view());
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_EQ(result->status, AutomaticStartStatus::kNotFound);
}

TEST_F(AutomaticStartOfTestBody, RefusesAnEmptyPicture) {
  const auto result = starter().find(Picture(kCamera.width_px, kCamera.height_px, 0).view());
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, AutomaticStartStatus::kNotFound);
  EXPECT_FALSE(result->reason.empty());
}

/// Things on the table beside the body, by which a camera sees how it moves.
TriangleMesh with_things(TriangleMesh scene, const Eigen::Vector3f& center) {
  for (const auto& [x, z] : {std::pair{-230.0F, 150.0F}, {240.0F, -60.0F}, {-180.0F, -220.0F}}) {
    const auto first = static_cast<std::uint32_t>(scene.vertices.size());
    const TriangleMesh thing = internal::bumpy_body(24, Eigen::Vector3f::Zero());
    const float scale = 60.0F / thing.bounds().sizes().maxCoeff();
    for (const auto& vertex : thing.vertices) {
      scene.vertices.push_back(center + scale * vertex + Eigen::Vector3f(x, 90.0F, z));
    }
    for (const auto& [a, b, c] : thing.triangles) {
      scene.triangles.push_back({a + first, b + first, c + first});
    }
  }
  return scene;
}

/// A camera that a hand moves on from picture to picture.
Eigen::Isometry3d held(const Eigen::Vector3d& target, int picture) {
  return looking_at(target, 0.7 + 0.02 * picture, 0.5, 1.0 + 0.01 * picture, 800.0 - 6.0 * picture);
}

TEST_F(AutomaticStartOfTestBody, FindsItInTheNextPictureWhereTheFirstShowsNothing) {
  const auto start = starter();
  StartMemory memory;
  const auto first = start.find_next(Picture(320, 240, 0).view(), memory);
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_EQ(first->status, AutomaticStartStatus::kNotFound);
  const auto truth = held(center(), 1);
  const auto second = start.find_next(picture_of(on_table(body_->mesh), truth).view(), memory);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->status, AutomaticStartStatus::kFound) << second->reason;
  EXPECT_LT(displacement_mm(second->ct_from_depth, truth, truth.inverse() * center()), 3.0);
}

TEST_F(AutomaticStartOfTestBody, IsNotBelievedWhereThePictureBeforeContradicts) {
  const auto start = starter();
  const TriangleMesh with_body = with_things(on_table(body_->mesh), center().cast<float>());
  TriangleMesh without = with_body;
  const auto num_body = static_cast<std::ptrdiff_t>(body_->mesh.triangles.size());
  without.triangles.erase(without.triangles.begin(), without.triangles.begin() + num_body);
  StartMemory memory;
  const auto look = [&](const TriangleMesh& scene, int picture) {
    return *start.find_next(picture_of(scene, held(center(), picture)).view(), memory);
  };
  EXPECT_NE(look(without, 0).status, AutomaticStartStatus::kFound);
  // Somebody has laid the body there: in the picture before, the camera looked through it.
  EXPECT_NE(look(with_body, 1).status, AutomaticStartStatus::kFound);
  const auto third = look(with_body, 2);
  EXPECT_EQ(third.status, AutomaticStartStatus::kFound) << third.reason;
  const auto truth = held(center(), 2);
  EXPECT_LT(displacement_mm(third.ct_from_depth, truth, truth.inverse() * center()), 3.0);
  // Nor does anything contradict in a picture that stands alone.
  EXPECT_EQ(look(without, 3).status, AutomaticStartStatus::kNotFound);
  memory.forget();
  EXPECT_EQ(look(with_body, 4).status, AutomaticStartStatus::kFound);
}

TEST_F(AutomaticStartOfTestBody, RefusesTheMirroredBodyInSeveralPicturesAsInOne) {
  TriangleMesh mirrored = body_->mesh;
  const auto twice_center = 2.0F * body_->mesh.bounds().center().x();
  for (auto& vertex : mirrored.vertices) vertex.x() = twice_center - vertex.x();
  const TriangleMesh scene = with_things(on_table(mirrored), center().cast<float>());
  const auto start = starter();
  StartMemory memory;
  for (int picture = 0; picture < 3; ++picture) {
    const auto result = start.find_next(picture_of(scene, held(center(), picture)).view(), memory);
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_NE(result->status, AutomaticStartStatus::kFound) << "picture " << picture;
  }
}

TEST_F(AutomaticStartOfTestBody, IsTheSameForAnyNumberOfThreads) {
  const auto truth = looking_at(center(), 0.7, 0.6, 1.0, 800.0);
  const Picture picture = picture_of(on_table(body_->mesh), truth);
  const auto one = starter({.num_threads = 1}).find(picture.view());
  const auto three = starter({.num_threads = 3}).find(picture.view());
  ASSERT_TRUE(one && three);
  EXPECT_EQ(one->ct_from_depth.matrix(), three->ct_from_depth.matrix());
  EXPECT_EQ(one->score, three->score);
}

TEST_F(AutomaticStartOfTestBody, StopsWhenAsked) {
  const auto truth = looking_at(center(), 0.7, 0.6, 1.0, 800.0);
  std::stop_source source;
  source.request_stop();
  const auto result =
      starter().find(picture_of(on_table(body_->mesh), truth).view(), source.get_token());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kCancelled);
}

TEST_F(AutomaticStartOfTestBody, SaysWhatIsWrongWithItsInput) {
  const auto other_size = starter().find(Picture(100, 80, 0).view());
  ASSERT_FALSE(other_size);
  EXPECT_THAT(other_size.error().message, testing::HasSubstr("320 x 240"));

  const auto refusal = [](const std::shared_ptr<const FixedSurface>& surface,
                          const AutomaticStartOptions& options) {
    const auto start = AutomaticStart::create(surface, kCamera, options);
    return start ? std::string() : start.error().message;
  };
  auto without_field = std::make_shared<FixedSurface>();
  without_field->mesh = body_->mesh;
  EXPECT_THAT(refusal(without_field, {}), testing::HasSubstr("prepare the case"));
  EXPECT_THAT(refusal(nullptr, {}), testing::HasSubstr("prepare the case"));
  const Eigen::Vector3d nan = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THAT(refusal(body_, {.gravity = nan}), testing::HasSubstr("gravity"));
  EXPECT_THAT(refusal(body_, {.lying_on = {}}), testing::HasSubstr("lying_on"));
  EXPECT_THAT(refusal(body_, {.max_distance_mm = 10.0}), testing::HasSubstr("max_distance_mm"));
  EXPECT_THAT(refusal(body_, {.num_threads = 0}), testing::HasSubstr("num_threads"));
}

}  // namespace
}  // namespace mor
