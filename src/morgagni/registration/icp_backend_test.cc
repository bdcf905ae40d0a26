// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/icp_backend.h"

#include <cmath>
#include <functional>
#include <numeric>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/registration/internal/icp_kernels.h"
#include "morgagni/registration/testing/test_body.h"

namespace mor::internal {
namespace {

/// One device: a name, and how its backend is made.
struct Device {
  std::string name;
  std::function<Result<std::unique_ptr<IcpBackend>>(std::shared_ptr<const IcpSurface>)> make;
  double sum_tolerance;  ///< Of sums, relative: what the device adds up in.
};

const std::vector<Device>& devices() {
  static const std::vector<Device> kDevices = {
      {"Cpu", [](auto surface) { return make_icp_backend_cpu(std::move(surface)); }, 1e-6},
      {"Opencl",
       [](auto surface) { return make_icp_backend_opencl(std::move(surface), "opencl"); },
       1e-6},
      {"OpenclInSingle",
       [](auto surface) {
         return make_icp_backend_opencl(std::move(surface), "opencl", SumPrecision::kSingle);
       },
       1e-4}};
  return kDevices;
}

std::vector<Eigen::Vector3f> random_points(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-100.0F, 100.0F);
  std::vector<Eigen::Vector3f> points(count);
  for (auto& point : points) {
    point = Eigen::Vector3f(uniform(random), uniform(random), 700.0F + uniform(random));
  }
  return points;
}

/// A surface of so many vertices with normals all over the place; its few triangles give its
/// vertices errors of different sizes.
TriangleMesh random_mesh(std::size_t num_vertices, unsigned seed) {
  TriangleMesh mesh;
  mesh.vertices = random_points(num_vertices, seed);
  std::mt19937 random(seed + 1);
  std::normal_distribution<float> normal;
  for (std::uint32_t i = 0; i < num_vertices; ++i) {
    mesh.vertices[i].z() -= 690.0F;
    mesh.normals.push_back(
        Eigen::Vector3f(normal(random), normal(random), normal(random)).normalized());
    if (i >= 2 && i % 3 != 0) mesh.triangles.push_back({i - 2, i - 1, i});
  }
  // As wide as a skin's triangles, not as this box of points.
  for (auto& vertex : mesh.vertices) vertex *= 0.1F;
  return mesh;
}

Eigen::Isometry3d some_pose(double angle_rad) {
  return motion_about({0.0, 0.0, 700.0}, {0.3, 1.0, -0.4}, angle_rad, {3.0, -2.0, -699.0});
}

double squared_distance(const IcpSurface& surface,
                        const std::vector<SensorError>& errors,
                        const Eigen::Isometry3d& pose,
                        std::span<const Eigen::Vector3f> moving,
                        std::size_t i,
                        std::size_t partner) {
  const Eigen::Vector3d d =
      pose * moving[i].cast<double>() - surface.points[partner].cast<double>();
  if (surface.metric == PairMetric::kEuclidean) return d.squaredNorm();
  const Eigen::Vector3d ray = pose.linear() * errors[i].along_ray_mm.cast<double>();
  const Eigen::Vector3d normal = surface.errors[partner].along_normal_mm.cast<double>();
  const Eigen::Matrix3d covariance =
      (errors[i].sideways_mm2 + surface.errors[partner].sideways_mm2) *
          Eigen::Matrix3d::Identity() +
      ray * ray.transpose() - normal * normal.transpose();
  return d.dot(covariance.inverse() * d);
}

class IcpBackendOn : public testing::TestWithParam<std::tuple<Device, PairMetric>> {
 protected:
  void SetUp() override {
    const auto surface = std::make_shared<const IcpSurface>(random_mesh(10, 1), metric());
    if (const auto backend = device().make(surface); !backend) {
      GTEST_SKIP() << backend.error().message;
    }
  }
  [[nodiscard]] const Device& device() const { return std::get<0>(GetParam()); }
  [[nodiscard]] PairMetric metric() const { return std::get<1>(GetParam()); }

