// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/compute/compute_context.h"
#include "morgagni/registration/internal/icp_backend.h"
#include "morgagni/registration/internal/icp_kernels.h"

namespace mor::internal {
namespace {

constexpr std::uint32_t kNoPartner = 0xFFFFFFFFU;

/// float4 of OpenCL.
struct alignas(16) Float4 {
  float x = 0.0F;
  float y = 0.0F;
  float z = 0.0F;
  float w = 0.0F;
};

Float4 float4(const Eigen::Vector3f& v, float w = 0.0F) {
  return {v.x(), v.y(), v.z(), w};
}

/// Pose of kernels/icp_common.cl.
using DevicePose = std::array<Float4, 3>;

DevicePose device_pose(const Eigen::Isometry3d& fixed_from_moving) {
  const Eigen::Matrix4f m = fixed_from_moving.matrix().cast<float>();
  return {Float4{m(0, 0), m(0, 1), m(0, 2), m(0, 3)},
          Float4{m(1, 0), m(1, 1), m(1, 2), m(1, 3)},
          Float4{m(2, 0), m(2, 1), m(2, 2), m(2, 3)}};
}

class IcpBackendOpencl final : public IcpBackend {
 public:
  IcpBackendOpencl(std::shared_ptr<const IcpSurface> surface,
                   ComputeContext context,
                   IcpKernels kernels)
      : surface_(std::move(surface)), context_(std::move(context)), kernels_(std::move(kernels)) {}

  /// Once: the fixed surface and its tree.
  [[nodiscard]] Result<void> upload_surface();

  std::string name() const override { return context_.device().name; }
  Result<void> load(std::span<const Eigen::Vector3f> moving) override;
  Result<void> find_pairs(const Eigen::Isometry3d& fixed_from_moving) override;
  Result<void> keep_closest(std::size_t num_kept) override;
  Result<PairSums> sum_pairs() override;
  Result<WeightedEquations> linearize(const Eigen::Isometry3d& fixed_from_moving,
                                      const Eigen::Vector3d& pivot) override;
  Result<std::vector<std::uint32_t>> partners() override;
  Result<std::vector<std::uint32_t>> kept() override;

 private:
  [[nodiscard]] bool is_weighted() const { return surface_->metric == PairMetric::kWeighted; }
  [[nodiscard]] std::uint32_t num_points() const { return static_cast<std::uint32_t>(num_points_); }
  [[nodiscard]] std::uint32_t num_kept() const { return static_cast<std::uint32_t>(num_kept_); }
  /// Makes room for a cloud, once and for all clouds that are no larger.
  [[nodiscard]] Result<void> reserve(std::size_t num_points);
  [[nodiscard]] Result<void> move_points(const Eigen::Isometry3d& fixed_from_moving);

  std::shared_ptr<const IcpSurface> surface_;
  ComputeContext context_;
  IcpKernels kernels_;
  std::size_t num_points_ = 0;
  std::size_t num_kept_ = 0;
  std::size_t capacity_ = 0;  ///< Points that there is room for.
  Eigen::Vector3f moving_pivot_ = Eigen::Vector3f::Zero();
  Eigen::Vector3f fixed_pivot_ = Eigen::Vector3f::Zero();  ///< Where the pose puts it.
  std::vector<Float4> staging_;

