// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/field_registration.h"

#include <array>
#include <numbers>
#include <span>
#include <utility>

#include "morgagni/registration/internal/alignment_input.h"
#include "morgagni/registration/internal/field_alignment.h"

namespace mor::internal {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

/// From a rough start to the right part of the skin, by few points. Above the skin the kernel is
/// half as wide as below: what lies above may be clutter, what seems to lie below is an error of
/// the pose. Without this a towel on a head pulls it up.
constexpr std::array<Stage, 5> kApproach = {{
    {{25.0F, 50.0F, 0.5F}, false, PointShare::kFew, 5, 2.0},
    {{12.5F, 25.0F, 0.5F}, false, PointShare::kFew, 5, 1.0},
    {{6.0F, 12.0F, 0.5F}, false, PointShare::kFew, 5, 0.5},
    {{6.0F, 12.0F, 0.5F}, true, PointShare::kFew, 3, 0.5},
    {{3.0F, 6.0F, 0.7F}, true, PointShare::kFew, 5, 0.1},
}};
/// A tracked start needs no more than these of them.
constexpr std::size_t kTrackedEntry = 2;

/// Then down to the lowest part of what is seen: a thin cloth that lies on most of the skin draws
/// the pose up to a compromise, from which rows below the skin bring it back and rows above do not.
constexpr PairingRule kLowRule = {4.0F, 12.0F, 0.7F, 1.2F, 8.0F};
constexpr PairingRule kFinalRule = {6.0F, 6.0F, 0.7F, 2.0F, 2.0F};
constexpr std::array<Stage, 3> kRefinement = {{
    {kLowRule, true, PointShare::kRuns, 12, 0.05},
    {kFinalRule, true, PointShare::kRuns, 4, 0.05},
    {kFinalRule, true, PointShare::kAll, 3, 0.05},
}};

PoseSpread spread_of(StartQuality start) {
  if (start == StartQuality::kRough) {
    return {.shift_mm = 30.0, .rotation_rad = 20.0 * kRadPerDeg};
  }
  return {.shift_mm = 10.0, .rotation_rad = 5.0 * kRadPerDeg};
}

/// A pose that explains less of the points' weight than this, or puts more of them below the skin,
/// may be the wrong one: others are tried.
constexpr double kDoubtfulPairs = 0.35;
constexpr double kDoubtfulBelow = 0.01;
/// Of the points near the skin, the share of weight that the kernel leaves: lower where they do not
/// lie along it.
constexpr double kDoubtfulShare = 0.5;
/// They start this far to either side, about each axis and along it.
constexpr double kTurnRad = 15.0 * kRadPerDeg;
constexpr double kShiftMm = 20.0;
/// So many that are not better by so much are enough.
constexpr int kMaxVain = 4;
constexpr double kBetter = 0.01;

/// The registration of one moving surface.
class Strategy {
 public:
  Strategy(FieldAlignment& alignment, int max_iterations)
      : alignment_(alignment), max_iterations_(max_iterations) {}

  RegistrationResult run(StartQuality start) {
    const std::span<const Stage> approach(kApproach);
    if (start == StartQuality::kTracked) {
      if (run_all(approach.subspan(kTrackedEntry))) run_all(kRefinement);
    } else if (search()) {
      run_all(kRefinement);
    }
    return alignment_.finish(kFinalRule);
  }

 private:
  /// Runs stage after stage; false when one finds too few points of the surface.
  bool run_all(std::span<const Stage> stages) {
    for (const Stage& stage : stages) {
      if (!alignment_.run(stage, max_iterations_)) return false;
    }
    return true;
  }

  /// Approaches from the start, and where that ends in doubt from places around it.
  bool search() {
    const Eigen::Isometry3d start = alignment_.pose();
    const Eigen::Vector3d pivot = alignment_.pivot();
    bool found = try_from(start);
    for (const bool turns : {true, false}) {
      for (int side = 0; side < 6 && is_doubtful(); ++side) {
        const Eigen::Vector3d axis = (side % 2 == 0 ? 1.0 : -1.0) * Eigen::Vector3d::Unit(side / 2);
        Eigen::Isometry3d motion(Eigen::Translation3d(kShiftMm * axis));
        if (turns) {
          motion = Eigen::Translation3d(pivot) * Eigen::AngleAxisd(kTurnRad, axis) *
                   Eigen::Translation3d(-pivot);
        }
        found = try_from(motion * start) || found;
      }
    }
    alignment_.set_pose(found ? best_ : start);
    return found;
  }

  /// Little explained may be clutter; skin in front of what the camera sees cannot be right.
  [[nodiscard]] bool is_doubtful() const {
    return best_fit_.below_fraction > kDoubtfulBelow ||
           best_fit_.pair_fraction < kDoubtfulShare * best_fit_.near_fraction ||
           (best_fit_.pair_fraction < kDoubtfulPairs && num_vain_ < kMaxVain);
  }

  bool try_from(const Eigen::Isometry3d& pose) {
    alignment_.set_pose(pose);
    if (!run_all(kApproach)) return false;
    const PoseFit fit = alignment_.fit(kApproach.back());
    if (fit.score() < best_fit_.score() + kBetter) ++num_vain_;
    if (fit.score() > best_fit_.score()) {
      best_fit_ = fit;
      best_ = alignment_.pose();
    }
    return true;
  }

  FieldAlignment& alignment_;
  int max_iterations_;
  Eigen::Isometry3d best_ = Eigen::Isometry3d::Identity();
  int num_vain_ = 0;
  PoseFit best_fit_{.below_fraction = 1.0};
};

}  // namespace

FieldRegistration::FieldRegistration(std::shared_ptr<const FixedSurface> fixed,
                                     const RegistrationOptions& options)
    : fixed_(std::move(fixed)), options_(options) {}

Result<RegistrationResult> FieldRegistration::align(const PointCloud& moving,
                                                    const Eigen::Isometry3d& fixed_from_moving_init,
                                                    StartQuality start) const {
  MOR_CHECK(check_alignment_input(moving, fixed_from_moving_init, /*needs_normals=*/true));
  FieldAlignment alignment(fixed_->field, moving, fixed_from_moving_init, spread_of(start));
  return Strategy(alignment, options_.max_iterations).run(start);
}

}  // namespace mor::internal
