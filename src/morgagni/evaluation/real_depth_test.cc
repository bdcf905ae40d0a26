// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// Depth pictures that real Kinects took, none of which shows the body of a CT, and the bunny of
// Go-ICP with its answer.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/image_png.h"
#include "morgagni/ct/surfaces.h"
#include "morgagni/ct/volume_import.h"
#include "morgagni/depth/body_surface.h"
#include "morgagni/evaluation/recording_evaluation.h"
#include "morgagni/registration/automatic_start.h"
#include "morgagni/registration/fine_registration.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr PinholeCamera kPclKinect = {kWidth, kHeight, 525.0, 525.0, 319.5, 239.5, {}};
constexpr PinholeCamera kKitchenKinect = {kWidth, kHeight, 585.0, 585.0, 320.0, 240.0, {}};

fs::path data(const std::string& name) {
  return fs::path(MORGAGNI_DATA_DIR) / name;
}

/// LZF: runs as they are (less than 32), or copies of what came before (three and more bytes).
std::string unpacked_lzf(const std::string& packed) {
  std::string out;
  const auto byte = [&](std::size_t i) {
    return static_cast<std::size_t>(static_cast<unsigned char>(packed.at(i)));
  };
  for (std::size_t i = 0; i < packed.size();) {
    const std::size_t head = byte(i++);
    if (head < 32) {
      out += packed.substr(i, head + 1);
      i += head + 1;
      continue;
    }
    std::size_t length = head / 32;
    if (length == 7) length += byte(i++);
    std::size_t from = out.size() - 256 * (head % 32) - byte(i++) - 1;
    for (length += 2; length > 0; --length) out += out.at(from++);
  }
  return out;
}

/// A person who stands 0.6 to 1 m before a Kinect, in an office: all x, all y, all z, in metres.
Image<std::uint16_t> person() {
  std::ifstream file(data("rgbd_pcl_person/person.pcd"), std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(file), {});
  const std::string end = "DATA binary_compressed\n";
  text.erase(0, text.find(end) + end.size() + 2 * sizeof(std::uint32_t));
  const std::string unpacked = unpacked_lzf(text);
  Image<std::uint16_t> depth(kWidth, kHeight);
  const std::size_t first = 2 * depth.size() * sizeof(float);
  for (std::size_t i = 0; i < depth.size(); ++i) {
    float z_m = 0.0F;
    std::memcpy(&z_m, unpacked.data() + first + i * sizeof z_m, sizeof z_m);
    depth.data()[i] =
        std::isfinite(z_m) ? static_cast<std::uint16_t>(std::lround(1000.0F * z_m)) : 0;
  }
  return depth;
}

std::shared_ptr<const FixedSurface> head() {
  const auto volume = import_volume(data("ct_head_invesalius/promed_ct_0051.nii.gz"), {}, {});
  if (!volume) return nullptr;
  const auto skin = extract_skin(*volume, {}, {});
  if (!skin) return nullptr;
  auto surface = std::make_shared<FixedSurface>();
  surface->mesh = skin->remeshed;
  surface->field = *DistanceField::build(surface->mesh);
  return surface;
}

TEST(RealDepth, APersonIsCutOutOfAnOffice) {
  if (!fs::exists(data("rgbd_pcl_person"))) GTEST_SKIP() << "no rgbd_pcl_person";
  const Image<std::uint16_t> depth = person();
  constexpr double kFarMm = 3000.0;  // The wall behind and a cupboard beside are within.
  auto extractor = BodySurfaceExtractor::create(
      kPclKinect, {.far_mm = kFarMm, .down_sampling = 1.0, .averages = false});
  ASSERT_TRUE(extractor);
  const auto surface = extractor->extract(depth.view());
  ASSERT_TRUE(surface) << surface.error().message;
  const auto num_person = static_cast<std::size_t>(std::count_if(
      depth.data(), depth.data() + depth.size(), [](auto mm) { return mm > 0 && mm < 1000; }));
  std::size_t num_others = 0;
  for (const auto& point : surface->cloud.points)
    if (point.z() > 1100.0F) ++num_others;
  std::cout << num_person << " readings nearer than 1 m, " << surface->cloud.size()
            << " in the surface, of those " << num_others << " farther than 1.1 m\n";
  EXPECT_EQ(num_others, 0U);
  EXPECT_GT(surface->cloud.size(), num_person * 95 / 100);
}

