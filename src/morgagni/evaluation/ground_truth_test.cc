// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/ground_truth.h"

#include <cmath>
#include <string_view>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "morgagni/core/files.h"
#include "morgagni/registration/testing/test_body.h"

namespace mor {
namespace {

using testing::HasSubstr;

class GroundTruthFile : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }

  void write(std::string_view text) { ASSERT_TRUE(write_file(path_, text)); }
  [[nodiscard]] std::string pose_error(std::string_view text) {
    write(text);
    const auto poses = read_ground_truth(path_);
    return poses ? std::string() : poses.error().message;
  }
  [[nodiscard]] std::string target_error(std::string_view text) {
    write(text);
    const auto targets = read_targets(path_);
    return targets ? std::string() : targets.error().message;
  }

  std::filesystem::path path_ =
      std::filesystem::path(testing::TempDir()) / fmt::format("mor_truth_{}", ::getpid());
};

TEST_F(GroundTruthFile, IsBroughtFromMetresInRasToMillimetresInLps) {
  // A quarter turn about z in RAS: the camera's x axis points to anterior (+y), its y to the right.
  write("# comment\n0.5 0.1 0.2 -0.3 0 0 0.70710678 0.70710678\r\n\n1.5  0 0 0 0 0 0 1\n");
  const auto poses = read_ground_truth(path_);
  ASSERT_TRUE(poses) << poses.error().message;
  ASSERT_EQ(poses->size(), 2U);
  const auto& pose = poses->front();
  EXPECT_DOUBLE_EQ(pose.timestamp_s, 0.5);
  EXPECT_TRUE(pose.ct_from_depth.translation().isApprox(Eigen::Vector3d(-100, -200, -300), 1e-9));
  EXPECT_TRUE(pose.ct_from_depth.linear().col(0).isApprox(Eigen::Vector3d(0, -1, 0), 1e-6));
  EXPECT_TRUE(pose.ct_from_depth.linear().col(1).isApprox(Eigen::Vector3d(1, 0, 0), 1e-6));
  EXPECT_NEAR(pose.ct_from_depth.linear().determinant(), 1.0, 1e-9);
}

TEST_F(GroundTruthFile, IsRefusedNamingTheLine) {
  EXPECT_THAT(pose_error("# t\n0 0 0 0 0 0 0 1\n1 0 0 0 0 0 1\n"), HasSubstr("line 3"));
  EXPECT_THAT(pose_error("0 0 0 nan 0 0 0 1\n"), HasSubstr("line 1"));
  EXPECT_THAT(pose_error("0 0 0 0 0 0 0 2\n"), HasSubstr("line 1"));
  EXPECT_THAT(pose_error("0 0 0 0 0 0 0 x\n"), HasSubstr("line 1"));
  EXPECT_THAT(pose_error("# nothing\n"), HasSubstr("no line"));
  std::filesystem::remove(path_);
  EXPECT_FALSE(read_ground_truth(path_));
}

TEST_F(GroundTruthFile, TargetsAreBroughtFromRasToLps) {
  EXPECT_THAT(target_error("name,kind,x_mm,y_mm,z_mm\nF01,skin,1.5,-2,3\nT1, internal,0,0,0\n"),
              HasSubstr("line 3"));
  write("name,kind,x_mm,y_mm,z_mm\nF01,skin,1.5,-2,3\nT1,internal,0,0,9\n");
  const auto targets = read_targets(path_);
  ASSERT_TRUE(targets) << targets.error().message;
  ASSERT_EQ(targets->size(), 2U);
  EXPECT_EQ(targets->front().name, "F01");
  EXPECT_TRUE(targets->front().on_skin);
  EXPECT_FALSE(targets->back().on_skin);
  EXPECT_TRUE(targets->front().ct.isApprox(Eigen::Vector3d(-1.5, 2.0, 3.0)));
}

