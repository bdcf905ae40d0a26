// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/icp_registration.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/log.h"
#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/internal/alignment_input.h"
#include "morgagni/registration/internal/sensor_points.h"
#include "morgagni/registration/internal/surface_shape.h"

namespace mor::internal {
namespace {

constexpr std::size_t kMinPairs = 3;
/// With fewer of the points near the fixed surface the start has nothing to do with it: stray
/// points are always somewhere.
constexpr double kMinNearShare = 0.1;
/// Pairs that hold their weakest direction by less than this leave it open.
constexpr double kMinConstraint = 1e-3;
/// Of the weighted motion: its steps, and the smallest one worth another, mm.
constexpr int kMaxMotionSteps = 20;
constexpr double kMotionStopMm = 1e-4;

bool is_trimmed(RegistrationMethod method) {
  return method == RegistrationMethod::kTrimmedIcp ||
         method == RegistrationMethod::kTrimmedAnisotropicIcp;
}

Result<void> check_fixed(const TriangleMesh& fixed) {
  if (fixed.normals.size() != fixed.vertices.size()) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("the fixed surface needs a normal for each of its {} vertices, got {}",
                    fixed.vertices.size(),
                    fixed.normals.size()));
  }
  const auto is_finite = [](const Eigen::Vector3f& v) { return v.allFinite(); };
  if (!std::all_of(fixed.vertices.begin(), fixed.vertices.end(), is_finite) ||
      !std::all_of(fixed.normals.begin(), fixed.normals.end(), is_finite)) {
    return make_error(ErrorCode::kInvalidArgument,
                      "the fixed surface holds a vertex or normal that is not finite");
  }
  return {};
}

/// One alignment on one device.
class Alignment {
 public:
  Alignment(const IcpSurface& surface,
            const RegistrationOptions& options,
            const PointCloud& moving,
            const Eigen::Isometry3d& fixed_from_moving_init,
            IcpBackend& backend)
      : surface_(surface),
        options_(options),
        moving_(moving),
        init_(fixed_from_moving_init),
        backend_(backend),
        pose_(centered_from_fixed() * init_) {
    result_.fixed_from_moving = init_;
    num_kept_ = moving_.size();
    if (is_trimmed(options_.method)) {
      const double share = options_.overlap * static_cast<double>(moving_.size());
      num_kept_ =
          std::clamp(static_cast<std::size_t>(std::lround(share)), kMinPairs, moving_.size());
    }
  }

  [[nodiscard]] Result<RegistrationResult> run();

 private:
  [[nodiscard]] Eigen::Translation3d centered_from_fixed() const {
    return Eigen::Translation3d(-surface_.center);
  }
  /// Pairs the points at the pose, and takes note of their distances.
  [[nodiscard]] Result<void> pair_up();
  [[nodiscard]] Result<void> iterate();
  /// The next pose from the pairs: Horn's, or the weighted motion.
  [[nodiscard]] Result<void> fit_pairs();
  [[nodiscard]] Result<void> fit_weighted_pairs();
  [[nodiscard]] bool has_shape() const;
  [[nodiscard]] Result<bool> is_held_by_pairs();
  [[nodiscard]] Result<void> return_to_start();

  const IcpSurface& surface_;
  const RegistrationOptions& options_;
  const PointCloud& moving_;
  const Eigen::Isometry3d& init_;
  IcpBackend& backend_;
  Eigen::Isometry3d pose_;  ///< Of the surface's centred frame.
  std::size_t num_kept_ = 0;
  PairSums sums_;
  double residual_ = 0.0;  ///< Root mean square by the metric.
  RegistrationResult result_;
};

Result<void> Alignment::pair_up() {
  MOR_CHECK(backend_.find_pairs(pose_));
  if (num_kept_ < moving_.size()) MOR_CHECK(backend_.keep_closest(num_kept_));
  MOR_TRY(sums_, backend_.sum_pairs());
  const auto count = static_cast<double>(num_kept_);
  residual_ = std::sqrt(sums_.sum_weighted_sq / count);
  result_.rms_distance_mm = std::sqrt(sums_.sum_sq_mm2 / count);
  result_.explained_fraction = sums_.num_explained / static_cast<double>(moving_.size());
  result_.num_pairs = static_cast<int>(num_kept_);
  return {};
}

/// Besl & McKay 1992, section III.C: the motion from the moving points to their nearest fixed ones.
Result<void> Alignment::fit_pairs() {
  if (surface_.metric == PairMetric::kWeighted) return fit_weighted_pairs();
  const auto count = static_cast<double>(num_kept_);
  const Eigen::Vector3d moving = sums_.moving / count;
  const Eigen::Vector3d fixed = sums_.fixed / count;
  pose_ = fit_rigid(fixed + sums_.fixed_pivot.cast<double>(),
                    moving + sums_.moving_pivot.cast<double>(),
                    sums_.products - count * moving * fixed.transpose());
  return {};
}

/// Balachandran & Fitzpatrick 2009: the rotation linearised, the weighted equations solved, the
/// weights turned along, until the motion stands.
Result<void> Alignment::fit_weighted_pairs() {
  for (int i = 0; i < kMaxMotionSteps; ++i) {
    const Eigen::Vector3d pivot = pose_ * sums_.moving_pivot.cast<double>();
    MOR_TRY(const auto equations, backend_.linearize(pose_, pivot));
    const Vector6d twist = -equations.information.ldlt().solve(equations.gradient);
    if (!twist.allFinite()) break;
    const Eigen::Isometry3d turn = se3_exp((Vector6d() << twist.head<3>(), 0, 0, 0).finished());
    pose_ = orthonormalized(Eigen::Translation3d(pivot + twist.tail<3>()) * turn *
                            Eigen::Translation3d(-pivot) * pose_);
    // A lever of 100 mm stands for the extent of what a camera sees.
    if (twist.tail<3>().norm() + 100.0 * twist.head<3>().norm() < kMotionStopMm) break;
  }
  return {};
}