  [[nodiscard]] std::unique_ptr<IcpBackend> make(std::size_t num_vertices) {
    surface_ = std::make_shared<const IcpSurface>(random_mesh(num_vertices, 5), metric());
    return device().make(surface_).value();
  }

  /// Each partner is as near as the nearest of all.
  void expect_nearest(IcpBackend& backend,
                      std::span<const Eigen::Vector3f> moving,
                      const Eigen::Isometry3d& pose) {
    const auto errors = sensor_errors(moving);
    const auto partners = backend.partners().value();
    ASSERT_EQ(partners.size(), moving.size());
    for (std::size_t i = 0; i<moving.size(); i += moving.size()> 1000 ? 17 : 1) {
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t node = 0; node < surface_->points.size(); ++node) {
        nearest = std::min(nearest, squared_distance(*surface_, errors, pose, moving, i, node));
      }
      ASSERT_LT(partners[i], surface_->points.size());
      ASSERT_NEAR(std::sqrt(squared_distance(*surface_, errors, pose, moving, i, partners[i])),
                  std::sqrt(nearest),
                  1e-4)
          << "point " << i << " of " << moving.size() << ", " << surface_->points.size()
          << " fixed points";
    }
  }

  std::shared_ptr<const IcpSurface> surface_;
};

TEST_P(IcpBackendOn, FindsTheNearestOfAnyNumbersOfPoints) {
  for (const std::size_t num_fixed : {1, 2, 3, 7, 500, 4097}) {
    const auto backend = make(num_fixed);
    for (const std::size_t num_moving : {1, 2, 3, 7, 4097}) {
      const auto moving = random_points(num_moving, 3);
      ASSERT_TRUE(backend->load(moving));
      // The second pose starts from the partners of the first, near and far.
      for (const double angle_rad : {0.4, 0.42, -1.0}) {
        ASSERT_TRUE(backend->find_pairs(some_pose(angle_rad)));
        expect_nearest(*backend, moving, some_pose(angle_rad));
      }
    }
  }
}

TEST_P(IcpBackendOn, KeepsTheClosestInOrder) {
  const auto backend = make(300);
  for (const std::size_t count : {1, 2, 3, 7, 128, 129, 4097}) {
    const auto moving = random_points(count, 9);
    const auto errors = sensor_errors(moving);
    ASSERT_TRUE(backend->load(moving));
    ASSERT_TRUE(backend->find_pairs(some_pose(0.1)));
    const auto partners = backend->partners().value();
    std::vector<double> distances;
    for (std::size_t i = 0; i < count; ++i) {
      distances.push_back(
          std::sqrt(squared_distance(*surface_, errors, some_pose(0.1), moving, i, partners[i])));
    }
    const std::size_t num_kept = count - count / 4;
    ASSERT_TRUE(backend->keep_closest(num_kept));
    const auto kept = backend->kept().value();
    ASSERT_EQ(kept.size(), num_kept);
    auto sorted = distances;
    std::sort(sorted.begin(), sorted.end());
    std::vector<bool> seen(count);
    for (std::size_t rank = 0; rank < num_kept; ++rank) {
      ASSERT_LT(kept[rank], count);
      ASSERT_FALSE(seen[kept[rank]]);
      seen[kept[rank]] = true;
      if (num_kept < count) {
        ASSERT_NEAR(distances[kept[rank]], sorted[rank], 1e-4) << rank;
      }
    }
    // All of the next pairs count again.
    ASSERT_TRUE(backend->find_pairs(some_pose(0.1)));
    ASSERT_EQ(backend->kept().value().size(), count);
  }
}