TEST_F(GroundTruthFile, TargetsAreRefusedNamingTheLine) {
  EXPECT_THAT(target_error("F01,bone,1,2,3\n"), HasSubstr("line 1"));
  EXPECT_THAT(target_error("F01,skin,1,2\n"), HasSubstr("line 1"));
  EXPECT_THAT(target_error("F01,skin,1,2,inf\n"), HasSubstr("line 1"));
  EXPECT_THAT(target_error(",skin,1,2,3\n"), HasSubstr("line 1"));
  EXPECT_THAT(target_error("name,kind,x_mm,y_mm,z_mm\n"), HasSubstr("no line"));
}

/// Vertices of a test body as skin targets, moved by `shift`.
std::vector<Target> skin_targets(const TriangleMesh& mesh, const Eigen::Vector3d& shift) {
  std::vector<Target> targets;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 97) {
    targets.push_back({fmt::format("F{}", i), true, mesh.vertices[i].cast<double>() + shift});
  }
  targets.push_back({"inside", false, Eigen::Vector3d::Zero()});
  return targets;
}

class AlignTruth : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    mesh_ = internal::bumpy_body(60, {100.0F, 150.0F, 200.0F});
    field_ = *DistanceField::build(mesh_);
  }

  static inline TriangleMesh mesh_;
  static inline DistanceField field_;
  const Eigen::Vector3d center_{110.0, 140.0, 190.0};
};

TEST_F(AlignTruth, LeavesTargetsOnTheSkinAlone) {
  const auto aligned = align_truth_to_case(std::vector<TimedPose>(1),
                                           skin_targets(mesh_, Eigen::Vector3d::Zero()),
                                           TruthFrame::kAuto,
                                           field_,
                                           center_);
  ASSERT_TRUE(aligned) << aligned.error().message;
  EXPECT_TRUE(aligned->warning.empty());
  EXPECT_TRUE(aligned->targets[0].ct.isApprox(mesh_.vertices[0].cast<double>()));
}

TEST_F(AlignTruth, ShiftsTruthAndTargetsFromTheVolumesCentreAndSaysSo) {
  const auto aligned = align_truth_to_case(
      std::vector<TimedPose>(1), skin_targets(mesh_, -center_), TruthFrame::kAuto, field_, center_);
  ASSERT_TRUE(aligned) << aligned.error().message;
  EXPECT_THAT(aligned->warning, HasSubstr("centre of the CT volume"));
  EXPECT_TRUE(aligned->targets[0].ct.isApprox(mesh_.vertices[0].cast<double>(), 1e-9));
  EXPECT_TRUE(aligned->poses[0].ct_from_depth.translation().isApprox(center_));
}

TEST_F(AlignTruth, TellsTheTwoCentresOfASliceStackApart) {
  const Eigen::Vector3d half_voxel(-0.5, -0.5, 1.0);
  const Eigen::Vector3d true_center = center_ + Eigen::Vector3d(0.0, 0.0, 1.0);
  const auto aligned = align_truth_to_case(std::vector<TimedPose>(1),
                                           skin_targets(mesh_, -true_center),
                                           TruthFrame::kCentred,
                                           field_,
                                           center_,
                                           half_voxel);
  ASSERT_TRUE(aligned) << aligned.error().message;
  EXPECT_TRUE(aligned->poses[0].ct_from_depth.translation().isApprox(true_center));
}

TEST_F(AlignTruth, RefusesTargetsOfAnotherCase) {
  const auto refused = align_truth_to_case(std::vector<TimedPose>(1),
                                           skin_targets(mesh_, {60.0, 0.0, 300.0}),
                                           TruthFrame::kAuto,
                                           field_,
                                           center_);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("mm off the case's skin"));
  EXPECT_FALSE(
      align_truth_to_case({}, skin_targets(mesh_, -center_), TruthFrame::kCt, field_, center_));
}

}  // namespace
}  // namespace mor
