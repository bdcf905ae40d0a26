// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/result.h"
#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/internal/icp_surface.h"

namespace mor::internal {

/// A moving point is explained where the fixed surface is no farther than this,
inline constexpr float kExplainedMm = 5.0F;
/// and near it at all within this.
inline constexpr float kNearMm = 500.0F;

/// Sums over the pairs that count, in double or as good as the device has it. Distances of pairs
/// are Euclidean unless called weighted.
struct PairSums {
  double num_explained = 0.0;    ///< Of all pairs, trimmed or not.
  double num_near = 0.0;         ///< Of all pairs.
  double sum_sq_mm2 = 0.0;       ///< Of the distances.
  double sum_weighted_sq = 0.0;  ///< Of the metric's distances; the same where it is Euclidean.
  /// Of the moving points in their own frame and of their partners, each relative to its pivot: the
  /// moving points' centroid and where the pose puts it, in whole floats. A product's row is the
  /// moving one.
  Eigen::Vector3d moving = Eigen::Vector3d::Zero();
  Eigen::Vector3d fixed = Eigen::Vector3d::Zero();
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  Eigen::Vector3f moving_pivot = Eigen::Vector3f::Zero();
  Eigen::Vector3f fixed_pivot = Eigen::Vector3f::Zero();
};

/// The weighted squared distances of the pairs that count, linearised about a pose:
/// sum (r + J twist)^T C^-1 (r + J twist) with twist = (rotation about the pivot, shift).
struct WeightedEquations {
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Vector6d gradient = Vector6d::Zero();
  double sum_weighted_sq = 0.0;
};

/// The points' centroid, rounded to float.
[[nodiscard]] inline Eigen::Vector3f moving_pivot_of(std::span<const Eigen::Vector3f> moving) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& point : moving) sum += point.cast<double>();
  return (sum / static_cast<double>(moving.size())).cast<float>();
}

/// The steps of ICP whose cost grows with the number of points, on one device. Keeps its memory
/// between alignments. All poses are of the surface's centred frame.
/// @errors Everything here: kDevice, after which the caller goes on without the device.
/// @threads One at a time.
class IcpBackend {
 public:
  virtual ~IcpBackend() = default;

  [[nodiscard]] virtual std::string name() const = 0;

  /// Takes a frame's points. @param moving  >= 1 finite points, mm, in the camera's frame.
  [[nodiscard]] virtual Result<void> load(std::span<const Eigen::Vector3f> moving) = 0;

  /// Moves the points and pairs each with the nearest fixed one by the surface's metric. All count.
  [[nodiscard]] virtual Result<void> find_pairs(const Eigen::Isometry3d& fixed_from_moving) = 0;

  /// Only the closest pairs count, by the metric; of equals, those of the first points.
  /// @param num_kept  1 to the number of points.
  [[nodiscard]] virtual Result<void> keep_closest(std::size_t num_kept) = 0;

  /// Of the pairs as found.
  [[nodiscard]] virtual Result<PairSums> sum_pairs() = 0;

  /// Of the same pairs at another pose, with the covariances turned along. Weighted metric only.
  [[nodiscard]] virtual Result<WeightedEquations> linearize(
      const Eigen::Isometry3d& fixed_from_moving, const Eigen::Vector3d& pivot) = 0;

  /// Each moving point's partner, as an index into the surface's points.
  [[nodiscard]] virtual Result<std::vector<std::uint32_t>> partners() = 0;

  /// The moving points whose pairs count; sorted by distance where pairs were left out.
  [[nodiscard]] virtual Result<std::vector<std::uint32_t>> kept() = 0;
};

/// The reference.
[[nodiscard]] std::unique_ptr<IcpBackend> make_icp_backend_cpu(
    std::shared_ptr<const IcpSurface> surface);

/// What a device adds up in; kSingle where it has no double.
enum class SumPrecision : std::uint8_t { kSingle, kDouble };

/// @param device  As ComputeContext::open() has it. @errors Its, and those of compiling.
[[nodiscard]] Result<std::unique_ptr<IcpBackend>> make_icp_backend_opencl(
    std::shared_ptr<const IcpSurface> surface,
    const std::string& device,
    SumPrecision precision = SumPrecision::kDouble);

}  // namespace mor::internal