TEST_P(IcpBackendOn, SumsAsDoublesDo) {
  const Eigen::Isometry3d pose = some_pose(0.2);
  for (const std::size_t count : {1, 3, 7, 1000, 4097}) {
    const auto backend = make(500);
    const auto moving = random_points(count, 21);
    const auto errors = sensor_errors(moving);
    ASSERT_TRUE(backend->load(moving));
    ASSERT_TRUE(backend->find_pairs(pose));
    ASSERT_TRUE(backend->keep_closest(count - count / 3));
    const auto partners = backend->partners().value();
    const auto kept = backend->kept().value();
    const PairSums sums = backend->sum_pairs().value();
    EXPECT_LT((pose * sums.moving_pivot.cast<double>() - sums.fixed_pivot.cast<double>()).norm(),
              1e-4);
    PairSums expected;
    double sum_sq_products = 1e-9;
    for (std::size_t i = 0; i < count; ++i) {
      const double apart_mm =
          (pose * moving[i].cast<double>() - surface_->points[partners[i]].cast<double>()).norm();
      expected.num_explained += apart_mm <= kExplainedMm ? 1.0 : 0.0;
      expected.num_near += apart_mm <= kNearMm ? 1.0 : 0.0;
    }
    for (const auto i : kept) {
      const Eigen::Vector3d p = (moving[i] - sums.moving_pivot).cast<double>();
      const Eigen::Vector3d q = (surface_->points[partners[i]] - sums.fixed_pivot).cast<double>();
      expected.sum_sq_mm2 +=
          (pose * moving[i].cast<double>() - surface_->points[partners[i]].cast<double>())
              .squaredNorm();
      expected.sum_weighted_sq += squared_distance(*surface_, errors, pose, moving, i, partners[i]);
      expected.moving += p;
      expected.fixed += q;
      expected.products += p * q.transpose();
      sum_sq_products += p.norm() * q.norm();
    }
    const double tolerance = 10.0 * device().sum_tolerance;
    EXPECT_EQ(sums.num_explained, expected.num_explained);
    EXPECT_EQ(sums.num_near, expected.num_near);
    EXPECT_NEAR(sums.sum_sq_mm2, expected.sum_sq_mm2, tolerance * (1.0 + expected.sum_sq_mm2));
    EXPECT_NEAR(sums.sum_weighted_sq,
                expected.sum_weighted_sq,
                tolerance * (1.0 + expected.sum_weighted_sq));
    EXPECT_LT((sums.products - expected.products).norm(), tolerance * (1.0 + sum_sq_products));
    EXPECT_LT((sums.moving - expected.moving).norm() / static_cast<double>(count), 1e-3);
    EXPECT_LT((sums.fixed - expected.fixed).norm() / static_cast<double>(count), 1e-3);
  }
}

/// Weighted pairs alone are linearised.
class WeightedIcpBackendOn : public IcpBackendOn {};

TEST_P(WeightedIcpBackendOn, LinearizesAsDoublesDo) {
  for (const std::size_t count : {1, 7, 4097}) {
    const auto backend = make(500);
    const auto moving = random_points(count, 33);
    const auto errors = sensor_errors(moving);
    ASSERT_TRUE(backend->load(moving));
    ASSERT_TRUE(backend->find_pairs(some_pose(0.3)));
    const auto partners = backend->partners().value();
    const Eigen::Isometry3d pose = some_pose(0.31);
    const Eigen::Vector3d pivot(1.0, 2.0, 3.0);
    const auto equations = backend->linearize(pose, pivot).value();
    // The gradient by differences: moving the pose along each of the six directions.
    const auto cost = [&](const Vector6d& twist) {
      double sum = 0.0;
      const Eigen::Isometry3d turned =
          Eigen::Translation3d(pivot + twist.tail<3>()) *
          se3_exp((Vector6d() << twist.head<3>(), 0, 0, 0).finished()) *
          Eigen::Translation3d(-pivot) * pose;
      for (std::size_t i = 0; i < count; ++i) {
        // The weights stay those of the pose.
        const Eigen::Vector3d d =
            turned * moving[i].cast<double>() - surface_->points[partners[i]].cast<double>();
        const Eigen::Vector3d ray = pose.linear() * errors[i].along_ray_mm.cast<double>();
        const auto& fixed = surface_->errors[partners[i]];
        const Eigen::Vector3d normal = fixed.along_normal_mm.cast<double>();
        const Eigen::Matrix3d covariance =
            (errors[i].sideways_mm2 + fixed.sideways_mm2) * Eigen::Matrix3d::Identity() +
            ray * ray.transpose() - normal * normal.transpose();
        sum += d.dot(covariance.inverse() * d);
      }
      return sum;
    };
    const double scale = equations.information.norm();
    EXPECT_NEAR(equations.sum_weighted_sq,
                cost(Vector6d::Zero()),
                10.0 * device().sum_tolerance * (1.0 + cost(Vector6d::Zero())));
    const double step = 1e-4;
    for (Eigen::Index k = 0; k < 6; ++k) {
      const Vector6d e = step * Vector6d::Unit(k);
      const double gradient = 0.25 * (cost(e) - cost(-e)) / step;
      EXPECT_NEAR(equations.gradient[k], gradient, 1e-3 * equations.gradient.norm() + 1e-4) << k;
    }
    // Without residuals the information is half the second derivative: checked on a full step.
    const Vector6d twist = 1e-5 * Vector6d::Ones();
    const double quadratic = twist.dot(equations.information * twist);
    EXPECT_TRUE(equations.information.isApprox(equations.information.transpose()));
    EXPECT_NEAR(cost(twist),
                equations.sum_weighted_sq + 2.0 * equations.gradient.dot(twist) + quadratic,
                1e-4 * (1.0 + equations.sum_weighted_sq));
    EXPECT_GT(scale, 0.0);
  }
}

