// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <utility>

#include <pcl/common/io.h>
#include <pcl/recognition/ransac_based/trimmed_icp.h>
#include <pcl/registration/correspondence_rejection_surface_normal.h>
#include <pcl/registration/correspondence_rejection_trimmed.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/transformation_estimation_point_to_plane_lls.h>
#include <pcl/registration/transformation_estimation_svd.h>

#include "pcl_methods.h"

namespace mor::peers {
namespace {

using Icp = pcl::IterativeClosestPointWithNormals<PclPoint, PclPoint, double>;

void set_rules(Icp& icp, const PclIcpRules& rules) {
  namespace pr = pcl::registration;
  if (rules.to_planes) {
    icp.setTransformationEstimation(
        pcl::make_shared<
            pr::TransformationEstimationPointToPlaneLLS<PclPoint, PclPoint, double>>());
  } else {
    icp.setTransformationEstimation(
        pcl::make_shared<pr::TransformationEstimationSVD<PclPoint, PclPoint, double>>());
  }
  if (rules.same_facing) {
    const auto rejector = pcl::make_shared<pr::CorrespondenceRejectorSurfaceNormal>();
    rejector->setThreshold(std::cos(M_PI / 4.0));
    icp.addCorrespondenceRejector(rejector);
  }
  if (rules.kept_fraction < 1.0) {
    const auto rejector = pcl::make_shared<pr::CorrespondenceRejectorTrimmed>();
    rejector->setOverlapRatio(static_cast<float>(rules.kept_fraction));
    icp.addCorrespondenceRejector(rejector);
  }
}

class PclIcp : public Method {
 public:
  PclIcp(std::shared_ptr<const PclFixed> fixed, const PclIcpRules& rules)
      : fixed_(std::move(fixed)), rules_(rules) {}

  void set_moving(const TriangleMesh& moving) override { moving_ = to_pcl(moving); }

  std::optional<Eigen::Isometry3d> align(const Eigen::Isometry3d& fixed_from_moving_init) override {
    return align_pcl_icp(
        *fixed_, *moving_, fixed_from_moving_init, rules_, pcl_levels(fixed_->starts_are_tracked));
  }

 private:
  std::shared_ptr<const PclFixed> fixed_;
  PclIcpRules rules_;
  PclCloud::Ptr moving_;
};

/// Chetverikov's trimmed ICP as PCL's recognition module has it: no gate, a share of the points.
class PclTrimmedIcp : public Method {
 public:
  explicit PclTrimmedIcp(const PclFixed& fixed) {
    const auto points = pcl::make_shared<Points>();
    pcl::copyPointCloud(*fixed.cloud, *points);
    icp_.init(points);
    icp_.setNewToOldEnergyRatio(0.999F);
  }

  void set_moving(const TriangleMesh& moving) override {
    pcl::copyPointCloud(*to_pcl(moving), moving_);
  }

  std::optional<Eigen::Isometry3d> align(const Eigen::Isometry3d& fixed_from_moving_init) override {
    constexpr double kKeptFraction = 0.7;
    Eigen::Matrix4f fixed_from_moving = fixed_from_moving_init.matrix().cast<float>();
    icp_.align(moving_,
               static_cast<int>(kKeptFraction * static_cast<double>(moving_.size())),
               fixed_from_moving);
    return to_isometry(fixed_from_moving.cast<double>());
  }

 private:
  using Points = pcl::PointCloud<pcl::PointXYZ>;

  pcl::recognition::TrimmedICP<pcl::PointXYZ, float> icp_;
  Points moving_;
};

}  // namespace

Eigen::Isometry3d align_pcl_icp(const PclFixed& fixed,
                                const PclCloud& moving,
                                Eigen::Isometry3d fixed_from_moving,
                                const PclIcpRules& rules,
                                const std::vector<PclLevel>& levels) {
  for (const auto& level : levels) {
    Icp icp;
    set_rules(icp, rules);
    icp.setSearchMethodTarget(fixed.tree, /*force_no_recompute=*/true);
    icp.setInputTarget(fixed.cloud);
    icp.setInputSource(every_nth_point(moving, level.point_stride));
    icp.setMaxCorrespondenceDistance(level.gate_mm);
    icp.setMaximumIterations(level.max_iterations);
    icp.setTransformationEpsilon(level.stop_mm * level.stop_mm);
    icp.setTransformationRotationEpsilon(std::cos(level.stop_rad));
    PclCloud moved;
    icp.align(moved, fixed_from_moving.matrix());
    fixed_from_moving = to_isometry(icp.getFinalTransformation());
  }
  return fixed_from_moving;
}

void add_pcl_icp(const std::shared_ptr<const PclFixed>& fixed, MethodMakers& makers) {
  const auto add = [&](const char* name, const PclIcpRules& rules) {
    makers.emplace(name, [fixed, rules] { return std::make_unique<PclIcp>(fixed, rules); });
  };
  add("pcl-icp", {.to_planes = false});
  add("pcl-point-to-plane", {.to_planes = true});
  add("pcl-point-to-plane-trimmed", {.to_planes = true, .same_facing = true, .kept_fraction = 0.8});
  makers.emplace("pcl-trimmed-icp", [fixed] { return std::make_unique<PclTrimmedIcp>(*fixed); });
}

}  // namespace mor::peers
