// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include <pcl/features/from_meshes.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/ndt.h>

#include "pcl_methods.h"

namespace mor::peers {
namespace {

/// Both methods turn about the origin and step equally far in radians and in units of length: they
/// want metres, and the body at the origin.
constexpr double kMetresPerMm = 1e-3;

PclCloud::Ptr in_metres(const PclCloud& cloud, const Eigen::Isometry3d& a_from_cloud) {
  auto moved = pcl::make_shared<PclCloud>(cloud);
  const Eigen::Isometry3f motion = a_from_cloud.cast<float>();
  for (auto& point : *moved) {
    point.getVector3fMap() =
        static_cast<float>(kMetresPerMm) * (motion * Eigen::Vector3f(point.getVector3fMap()));
    point.getNormalVector3fMap() = motion.linear() * Eigen::Vector3f(point.getNormalVector3fMap());
  }
  return moved;
}

/// The fixed side about its centre, in metres.
struct CentredFixed {
  explicit CentredFixed(const PclFixed& fixed)
      : covariances(fixed.covariances), starts_are_tracked(fixed.starts_are_tracked) {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (const auto& point : *fixed.cloud) center += point.getVector3fMap().cast<double>();
    centred_from_fixed.translation() = -center / static_cast<double>(fixed.cloud->size());
    cloud = in_metres(*fixed.cloud, centred_from_fixed);
    tree = pcl::make_shared<PclTree>();
    tree->setInputCloud(cloud);
  }

  Eigen::Isometry3d centred_from_fixed = Eigen::Isometry3d::Identity();
  PclCloud::Ptr cloud;
  PclTree::Ptr tree;
  pcl::shared_ptr<PclCovariances> covariances;
  bool starts_are_tracked = false;
};

/// A method that refines a cloud already near: handed the cloud at its start, it says how to move
/// it.
class CentredMethod : public Method {
 public:
  explicit CentredMethod(const PclFixed& fixed) : fixed_(fixed) {}

  void set_moving(const TriangleMesh& moving) override { moving_ = to_pcl(moving); }

  std::optional<Eigen::Isometry3d> align(const Eigen::Isometry3d& fixed_from_moving_init) override {
    const Eigen::Isometry3d& centred_from_fixed = fixed_.centred_from_fixed;
    const PclCloud::Ptr start = in_metres(*moving_, centred_from_fixed * fixed_from_moving_init);
    Eigen::Isometry3d motion = refine(fixed_, *start);
    motion.translation() /= kMetresPerMm;
    return centred_from_fixed.inverse() * motion * centred_from_fixed * fixed_from_moving_init;
  }

 private:
  [[nodiscard]] virtual Eigen::Isometry3d refine(const CentredFixed& fixed,
                                                 const PclCloud& start) = 0;

  CentredFixed fixed_;
  PclCloud::Ptr moving_;
};

/// Generalized ICP; covariances from the normals, as its authors' plane-to-plane model has it.
class PclGicp : public CentredMethod {
 public:
  using CentredMethod::CentredMethod;

 private:
  [[nodiscard]] Eigen::Isometry3d refine(const CentredFixed& fixed,
                                         const PclCloud& start) override {
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    for (const PclLevel& level : pcl_levels(fixed.starts_are_tracked)) {
      motion = refine_level(fixed, *every_nth_point(start, level.point_stride), motion, level);
    }
    return motion;
  }

  [[nodiscard]] static Eigen::Isometry3d refine_level(const CentredFixed& fixed,
                                                      const PclCloud& start,
                                                      const Eigen::Isometry3d& motion,
                                                      const PclLevel& level) {
    const auto covariances = pcl::make_shared<PclCovariances>();
    pcl::features::computeApproximateCovariances(start, start, *covariances);
    pcl::GeneralizedIterativeClosestPoint<PclPoint, PclPoint, double> gicp;
    gicp.setSearchMethodTarget(fixed.tree, /*force_no_recompute=*/true);
    // Not needed: its covariances are given.
    gicp.setSearchMethodSource(pcl::make_shared<PclTree>(), /*force_no_recompute=*/true);
    gicp.setInputTarget(fixed.cloud);
    gicp.setInputSource(pcl::make_shared<PclCloud>(start));
    gicp.setTargetCovariances(fixed.covariances);
    gicp.setSourceCovariances(covariances);
    gicp.setMaxCorrespondenceDistance(kMetresPerMm * level.gate_mm);
    gicp.setMaximumIterations(level.max_iterations);
    gicp.setTransformationEpsilon(kMetresPerMm * level.stop_mm);
    gicp.setRotationEpsilon(level.stop_rad);
    gicp.setTranslationGradientTolerance(1e-4);
    gicp.setRotationGradientTolerance(1e-4);
    PclCloud moved;
    gicp.align(moved, motion.matrix());
    return to_isometry(gicp.getFinalTransformation());
  }
};

/// Normal distributions transform, two cell sizes; the cells of the fixed side are made before.
class PclNdt : public CentredMethod {
 public:
  explicit PclNdt(const PclFixed& fixed) : CentredMethod(fixed) {
    const CentredFixed centred(fixed);
    for (const float cell_m : {0.06F, 0.03F}) {
      auto& ndt = levels_.emplace_back(
          std::make_unique<pcl::NormalDistributionsTransform<PclPoint, PclPoint>>());
      ndt->setResolution(cell_m);
      ndt->setInputTarget(centred.cloud);
      ndt->setSearchMethodTarget(centred.tree, /*force_no_recompute=*/true);
      ndt->setStepSize(0.01);
      ndt->setTransformationEpsilon(1e-10);  // Of the squared shift.
      ndt->setMaximumIterations(30);
    }
  }

 private:
  [[nodiscard]] Eigen::Isometry3d refine(const CentredFixed& /*in the levels*/,
                                         const PclCloud& start) override {
    constexpr std::size_t kStride = 4;
    const PclCloud::Ptr part = every_nth_point(start, kStride);
    Eigen::Matrix4f motion = Eigen::Matrix4f::Identity();
    for (const auto& ndt : levels_) {
      ndt->setInputSource(part);
      PclCloud moved;
      ndt->align(moved, motion);
      motion = ndt->getFinalTransformation();
    }
    return to_isometry(motion.cast<double>());
  }

  std::vector<std::unique_ptr<pcl::NormalDistributionsTransform<PclPoint, PclPoint>>> levels_;
};

}  // namespace

void add_pcl_distributions(const std::shared_ptr<const PclFixed>& fixed, MethodMakers& makers) {
  makers.emplace("pcl-gicp", [fixed] { return std::make_unique<PclGicp>(*fixed); });
  makers.emplace("pcl-ndt", [fixed] { return std::make_unique<PclNdt>(*fixed); });
}

}  // namespace mor::peers