TEST_P(IcpBackendOn, TakesLargerAndSmallerCloudsInTurn) {
  const auto backend = make(200);
  for (const std::size_t count : {5, 3000, 17, 4000, 1}) {
    const auto moving = random_points(count, static_cast<unsigned>(count));
    ASSERT_TRUE(backend->load(moving));
    ASSERT_TRUE(backend->find_pairs(some_pose(0.2)));
    ASSERT_TRUE(backend->keep_closest(count));
    expect_nearest(*backend, moving, some_pose(0.2));
    EXPECT_EQ(backend->kept().value().size(), count);
  }
}

std::string suite_name(const testing::TestParamInfo<IcpBackendOn::ParamType>& info) {
  return std::get<0>(info.param).name +
         (std::get<1>(info.param) == PairMetric::kWeighted ? "Weighted" : "Euclidean");
}

INSTANTIATE_TEST_SUITE_P(Device,
                         IcpBackendOn,
                         testing::Combine(testing::ValuesIn(devices()),
                                          testing::Values(PairMetric::kEuclidean,
                                                          PairMetric::kWeighted)),
                         suite_name);

INSTANTIATE_TEST_SUITE_P(Device,
                         WeightedIcpBackendOn,
                         testing::Combine(testing::ValuesIn(devices()),
                                          testing::Values(PairMetric::kWeighted)),
                         suite_name);

TEST(IcpKernels, SortAsStdSortDoes) {
  auto context = ComputeContext::open("opencl");
  if (!context) GTEST_SKIP() << context.error().message;
  auto kernels = IcpKernels::build(*context, SumPrecision::kSingle).value();
  std::mt19937 random(4);
  for (const std::size_t count : {1, 2, 3, 7, 127, 128, 129, 1000, 4096, 4097, 20001}) {
    // Few different values: many are equal.
    std::uniform_int_distribution<int> value(0, static_cast<int>(count / 3 + 1));
    std::vector<float> keys(count);
    for (auto& key : keys) key = static_cast<float>(value(random)) * 0.25F;
    auto buffer = *context->allocate(count * sizeof(float));
    ASSERT_TRUE(context->write<float>(buffer, keys));
    ASSERT_TRUE(kernels.sort(*context, buffer, count));
    std::vector<std::uint32_t> order(count);
    ASSERT_TRUE(context->read<std::uint32_t>(kernels.sort_order, order));
    std::vector<std::uint32_t> expected(count);
    std::iota(expected.begin(), expected.end(), std::uint32_t{0});
    std::stable_sort(expected.begin(), expected.end(), [&](std::uint32_t a, std::uint32_t b) {
      return keys[a] < keys[b];
    });
    EXPECT_EQ(order, expected) << count;
  }
}

}  // namespace
}  // namespace mor::internal
