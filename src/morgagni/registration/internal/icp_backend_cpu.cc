// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "morgagni/registration/internal/icp_backend.h"

namespace mor::internal {
namespace {

constexpr std::uint32_t kNoPartner = 0xFFFFFFFFU;

// The arithmetic of kernels/icp_common.cl, operation by operation (this file and the kernels are
// compiled without fused multiply-adds): all devices pair the same points even where two are almost
// equally near, so that an alignment takes the same way everywhere.

float dot(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}

Eigen::Vector3f rotated(const Eigen::Matrix4f& pose, const Eigen::Vector3f& v) {
  const auto row = [&](Eigen::Index i) {
    return pose(i, 0) * v.x() + pose(i, 1) * v.y() + pose(i, 2) * v.z();
  };
  return {row(0), row(1), row(2)};
}

Eigen::Vector3f moved_by(const Eigen::Matrix4f& pose, const Eigen::Vector3f& p) {
  return rotated(pose, p) + pose.block<3, 1>(0, 3);
}

float distance_sq(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return dot(a - b, a - b);
}

/// A symmetric 3x3 matrix.
struct Symmetric {
  float xx, xy, xz, yy, yz, zz;
};

/// Of the difference of a pair. Maier-Hein et al. 2012: W = (R Sigma_x R^T + Sigma_y)^(-1/2), so
/// W^T W is its inverse.
Symmetric pair_covariance(const SensorError& moved, const SkinError& fixed) {
  const Eigen::Vector3f& a = moved.along_ray_mm;
  const Eigen::Vector3f& b = fixed.along_normal_mm;
  const float sideways = moved.sideways_mm2 + fixed.sideways_mm2;
  return {a.x() * a.x() - b.x() * b.x() + sideways,
          a.x() * a.y() - b.x() * b.y(),
          a.x() * a.z() - b.x() * b.z(),
          a.y() * a.y() - b.y() * b.y() + sideways,
          a.y() * a.z() - b.y() * b.z(),
          a.z() * a.z() - b.z() * b.z() + sideways};
}

Symmetric adjugate(const Symmetric& c) {
  return {c.yy * c.zz - c.yz * c.yz,
          c.xz * c.yz - c.xy * c.zz,
          c.xy * c.yz - c.xz * c.yy,
          c.xx * c.zz - c.xz * c.xz,
          c.xy * c.xz - c.xx * c.yz,
          c.xx * c.yy - c.xy * c.xy};
}

float determinant(const Symmetric& c, const Symmetric& adjugate_of_c) {
  return c.xx * adjugate_of_c.xx + c.xy * adjugate_of_c.xy + c.xz * adjugate_of_c.xz;
}

Eigen::Vector3f times(const Symmetric& m, const Eigen::Vector3f& v) {
  return {m.xx * v.x() + m.xy * v.y() + m.xz * v.z(),
          m.xy * v.x() + m.yy * v.y() + m.yz * v.z(),
          m.xz * v.x() + m.yz * v.y() + m.zz * v.z()};
}

/// d^T C^-1 d, without a unit.
float weighted_distance_sq(const Symmetric& c, const Eigen::Vector3f& d) {
  const Symmetric a = adjugate(c);
  return dot(d, times(a, d)) / determinant(c, a);
}

Symmetric inverse(const Symmetric& c) {
  const Symmetric a = adjugate(c);
  const float per_determinant = 1.0F / determinant(c, a);
  return {a.xx * per_determinant,
          a.xy * per_determinant,
          a.xz * per_determinant,
          a.yy * per_determinant,
          a.yz * per_determinant,
          a.zz * per_determinant};
}

class IcpBackendCpu final : public IcpBackend {
 public:
  explicit IcpBackendCpu(std::shared_ptr<const IcpSurface> surface)
      : surface_(std::move(surface)) {}

  std::string name() const override { return "cpu"; }
  Result<void> load(std::span<const Eigen::Vector3f> moving) override;
  Result<void> find_pairs(const Eigen::Isometry3d& fixed_from_moving) override;
  Result<void> keep_closest(std::size_t num_kept) override;
  Result<PairSums> sum_pairs() override;
  Result<WeightedEquations> linearize(const Eigen::Isometry3d& fixed_from_moving,
                                      const Eigen::Vector3d& pivot) override;
  Result<std::vector<std::uint32_t>> partners() override { return partners_; }
  Result<std::vector<std::uint32_t>> kept() override { return kept_; }

