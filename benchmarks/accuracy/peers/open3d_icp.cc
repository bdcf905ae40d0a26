// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <utility>

#include <open3d/pipelines/registration/GeneralizedICP.h>
#include <open3d/pipelines/registration/Registration.h>
#include <open3d/pipelines/registration/RobustKernel.h>
#include <open3d/pipelines/registration/TransformationEstimation.h>

#include "open3d_methods.h"

namespace mor::peers {
namespace {

namespace o3r = open3d::pipelines::registration;
using Cloud = open3d::geometry::PointCloud;

/// As Open3D derives them from normals: a disc of radius 1, `kThickness` squared across.
constexpr double kThickness = 1e-3;

std::vector<Eigen::Matrix3d> disc_covariances(const std::vector<Eigen::Vector3d>& normals) {
  std::vector<Eigen::Matrix3d> covariances;
  covariances.reserve(normals.size());
  for (const auto& normal : normals) {
    covariances.push_back(Eigen::Matrix3d::Identity() -
                          (1.0 - kThickness) * normal * normal.transpose());
  }
  return covariances;
}

std::unique_ptr<o3r::TransformationEstimation> make_estimation(Open3dEstimator estimator,
                                                               double scale_mm) {
  const auto kernel = std::make_shared<o3r::TukeyLoss>(scale_mm);
  switch (estimator) {
    case Open3dEstimator::kPointToPlane:
      return std::make_unique<o3r::TransformationEstimationPointToPlane>(kernel);
    case Open3dEstimator::kGeneralized:
      return std::make_unique<o3r::TransformationEstimationForGeneralizedICP>(kThickness, kernel);
    case Open3dEstimator::kPointToPoint:
      break;
  }
  return std::make_unique<o3r::TransformationEstimationPointToPoint>();
}

struct Pairing {
  o3r::CorrespondenceSet pairs;
  double rmse_mm = 0.0;
  double fitness = 0.0;
};

Pairing pair_up(const Open3dFixed& fixed, const Cloud& moved, double gate_mm) {
  Pairing pairing;
  double sum_sq_mm2 = 0.0;
  std::vector<int> idx(1);
  std::vector<double> distance_sq_mm2(1);
  for (std::size_t i = 0; i < moved.points_.size(); ++i) {
    if (fixed.tree.SearchHybrid(moved.points_[i], gate_mm, 1, idx, distance_sq_mm2) < 1) continue;
    sum_sq_mm2 += distance_sq_mm2[0];
    pairing.pairs.emplace_back(static_cast<int>(i), idx[0]);
  }
  const auto num_pairs = static_cast<double>(pairing.pairs.size());
  if (num_pairs > 0.0) pairing.rmse_mm = std::sqrt(sum_sq_mm2 / num_pairs);
  pairing.fitness = num_pairs / static_cast<double>(moved.points_.size());
  return pairing;
}

Eigen::Isometry3d align_level(const Open3dFixed& fixed,
                              Cloud moved,
                              Eigen::Isometry3d fixed_from_moving,
                              Open3dEstimator estimator,
                              const Open3dLevel& level) {
  constexpr std::size_t kMinPairs = 10;
  const auto estimation = make_estimation(estimator, level.kernel_mm);
  moved.Transform(fixed_from_moving.matrix());
  Pairing pairing = pair_up(fixed, moved, level.gate_mm);
  for (int i = 0; i < level.max_iterations && pairing.pairs.size() >= kMinPairs; ++i) {
    const Eigen::Isometry3d update(
        estimation->ComputeTransformation(moved, fixed.cloud, pairing.pairs));
    fixed_from_moving = update * fixed_from_moving;
    moved.Transform(update.matrix());
    const Pairing before = std::exchange(pairing, pair_up(fixed, moved, level.gate_mm));
    if (std::abs(before.fitness - pairing.fitness) < level.stop_fitness &&
        std::abs(before.rmse_mm - pairing.rmse_mm) < level.stop_rmse_mm) {
      break;
    }
  }
  return fixed_from_moving;
}

class Open3dIcp : public Method {
 public:
  Open3dIcp(std::shared_ptr<const Open3dFixed> fixed, Open3dEstimator estimator)
      : fixed_(std::move(fixed)), estimator_(estimator) {}

  void set_moving(const TriangleMesh& moving) override { moving_ = to_open3d(moving); }

  std::optional<Eigen::Isometry3d> align(const Eigen::Isometry3d& fixed_from_moving_init) override {
    return align_coarse_to_fine(*fixed_,
                                moving_,
                                fixed_from_moving_init,
                                estimator_,
                                open3d_levels(estimator_, fixed_->starts_are_tracked));
  }

