// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdlib>
#include <utility>

#include <pcl/features/fpfh.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/registration/ia_ransac.h>
#include <pcl/registration/sample_consensus_prerejective.h>

#include "pcl_methods.h"

namespace mor::peers {
namespace {

using Signature = pcl::FPFHSignature33;

constexpr float kVoxelMm = 10.0F;
constexpr double kFeatureRadiusMm = 50.0;
constexpr unsigned kSeed = 1;

/// A thinned cloud and its features (Rusu 2009).
struct Features {
  explicit Features(const PclCloud::ConstPtr& full)
      : cloud(pcl::make_shared<PclCloud>()), fpfh(pcl::make_shared<pcl::PointCloud<Signature>>()) {
    pcl::VoxelGrid<PclPoint> grid;
    grid.setInputCloud(full);
    grid.setLeafSize(kVoxelMm, kVoxelMm, kVoxelMm);
    grid.filter(*cloud);
    for (auto& point : *cloud) point.getNormalVector3fMap().normalize();
    pcl::FPFHEstimation<PclPoint, PclPoint, Signature> estimation;
    estimation.setInputCloud(cloud);
    estimation.setInputNormals(cloud);
    estimation.setSearchMethod(pcl::make_shared<PclTree>());
    estimation.setRadiusSearch(kFeatureRadiusMm);
    estimation.compute(*fpfh);
  }

  PclCloud::Ptr cloud;
  pcl::PointCloud<Signature>::Ptr fpfh;
};

/// Sample consensus initial alignment (Rusu 2009).
Eigen::Matrix4f match_by_sac_ia(const Features& moving, const Features& fixed) {
  pcl::SampleConsensusInitialAlignment<PclPoint, PclPoint, Signature> sac;
  sac.setInputSource(moving.cloud);
  sac.setSourceFeatures(moving.fpfh);
  sac.setInputTarget(fixed.cloud);
  sac.setTargetFeatures(fixed.fpfh);
  sac.setNumberOfSamples(3);
  sac.setMinSampleDistance(4.0F * kVoxelMm);
  sac.setCorrespondenceRandomness(5);
  sac.setMaxCorrespondenceDistance(2.5 * kVoxelMm);
  sac.setMaximumIterations(1000);
  PclCloud moved;
  sac.align(moved);
  return sac.getFinalTransformation();
}

/// RANSAC that drops samples whose sides differ (Buch 2013).
Eigen::Matrix4f match_by_prerejective(const Features& moving, const Features& fixed) {
  pcl::SampleConsensusPrerejective<PclPoint, PclPoint, Signature> sac;
  sac.setInputSource(moving.cloud);
  sac.setSourceFeatures(moving.fpfh);
  sac.setInputTarget(fixed.cloud);
  sac.setTargetFeatures(fixed.fpfh);
  sac.setNumberOfSamples(3);
  sac.setCorrespondenceRandomness(5);
  sac.setSimilarityThreshold(0.9F);
  sac.setMaxCorrespondenceDistance(1.5 * kVoxelMm);
  sac.setInlierFraction(0.25F);
  sac.setMaximumIterations(50000);
  PclCloud moved;
  sac.align(moved);
  return sac.getFinalTransformation();
}

class PclGlobal : public Method {
 public:
  using Match = Eigen::Matrix4f (*)(const Features& moving, const Features& fixed);

  PclGlobal(std::shared_ptr<const PclFixed> fixed, Match match)
      : fixed_(std::move(fixed)), fixed_features_(fixed_->cloud), match_(match) {}

  void set_moving(const TriangleMesh& moving) override { moving_ = to_pcl(moving); }

  std::optional<Eigen::Isometry3d> align(const Eigen::Isometry3d& /*none*/) override {
    std::srand(kSeed);
    const Eigen::Matrix4f rough = match_(Features(moving_), fixed_features_);
    return align_pcl_icp(*fixed_,
                         *moving_,
                         to_isometry(rough.cast<double>()),
                         {.to_planes = true},
                         pcl_levels(/*is_tracked=*/false));
  }

 private:
  std::shared_ptr<const PclFixed> fixed_;
  Features fixed_features_;
  Match match_;
  PclCloud::Ptr moving_;
};

}  // namespace

void add_pcl_global(const std::shared_ptr<const PclFixed>& fixed, MethodMakers& makers) {
  const auto add = [&](const char* name, PclGlobal::Match match) {
    makers.emplace(name, [fixed, match] { return std::make_unique<PclGlobal>(fixed, match); });
  };
  add("pcl-sac-ia", match_by_sac_ia);
  add("pcl-prerejective", match_by_prerejective);
}

}  // namespace mor::peers
