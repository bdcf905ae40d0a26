// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/result.h"
#include "morgagni/registration/distance_field.h"

namespace mor {

/// Where the camera truly was at a moment.
struct TimedPose {
  double timestamp_s = 0.0;
  Eigen::Isometry3d ct_from_depth = Eigen::Isometry3d::Identity();  ///< LPS, mm.
};

/// A point at which the registration error is measured.
struct Target {
  std::string name;
  bool on_skin = false;                          ///< Or inside the body.
  Eigen::Vector3d ct = Eigen::Vector3d::Zero();  ///< LPS, mm.
};

/// Reads `groundtruth.txt` of a TUM recording: `time tx ty tz qx qy qz qw`, the camera in the CT's
/// world, metres, RAS+. Converted to LPS mm here and nowhere else.
/// @errors kNotFound, kIo; kInvalidArgument: a line without eight finite numbers, a quaternion that
///         is no rotation, no pose at all (each names the line).
[[nodiscard]] Result<std::vector<TimedPose>> read_ground_truth(const std::filesystem::path& path);

/// Reads `targets.csv`: name,kind (skin | internal),x_mm,y_mm,z_mm, RAS+, with that header.
/// @errors as above.
[[nodiscard]] Result<std::vector<Target>> read_targets(const std::filesystem::path& path);

/// Poses and pictures whose time stamps differ by more have nothing to do with each other.
inline constexpr double kMaxTruthLagS = 0.02;

/// ct_from_depth at a moment: of the pose nearest in time. None farther away than kMaxTruthLagS.
[[nodiscard]] std::optional<Eigen::Isometry3d> truth_at(const std::vector<TimedPose>& truth,
                                                        double time_s);

/// In which world truth and targets are given.
enum class TruthFrame : std::uint8_t {
  kAuto,     ///< The CT's own, or the centred one when only that puts the targets on the skin.
  kCt,       ///< The CT's own.
  kCentred,  ///< Its origin is the centre of the CT's volume.
};

struct AlignedTruth {
  std::vector<TimedPose> poses;
  std::vector<Target> targets;
  std::string warning;  ///< One sentence when something was shifted, else empty.
};

/// Brings truth and targets into the case's frame and checks that the skin targets lie on its skin.
///
/// @param volume_center  Mean of the first and the last voxel's centre, LPS mm.
/// @param half_voxel  From a voxel's centre to its far corner, LPS mm. Tools differ in whether the
///        centre of n slices is (n - 1) / 2 or n / 2: of both, in plane and along the slices, the
///        one with the targets nearer to the skin is taken. Zero: the first.
/// @errors kInvalidArgument: the skin targets are off the skin (median distance above 10 mm, or
///         above 3 mm after the shift): most likely another case's. Without skin targets nothing is
///         checked and kAuto means kCt.
[[nodiscard]] Result<AlignedTruth> align_truth_to_case(
    std::vector<TimedPose> poses,
    std::vector<Target> targets,
    TruthFrame frame,
    const DistanceField& skin,
    const Eigen::Vector3d& volume_center,
    const Eigen::Vector3d& half_voxel = Eigen::Vector3d::Zero());

}  // namespace mor