 private:
  [[nodiscard]] bool is_weighted() const { return surface_->metric == PairMetric::kWeighted; }
  void move_points(const Eigen::Isometry3d& fixed_from_moving);
  void find_nearest(std::size_t i);
  void find_nearest_weighted(std::size_t i);

  std::shared_ptr<const IcpSurface> surface_;
  std::vector<Eigen::Vector3f> moving_;
  std::vector<SensorError> errors_;
  Eigen::Vector3f moving_pivot_ = Eigen::Vector3f::Zero();
  Eigen::Vector3f fixed_pivot_ = Eigen::Vector3f::Zero();  ///< Where the pose puts it.
  std::vector<Eigen::Vector3f> moved_;
  std::vector<SensorError> moved_errors_;
  std::vector<std::uint32_t> partners_;
  std::vector<float> distances_sq_;  ///< By the metric.
  std::vector<std::uint32_t> kept_;
};

Result<void> IcpBackendCpu::load(std::span<const Eigen::Vector3f> moving) {
  moving_.assign(moving.begin(), moving.end());
  if (is_weighted()) errors_ = sensor_errors(moving);
  moving_pivot_ = moving_pivot_of(moving);
  moved_.resize(moving.size());
  moved_errors_.resize(errors_.size());
  partners_.assign(moving.size(), kNoPartner);
  distances_sq_.resize(moving.size());
  return {};
}

void IcpBackendCpu::move_points(const Eigen::Isometry3d& fixed_from_moving) {
  const Eigen::Matrix4f pose = fixed_from_moving.matrix().cast<float>();
  for (std::size_t i = 0; i < moving_.size(); ++i) moved_[i] = moved_by(pose, moving_[i]);
  for (std::size_t i = 0; i < errors_.size(); ++i) {
    moved_errors_[i] = {rotated(pose, errors_[i].along_ray_mm), errors_[i].sideways_mm2};
  }
}

Result<void> IcpBackendCpu::find_pairs(const Eigen::Isometry3d& fixed_from_moving) {
  move_points(fixed_from_moving);
  fixed_pivot_ = (fixed_from_moving * moving_pivot_.cast<double>()).cast<float>();
  for (std::size_t i = 0; i < moved_.size(); ++i) {
    if (is_weighted()) {
      find_nearest_weighted(i);
    } else {
      find_nearest(i);
    }
  }
  kept_.resize(moved_.size());
  std::iota(kept_.begin(), kept_.end(), std::uint32_t{0});
  return {};
}

/// Besl & McKay 1992, section III.A. The last partner is a first guess.
void IcpBackendCpu::find_nearest(std::size_t i) {
  const Eigen::Vector3f& query = moved_[i];
  std::uint32_t partner = partners_[i];
  float best_mm2 = partner == kNoPartner ? std::numeric_limits<float>::infinity()
                                         : distance_sq(query, surface_->points[partner]);
  traverse(
      surface_->tree,
      surface_->points,
      query,
      [&](std::size_t node) {
        const float distance_mm2 = distance_sq(query, surface_->points[node]);
        if (distance_mm2 >= best_mm2) return;
        best_mm2 = distance_mm2;
        partner = static_cast<std::uint32_t>(node);
      },
      [&](std::size_t /*node*/, float distance_mm) {
        return distance_mm * distance_mm < best_mm2;
      });
  partners_[i] = partner;
  distances_sq_[i] = best_mm2;
}

/// Maier-Hein et al. 2012: the nearest by d^T (R Sigma_x R^T + Sigma_y)^-1 d. No pair beyond a
/// plane d_a away along an axis can be nearer than d_a^2 / (Sigma_x + max Sigma_y)_aa.
void IcpBackendCpu::find_nearest_weighted(std::size_t i) {
  const Eigen::Vector3f& query = moved_[i];
  const SensorError& error = moved_errors_[i];
  const Eigen::Vector3f own_mm2 = error.along_ray_mm.cwiseAbs2().array() + error.sideways_mm2;
  const auto distance_sq_to = [&](std::size_t node) {
    return weighted_distance_sq(pair_covariance(error, surface_->errors[node]),
                                query - surface_->points[node]);
  };
  std::uint32_t partner = partners_[i];
  float best_sq =
      partner == kNoPartner ? std::numeric_limits<float>::infinity() : distance_sq_to(partner);
  traverse(
      surface_->tree,
      surface_->points,
      query,
      [&](std::size_t node) {
        const float distance_sq = distance_sq_to(node);
        if (distance_sq >= best_sq) return;
        best_sq = distance_sq;
        partner = static_cast<std::uint32_t>(node);
      },
      [&](std::size_t node, float distance_mm) {
        const float largest_mm2 =
            own_mm2[surface_->tree.axis[node]] + surface_->largest_below_mm2[node];
        return distance_mm * distance_mm < best_sq * largest_mm2;
      });
  partners_[i] = partner;
  distances_sq_[i] = best_sq;
}

/// Chetverikov et al. 2002, step 2.
Result<void> IcpBackendCpu::keep_closest(std::size_t num_kept) {
  std::iota(kept_.begin(), kept_.end(), std::uint32_t{0});
  std::sort(kept_.begin(), kept_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(distances_sq_[a], a) < std::pair(distances_sq_[b], b);
  });
  kept_.resize(num_kept);
  return {};
}

Result<PairSums> IcpBackendCpu::sum_pairs() {
  PairSums sums;
  sums.moving_pivot = moving_pivot_;
  sums.fixed_pivot = fixed_pivot_;
  for (std::size_t i = 0; i < moved_.size(); ++i) {
    const float distance_mm2 = distance_sq(moved_[i], surface_->points[partners_[i]]);
    if (distance_mm2 <= kExplainedMm * kExplainedMm) sums.num_explained += 1.0;
    if (distance_mm2 <= kNearMm * kNearMm) sums.num_near += 1.0;
  }
  for (const auto i : kept_) {
    const Eigen::Vector3f& partner = surface_->points[partners_[i]];
    const Eigen::Vector3d moving = (moving_[i] - moving_pivot_).cast<double>();
    const Eigen::Vector3d fixed = (partner - fixed_pivot_).cast<double>();
    sums.sum_sq_mm2 += static_cast<double>(distance_sq(moved_[i], partner));
    sums.sum_weighted_sq += static_cast<double>(distances_sq_[i]);
    sums.moving += moving;
    sums.fixed += fixed;
    sums.products += moving * fixed.transpose();
  }
  return sums;
}

Result<WeightedEquations> IcpBackendCpu::linearize(const Eigen::Isometry3d& fixed_from_moving,
                                                   const Eigen::Vector3d& pivot) {
  move_points(fixed_from_moving);
  const Eigen::Vector3f pivot_f = pivot.cast<float>();
  WeightedEquations equations;
  for (const auto i : kept_) {
    const auto partner = partners_[i];
    const Symmetric weight = inverse(pair_covariance(moved_errors_[i], surface_->errors[partner]));
    const Eigen::Vector3f residual = moved_[i] - surface_->points[partner];
    const Eigen::Vector3f weighted_residual = times(weight, residual);
    const Eigen::Vector3f lever = moved_[i] - pivot_f;
    // How a turn or shift about each axis moves the point, and the same weighted.
    const std::array<Eigen::Vector3f, 6> motions = {Eigen::Vector3f(0.0F, -lever.z(), lever.y()),
                                                    Eigen::Vector3f(lever.z(), 0.0F, -lever.x()),
                                                    Eigen::Vector3f(-lever.y(), lever.x(), 0.0F),
                                                    Eigen::Vector3f::UnitX(),
                                                    Eigen::Vector3f::UnitY(),
                                                    Eigen::Vector3f::UnitZ()};
    for (std::size_t row = 0; row < 6; ++row) {
      const Eigen::Vector3f weighted = times(weight, motions[row]);
      for (std::size_t column = 0; column <= row; ++column) {
        equations.information(row, column) += static_cast<double>(dot(motions[column], weighted));
      }
      equations.gradient[row] += static_cast<double>(dot(motions[row], weighted_residual));
    }
    equations.sum_weighted_sq += static_cast<double>(dot(residual, weighted_residual));
  }
  equations.information = equations.information.selfadjointView<Eigen::Lower>();
  return equations;
}

}  // namespace

std::unique_ptr<IcpBackend> make_icp_backend_cpu(std::shared_ptr<const IcpSurface> surface) {
  return std::make_unique<IcpBackendCpu>(std::move(surface));
}

}  // namespace mor::internal