  ComputeBuffer tree_;           ///< Of the fixed points; the axis in w.
  ComputeBuffer fixed_errors_;   ///< Weighted only, as other errors.
  ComputeBuffer largest_below_;  ///< Weighted only: IcpSurface's largest_below_mm2.
  ComputeBuffer moving_;
  ComputeBuffer moving_errors_;
  ComputeBuffer moved_;
  ComputeBuffer moved_errors_;
  ComputeBuffer partners_;
  ComputeBuffer distances_sq_;
};

Result<void> IcpBackendOpencl::upload_surface() {
  const std::size_t count = surface_->points.size();
  staging_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    staging_.push_back(float4(surface_->points[i], surface_->tree.axis[i]));
  }
  MOR_TRY(tree_, context_.allocate(count * sizeof(Float4)));
  MOR_CHECK(context_.write<Float4>(tree_, staging_));
  if (!is_weighted()) return {};
  staging_.clear();
  for (const auto& error : surface_->errors) {
    staging_.push_back(float4(error.along_normal_mm, error.sideways_mm2));
  }
  MOR_TRY(fixed_errors_, context_.allocate(count * sizeof(Float4)));
  MOR_CHECK(context_.write<Float4>(fixed_errors_, staging_));
  MOR_TRY(largest_below_, context_.allocate(count * sizeof(float)));
  return context_.write<float>(largest_below_, surface_->largest_below_mm2);
}

Result<void> IcpBackendOpencl::reserve(std::size_t num_points) {
  if (num_points <= capacity_) return {};
  capacity_ = 0;
  for (auto* buffer : {&moving_, &moved_}) {
    MOR_TRY(*buffer, context_.allocate(num_points * sizeof(Float4)));
  }
  if (is_weighted()) {
    for (auto* buffer : {&moving_errors_, &moved_errors_}) {
      MOR_TRY(*buffer, context_.allocate(num_points * sizeof(Float4)));
    }
  }
  MOR_TRY(partners_, context_.allocate(num_points * sizeof(std::uint32_t)));
  MOR_TRY(distances_sq_, context_.allocate(num_points * sizeof(float)));
  capacity_ = num_points;
  return {};
}

Result<void> IcpBackendOpencl::load(std::span<const Eigen::Vector3f> moving) {
  MOR_CHECK(reserve(moving.size()));
  num_points_ = moving.size();
  moving_pivot_ = moving_pivot_of(moving);
  staging_.clear();
  for (const auto& point : moving) staging_.push_back(float4(point));
  MOR_CHECK(context_.write<Float4>(moving_, staging_));
  if (is_weighted()) {
    staging_.clear();
    for (const auto& error : sensor_errors(moving)) {
      staging_.push_back(float4(error.along_ray_mm, error.sideways_mm2));
    }
    MOR_CHECK(context_.write<Float4>(moving_errors_, staging_));
  }
  const std::vector<std::uint32_t> none(moving.size(), kNoPartner);
  return context_.write<std::uint32_t>(partners_, none);
}

Result<void> IcpBackendOpencl::move_points(const Eigen::Isometry3d& fixed_from_moving) {
  const DevicePose pose = device_pose(fixed_from_moving);
  const auto size = WorkSize::at_least(num_points_, IcpKernels::kGroupSize);
  MOR_CHECK(context_.run(kernels_.move_points, size, num_points(), pose, moving_, moved_));
  if (!is_weighted()) return {};
  return context_.run(
      kernels_.turn_errors, size, num_points(), pose, moving_errors_, moved_errors_);
}

Result<void> IcpBackendOpencl::find_pairs(const Eigen::Isometry3d& fixed_from_moving) {
  MOR_CHECK(move_points(fixed_from_moving));
  fixed_pivot_ = (fixed_from_moving * moving_pivot_.cast<double>()).cast<float>();
  num_kept_ = num_points_;
  const auto size = WorkSize::at_least(num_points_, IcpKernels::kGroupSize);
  const auto num_nodes = static_cast<std::uint32_t>(surface_->points.size());
  if (!is_weighted()) {
    return context_.run(kernels_.find_nearest,
                        size,
                        num_points(),
                        num_nodes,
                        moved_,
                        tree_,
                        partners_,
                        distances_sq_);
  }
  return context_.run(kernels_.find_nearest_weighted,
                      size,
                      num_points(),
                      num_nodes,
                      moved_,
                      moved_errors_,
                      tree_,
                      fixed_errors_,
                      largest_below_,
                      partners_,
                      distances_sq_);
}

Result<void> IcpBackendOpencl::keep_closest(std::size_t num_kept) {
  num_kept_ = num_kept;
  return kernels_.sort(context_, distances_sq_, num_points_);
}

Result<PairSums> IcpBackendOpencl::sum_pairs() {
  std::array<double, 19> s{};
  MOR_CHECK(kernels_.reduce(context_,
                            s,
                            kernels_.sum_pairs,
                            num_points(),
                            num_kept(),
                            kExplainedMm * kExplainedMm,
                            kNearMm * kNearMm,
                            float4(moving_pivot_),
                            float4(fixed_pivot_),
                            kernels_.sort_order,
                            moving_,
                            moved_,
                            tree_,
                            partners_,
                            distances_sq_));
  PairSums sums;
  sums.num_explained = s[0];
  sums.num_near = s[1];
  sums.sum_sq_mm2 = s[2];
  sums.sum_weighted_sq = s[3];
  sums.moving = Eigen::Vector3d(s[4], s[5], s[6]);
  sums.fixed = Eigen::Vector3d(s[7], s[8], s[9]);
  sums.products = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&s[10]);
  sums.moving_pivot = moving_pivot_;
  sums.fixed_pivot = fixed_pivot_;
  return sums;
}

Result<WeightedEquations> IcpBackendOpencl::linearize(const Eigen::Isometry3d& fixed_from_moving,
                                                      const Eigen::Vector3d& pivot) {
  MOR_CHECK(move_points(fixed_from_moving));
  std::array<double, 28> s{};
  MOR_CHECK(kernels_.reduce(context_,
                            s,
                            kernels_.sum_equations,
                            num_points(),
                            num_kept(),
                            float4(pivot.cast<float>()),
                            kernels_.sort_order,
                            moved_,
                            moved_errors_,
                            tree_,
                            fixed_errors_,
                            partners_));
  WeightedEquations equations;
  std::size_t next = 0;
  for (Eigen::Index row = 0; row < 6; ++row) {
    for (Eigen::Index column = row; column < 6; ++column) {
      equations.information(row, column) = s[next];
      equations.information(column, row) = s[next];
      ++next;
    }
  }
  equations.gradient = Eigen::Map<const Vector6d>(&s[next]);
  equations.sum_weighted_sq = s[27];
  return equations;
}

Result<std::vector<std::uint32_t>> IcpBackendOpencl::partners() {
  std::vector<std::uint32_t> partners(num_points_);
  MOR_CHECK(context_.read<std::uint32_t>(partners_, partners));
  return partners;
}

Result<std::vector<std::uint32_t>> IcpBackendOpencl::kept() {
  std::vector<std::uint32_t> kept(num_kept_);
  if (num_kept_ < num_points_) {
    MOR_CHECK(context_.read<std::uint32_t>(kernels_.sort_order, kept));
  } else {
    std::iota(kept.begin(), kept.end(), std::uint32_t{0});
  }
  return kept;
}

}  // namespace

Result<std::unique_ptr<IcpBackend>> make_icp_backend_opencl(
    std::shared_ptr<const IcpSurface> surface, const std::string& device, SumPrecision precision) {
  MOR_TRY(auto context, ComputeContext::open(device));
  MOR_TRY(auto kernels, IcpKernels::build(context, precision));
  auto backend = std::make_unique<IcpBackendOpencl>(
      std::move(surface), std::move(context), std::move(kernels));
  MOR_CHECK(backend->upload_surface());
  return backend;
}

}  // namespace mor::internal
