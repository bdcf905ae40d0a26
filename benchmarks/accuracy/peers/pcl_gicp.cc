// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include <pcl/features/from_meshes.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/ndt.h>

#include "pcl_methods.h"

namespace mor::peers {
namespace {

/// Generalized ICP; covariances from the normals, as its authors' plane-to-plane model has it.
class PclGicp : public Method {
 public:
  explicit PclGicp(std::shared_ptr<const PclFixed> fixed) : fixed_(std::move(fixed)) {}

  void set_moving(const TriangleMesh& moving) override { moving_ = to_pcl(moving); }

  Eigen::Isometry3d align(const Eigen::Isometry3d& fixed_from_moving_init) override {
    Eigen::Isometry3d fixed_from_moving = fixed_from_moving_init;
    for (const PclLevel& level : {PclLevel{50.0, 8, 15, 0.5, 5e-3},
                                  PclLevel{25.0, 8, 15, 0.5, 5e-3},
                                  PclLevel{12.0, 4, 15, 0.1, 1e-3},
                                  PclLevel{6.0, 1, 30, 0.01, 1e-4}}) {
      fixed_from_moving = align_level(fixed_from_moving, level);
    }
    return fixed_from_moving;
  }

 private:
  [[nodiscard]] Eigen::Isometry3d align_level(const Eigen::Isometry3d& fixed_from_moving,
                                              const PclLevel& level) const {
    const PclCloud::Ptr part = every_nth_point(*moving_, level.point_stride);
    const auto covariances = pcl::make_shared<PclCovariances>();
    pcl::features::computeApproximateCovariances(*part, *part, *covariances);
    pcl::GeneralizedIterativeClosestPoint<PclPoint, PclPoint, double> gicp;
    gicp.setSearchMethodTarget(fixed_->tree, /*force_no_recompute=*/true);
    // Not needed: its covariances are given.
    gicp.setSearchMethodSource(pcl::make_shared<PclTree>(), /*force_no_recompute=*/true);
    gicp.setInputTarget(fixed_->cloud);
    gicp.setInputSource(part);
    gicp.setTargetCovariances(fixed_->covariances);
    gicp.setSourceCovariances(covariances);
    gicp.setMaxCorrespondenceDistance(level.gate_mm);
    gicp.setMaximumIterations(level.max_iterations);
    gicp.setTransformationEpsilon(level.stop_mm);
    gicp.setRotationEpsilon(level.stop_rad);
    PclCloud moved;
    gicp.align(moved, fixed_from_moving.matrix());
    return to_isometry(gicp.getFinalTransformation());
  }

  std::shared_ptr<const PclFixed> fixed_;
  PclCloud::Ptr moving_;
};

/// Normal distributions transform, two cell sizes; the cells of the fixed side are made before.
class PclNdt : public Method {
 public:
  explicit PclNdt(const PclFixed& fixed) {
    for (const float cell_mm : {60.0F, 30.0F}) {
      auto& ndt = levels_.emplace_back(
          std::make_unique<pcl::NormalDistributionsTransform<PclPoint, PclPoint>>());
      ndt->setResolution(cell_mm);
      ndt->setInputTarget(fixed.cloud);
      ndt->setSearchMethodTarget(fixed.tree, /*force_no_recompute=*/true);
      ndt->setStepSize(10.0);
      ndt->setTransformationEpsilon(1e-4);
      ndt->setMaximumIterations(30);
    }
  }

  void set_moving(const TriangleMesh& moving) override { moving_ = to_pcl(moving); }

  Eigen::Isometry3d align(const Eigen::Isometry3d& fixed_from_moving_init) override {
    constexpr std::size_t kStride = 4;
    const PclCloud::Ptr part = every_nth_point(*moving_, kStride);
    Eigen::Matrix4f fixed_from_moving = fixed_from_moving_init.matrix().cast<float>();
    for (const auto& ndt : levels_) {
      ndt->setInputSource(part);
      PclCloud moved;
      ndt->align(moved, fixed_from_moving);
      fixed_from_moving = ndt->getFinalTransformation();
    }
    return to_isometry(fixed_from_moving.cast<double>());
  }

 private:
  std::vector<std::unique_ptr<pcl::NormalDistributionsTransform<PclPoint, PclPoint>>> levels_;
  PclCloud::Ptr moving_;
};

}  // namespace

void add_pcl_distributions(const std::shared_ptr<const PclFixed>& fixed, MethodMakers& makers) {
  makers.emplace("pcl-gicp", [fixed] { return std::make_unique<PclGicp>(fixed); });
  makers.emplace("pcl-ndt", [fixed] { return std::make_unique<PclNdt>(*fixed); });
}

}  // namespace mor::peers