 private:
  std::shared_ptr<const Open3dFixed> fixed_;
  Open3dEstimator estimator_;
  Cloud moving_;
};

/// The same levels by the library's own function, which builds the fixed side's tree in each call.
class Open3dWholeFunction : public Method {
 public:
  explicit Open3dWholeFunction(std::shared_ptr<const Open3dFixed> fixed)
      : fixed_(std::move(fixed)) {}

  void set_moving(const TriangleMesh& moving) override { moving_ = to_open3d(moving); }

  std::optional<Eigen::Isometry3d> align(const Eigen::Isometry3d& fixed_from_moving_init) override {
    constexpr auto kEstimator = Open3dEstimator::kPointToPlane;
    Eigen::Matrix4d fixed_from_moving = fixed_from_moving_init.matrix();
    for (const auto& level : open3d_levels(kEstimator, fixed_->starts_are_tracked)) {
      fixed_from_moving =
          o3r::RegistrationICP(*moving_.UniformDownSample(level.point_stride),
                               fixed_->cloud,
                               level.gate_mm,
                               fixed_from_moving,
                               *make_estimation(kEstimator, level.kernel_mm),
                               {level.stop_fitness, level.stop_rmse_mm, level.max_iterations})
              .transformation_;
    }
    return Eigen::Isometry3d(fixed_from_moving);
  }

 private:
  std::shared_ptr<const Open3dFixed> fixed_;
  Cloud moving_;
};

}  // namespace

Open3dFixed::Open3dFixed(const TriangleMesh& skin, bool are_tracked)
    : cloud(to_open3d(skin)), starts_are_tracked(are_tracked) {
  cloud.covariances_ = disc_covariances(cloud.normals_);
  tree.SetGeometry(cloud);
}

Cloud to_open3d(const TriangleMesh& mesh) {
  Cloud cloud;
  for (const auto& point : mesh.vertices) cloud.points_.push_back(point.cast<double>());
  for (const auto& normal : mesh.normals) cloud.normals_.push_back(normal.cast<double>());
  return cloud;
}

Eigen::Isometry3d align_coarse_to_fine(const Open3dFixed& fixed,
                                       const Cloud& moving,
                                       Eigen::Isometry3d fixed_from_moving,
                                       Open3dEstimator estimator,
                                       const std::vector<Open3dLevel>& levels) {
  for (const auto& level : levels) {
    Cloud part;
    for (std::size_t i = 0; i < moving.points_.size(); i += level.point_stride) {
      part.points_.push_back(moving.points_[i]);
      if (estimator == Open3dEstimator::kGeneralized) part.normals_.push_back(moving.normals_[i]);
    }
    part.covariances_ = disc_covariances(part.normals_);
    fixed_from_moving = align_level(fixed, std::move(part), fixed_from_moving, estimator, level);
  }
  return fixed_from_moving;
}

std::vector<Open3dLevel> open3d_levels(Open3dEstimator estimator, bool is_tracked) {
  std::vector<Open3dLevel> levels;
  if (!is_tracked) levels = {{50.0, 50.0, 8, 15, 0.05, 1e-3}, {25.0, 25.0, 8, 15, 0.05, 1e-3}};
  levels.push_back({12.0, 12.0, 4, 15, 0.02, 1e-3});
  if (estimator == Open3dEstimator::kPointToPlane) {
    levels.push_back({6.0, 6.0, 4, 15, 0.01, 1e-3});
    levels.push_back({6.0, 3.0, 1, 20, 1e-3, 1e-4});
  } else {
    levels.push_back({6.0, 6.0, 1, 30, 1e-3, 1e-4});
  }
  return levels;
}

void add_open3d_icp(const std::shared_ptr<const Open3dFixed>& fixed, MethodMakers& makers) {
  const auto add = [&](const char* name, Open3dEstimator estimator) {
    makers.emplace(name,
                   [fixed, estimator] { return std::make_unique<Open3dIcp>(fixed, estimator); });
  };
  add("open3d-point-to-point", Open3dEstimator::kPointToPoint);
  add("open3d-point-to-plane", Open3dEstimator::kPointToPlane);
  add("open3d-generalized", Open3dEstimator::kGeneralized);
  makers.emplace("open3d-registration-icp",
                 [fixed] { return std::make_unique<Open3dWholeFunction>(fixed); });
}

}  // namespace mor::peers