/// Besl & McKay 1992, section IV: pair, move, until the residual improves no more. Theirs never
/// grows; the weighted motion is solved for nearly only, and a step that makes it worse is undone.
Result<void> Alignment::iterate() {
  MOR_CHECK(pair_up());
  if (sums_.num_near < kMinNearShare * static_cast<double>(moving_.size())) {
    // ICP would still slide somewhere and call it an end.
    result_.status = RegistrationStatus::kTooFewPairs;
    return {};
  }
  while (result_.num_iterations < options_.max_iterations) {
    const Eigen::Isometry3d last_pose = pose_;
    const double last_residual = residual_;
    MOR_CHECK(fit_pairs());
    ++result_.num_iterations;
    MOR_CHECK(pair_up());
    const double least_gain = options_.convergence_threshold * residual_;
    if (last_residual - residual_ > least_gain) continue;
    result_.status = RegistrationStatus::kConverged;
    if (residual_ - last_residual > least_gain) {
      pose_ = last_pose;
      MOR_CHECK(pair_up());
    }
    return {};
  }
  return {};
}

/// The sensor's noise hides the shape of what is nearly flat or round.
bool Alignment::has_shape() const {
  double sum_depth_mm = 0.0;
  for (const auto& point : moving_.points) sum_depth_mm += static_cast<double>(point.z());
  const double depth_mm = std::max(0.0, sum_depth_mm / static_cast<double>(moving_.size()));
  const double noise_mm = static_cast<double>(axial_noise_mm(static_cast<float>(depth_mm)));
  return !shape_without_pose(moving_.points, kShapeNoiseRatio * noise_mm);
}

Result<bool> Alignment::is_held_by_pairs() {
  MOR_TRY(const auto partners, backend_.partners());
  MOR_TRY(const auto kept, backend_.kept());
  std::vector<Eigen::Vector3f> points;
  std::vector<Eigen::Vector3f> normals;
  for (const auto idx : kept) {
    points.push_back(surface_.points[partners[idx]]);
    normals.push_back(surface_.normals[partners[idx]]);
  }
  return weakest_constraint(points, normals) >= kMinConstraint;
}

Result<void> Alignment::return_to_start() {
  pose_ = centered_from_fixed() * init_;
  result_.status = RegistrationStatus::kDegenerate;
  return pair_up();
}

Result<RegistrationResult> Alignment::run() {
  MOR_CHECK(backend_.load(moving_.points));
  if (!has_shape()) {
    MOR_CHECK(return_to_start());
    return result_;
  }
  MOR_CHECK(iterate());
  if (result_.status == RegistrationStatus::kTooFewPairs) return result_;
  MOR_TRY(const bool is_held, is_held_by_pairs());
  if (is_held) {
    result_.fixed_from_moving = centered_from_fixed().inverse() * pose_;
  } else {
    MOR_CHECK(return_to_start());
  }
  return result_;
}

}  // namespace

IcpRegistration::IcpRegistration(std::shared_ptr<const IcpSurface> surface,
                                 const RegistrationOptions& options,
                                 std::unique_ptr<IcpBackend> device)
    : surface_(std::move(surface)), options_(options), device_(std::move(device)) {}

Result<RegistrationResult> IcpRegistration::align(const PointCloud& moving,
                                                  const Eigen::Isometry3d& fixed_from_moving_init,
                                                  StartQuality /*start*/) const {
  MOR_CHECK(check_alignment_input(moving, fixed_from_moving_init, /*needs_normals=*/false));
  if (moving.size() < kMinPairs) {
    return RegistrationResult{.fixed_from_moving = fixed_from_moving_init,
                              .status = RegistrationStatus::kTooFewPairs,
                              .num_pairs = static_cast<int>(moving.size())};
  }
  const auto run_on = [&](IcpBackend& backend) {
    return Alignment(*surface_, options_, moving, fixed_from_moving_init, backend).run();
  };
  {
    const std::lock_guard lock(device_mutex_);
    if (device_) {
      auto result = run_on(*device_);
      if (result || result.error().code != ErrorCode::kDevice) return result;
      log::warn("{}; registration goes on on the CPU, without \"{}\"",
                result.error().message,
                device_->name());
      device_.reset();
    }
  }
  return run_on(*make_icp_backend_cpu(surface_));
}

std::string IcpRegistration::device_name() const {
  const std::lock_guard lock(device_mutex_);
  return device_ ? device_->name() : "cpu";
}

Result<std::unique_ptr<FineRegistration>> make_icp_registration(
    const TriangleMesh& fixed, const RegistrationOptions& options) {
  MOR_CHECK(check_fixed(fixed));
  auto surface = std::make_shared<const IcpSurface>(fixed, metric_of(options.method));
  std::unique_ptr<IcpBackend> device;
  if (options.device != "cpu") {
    auto made = make_icp_backend_opencl(surface, options.device);
    if (made) {
      device = *std::move(made);
    } else if (made.error().code == ErrorCode::kInvalidArgument) {
      return tl::unexpected<Error>(made.error());
    } else {
      log::warn("{}; registration runs on the CPU", made.error().message);
    }
  }
  return std::make_unique<IcpRegistration>(std::move(surface), options, std::move(device));
}

}  // namespace mor::internal