TEST(RealDepth, NobodyIsTakenForTheHeadOfACt) {
  if (!fs::exists(data("rgbd_pcl_person"))) GTEST_SKIP() << "no rgbd_pcl_person";
  const auto surface = head();
  if (!surface) GTEST_SKIP() << "no head CT";
  const Eigen::Vector3d down(0.0, 1.0, 0.0);  // About: the Kinect stands level.
  for (const auto& gravity : {std::optional<Eigen::Vector3d>(), std::optional(down)}) {
    const auto start = AutomaticStart::create(surface, kPclKinect, {.gravity = gravity});
    ASSERT_TRUE(start);
    const auto found = start->find(person().view());
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_NE(found->status, AutomaticStartStatus::kFound);
    std::cout << "person: " << found->reason << "\n";
  }
  const auto start = AutomaticStart::create(surface, kKitchenKinect, {});
  ASSERT_TRUE(start);
  for (int number = 150; number < 175; number += 4) {
    const auto depth =
        read_png_gray16(data(fmt::format("rgbd_tsdf_demo/frames/frame-{:06}.depth.png", number)));
    ASSERT_TRUE(depth) << depth.error().message;
    const auto found = start->find(depth->view());
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_NE(found->status, AutomaticStartStatus::kFound) << "kitchen, frame " << number;
    std::cout << "kitchen: " << found->reason << "\n";
  }
}

/// Go-ICP's clouds, "x y z" a line after their number, made as large as the bunny is.
std::vector<Eigen::Vector3f> read_cloud(const fs::path& path, double scale) {
  std::ifstream file(path);
  std::size_t count = 0;
  file >> count;
  std::vector<Eigen::Vector3f> points(count);
  for (auto& point : points) {
    file >> point.x() >> point.y() >> point.z();
    point *= static_cast<float>(scale);
  }
  EXPECT_TRUE(file) << path;
  return points;
}

/// Yang et al. 2016 found the pose by branch and bound: from a start nearby ICP finds the same.
TEST(GoIcpBunny, IcpEndsWhereTheGlobalMethodDid) {
  if (!fs::exists(data("icp_bench"))) GTEST_SKIP() << "no icp_bench";
  constexpr double kScaleMm = 150.0;
  auto surface = std::make_shared<FixedSurface>();
  surface->mesh.vertices = read_cloud(data("icp_bench/model_bunny.txt"), kScaleMm);
  // The files have none. They only tell whether the pairs fix the pose in every direction, and this
  // surface does.
  for (std::size_t i = 0; i < surface->mesh.vertices.size(); ++i)
    surface->mesh.normals.push_back(Eigen::Vector3f::Unit(static_cast<int>(i % 3)));
  PointCloud moving;
  moving.points = read_cloud(data("icp_bench/data_bunny.txt"), kScaleMm);
  std::ifstream file(data("icp_bench/output.txt"));
  double seconds = 0.0;
  file >> seconds;
  Eigen::Isometry3d answer = Eigen::Isometry3d::Identity();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) file >> answer.matrix()(row, column);
  for (int row = 0; row < 3; ++row) file >> answer.matrix()(row, 3);
  ASSERT_TRUE(file);
  answer.translation() *= kScaleMm;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const auto& point : moving.points) center += point.cast<double>();
  center = answer * (center / static_cast<double>(moving.size()));
  const auto off_mm = [&](const Eigen::Isometry3d& pose) {
    double sum_sq = 0.0;
    for (const auto& point : moving.points)
      sum_sq += (pose * point.cast<double>() - answer * point.cast<double>()).squaredNorm();
    return std::sqrt(sum_sq / static_cast<double>(moving.size()));
  };
  for (const auto method : {RegistrationMethod::kIcp, RegistrationMethod::kTrimmedIcp}) {
    const auto registration = make_fine_registration(surface, {.method = method});
    ASSERT_TRUE(registration) << registration.error().message;
    std::mt19937_64 random(1);
    for (int i = 0; i < 3; ++i) {
      const auto start = perturbed_start(answer, center, 10.0, 15.0 * kDegree, random);
      const auto result = (*registration)->align(moving, start, StartQuality::kRough);
      ASSERT_TRUE(result) << result.error().message;
      std::cout << to_string(method) << ": from " << off_mm(start) << " mm to "
                << off_mm(result->fixed_from_moving) << " mm of Go-ICP's answer, residual "
                << result->rms_distance_mm << " mm\n";
      EXPECT_LT(off_mm(result->fixed_from_moving), 1.0);
    }
  }
}

}  // namespace
}  // namespace mor
