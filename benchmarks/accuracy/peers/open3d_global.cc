// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include <open3d/pipelines/registration/CorrespondenceChecker.h>
#include <open3d/pipelines/registration/FastGlobalRegistration.h>
#include <open3d/pipelines/registration/Feature.h>
#include <open3d/pipelines/registration/Registration.h>
#include <open3d/utility/Random.h>

#include "open3d_methods.h"

namespace mor::peers {
namespace {

namespace o3r = open3d::pipelines::registration;
using Cloud = open3d::geometry::PointCloud;

constexpr double kVoxelMm = 10.0;
constexpr double kFeatureRadiusMm = 50.0;
constexpr int kFeatureNeighbors = 100;
constexpr int kSeed = 1;

/// A thinned cloud and its features (Rusu 2009).
struct Features {
  explicit Features(const Cloud& full)
      : cloud(*full.VoxelDownSample(kVoxelMm)),
        fpfh(*o3r::ComputeFPFHFeature(
            cloud,
            open3d::geometry::KDTreeSearchParamHybrid(kFeatureRadiusMm, kFeatureNeighbors))) {}

  Cloud cloud;
  o3r::Feature fpfh;
};

Eigen::Matrix4d match_by_ransac(const Features& moving, const Features& fixed) {
  constexpr double kGateMm = 1.5 * kVoxelMm;
  constexpr int kMaxIterations = 100000;
  constexpr double kConfidence = 0.999;
  const o3r::CorrespondenceCheckerBasedOnEdgeLength same_edges(0.9);
  const o3r::CorrespondenceCheckerBasedOnDistance near(kGateMm);
  return o3r::RegistrationRANSACBasedOnFeatureMatching(moving.cloud,
                                                       fixed.cloud,
                                                       moving.fpfh,
                                                       fixed.fpfh,
                                                       /*mutual_filter=*/true,
                                                       kGateMm,
                                                       o3r::TransformationEstimationPointToPoint(),
                                                       /*ransac_n=*/3,
                                                       {same_edges, near},
                                                       {kMaxIterations, kConfidence})
      .transformation_;
}

Eigen::Matrix4d match_by_fgr(const Features& moving, const Features& fixed) {
  o3r::FastGlobalRegistrationOption option;
  option.use_absolute_scale_ = true;
  option.maximum_correspondence_distance_ = kVoxelMm;
  return o3r::FastGlobalRegistrationBasedOnFeatureMatching(
             moving.cloud, fixed.cloud, moving.fpfh, fixed.fpfh, option)
      .transformation_;
}

class Open3dGlobal : public Method {
 public:
  using Match = Eigen::Matrix4d (*)(const Features& moving, const Features& fixed);

  Open3dGlobal(std::shared_ptr<const Open3dFixed> fixed, Match match)
      : fixed_(std::move(fixed)), fixed_features_(fixed_->cloud), match_(match) {}

  void set_moving(const TriangleMesh& moving) override { moving_ = to_open3d(moving); }

  std::optional<Eigen::Isometry3d> align(const Eigen::Isometry3d& /*none*/) override {
    open3d::utility::random::Seed(kSeed);
    const Eigen::Isometry3d rough(match_(Features(moving_), fixed_features_));
    constexpr auto kRefinement = Open3dEstimator::kPointToPlane;
    return align_coarse_to_fine(
        *fixed_, moving_, rough, kRefinement, open3d_levels(kRefinement, /*is_tracked=*/false));
  }

 private:
  std::shared_ptr<const Open3dFixed> fixed_;
  Features fixed_features_;
  Match match_;
  Cloud moving_;
};

}  // namespace

void add_open3d_global(const std::shared_ptr<const Open3dFixed>& fixed, MethodMakers& makers) {
  const auto add = [&](const char* name, Open3dGlobal::Match match) {
    makers.emplace(name, [fixed, match] { return std::make_unique<Open3dGlobal>(fixed, match); });
  };
  add("open3d-fpfh-ransac", match_by_ransac);
  add("open3d-fpfh-fgr", match_by_fgr);
}

}  // namespace mor::peers
