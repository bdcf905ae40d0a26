// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/tracking/judgement.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <spdlog/fmt/fmt.h>

#include "morgagni/geometry/rigid.h"

namespace mor {
namespace {

/// Collects doubts; the worst one decides.
class Judge {
 public:
  void doubt(Doubt what, Verdict how) {
    if (how == Verdict::kGood) return;
    auto& doubts = judgement_.doubts;
    if (std::find(doubts.begin(), doubts.end(), what) == doubts.end()) doubts.push_back(what);
    judgement_.verdict = std::max(judgement_.verdict, how);
  }

  /// Written so that NaN is bad.
  void at_least(Doubt what, double value, const JudgementLimits::Pair& limits) {
    doubt(what,
          value >= limits.weak  ? Verdict::kGood
          : value >= limits.bad ? Verdict::kWeak
                                : Verdict::kBad);
  }
  void at_most(Doubt what, double value, const JudgementLimits::Pair& limits) {
    at_least(what, -value, {-limits.weak, -limits.bad});
  }

  [[nodiscard]] Judgement judgement() const { return judgement_; }

 private:
  Judgement judgement_;
};

bool jumped(const FrameEvidence& evidence, const JudgementLimits& limits) {
  if (!evidence.expected) return false;
  const double seconds = std::max(0.0, evidence.expected->since_last.count());
  const Eigen::Isometry3d moved =
      evidence.expected->ct_from_depth * evidence.result.fixed_from_moving.inverse();
  const Eigen::Vector3d& seen_mm = evidence.skin.seen_center_mm;
  return (moved * seen_mm - seen_mm).norm() >
             limits.free_jump_mm + seconds * limits.speed_mm_per_s ||
         rotation_angle_rad(moved) > limits.free_turn_rad + seconds * limits.turn_rad_per_s;
}

/// The largest error bound in the middle of the skin seen and a radius to either side of it: a turn
/// about an axis through the middle does not show there.
double widest_bound_mm(const PoseCovariance& pose, const SkinEvidence& skin) {
  double widest_mm = error_bound_mm(pose, skin.seen_center_mm);
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d aside_mm = skin.seen_radius_mm * Eigen::Vector3d::Unit(axis);
    widest_mm = std::max({widest_mm,
                          error_bound_mm(pose, skin.seen_center_mm - aside_mm),
                          error_bound_mm(pose, skin.seen_center_mm + aside_mm)});
  }
  return widest_mm;
}

bool is_open(const FrameEvidence& evidence, const JudgementLimits& limits) {
  return !evidence.covariance || evidence.surface_relief_mm < limits.flat_mm ||
         !(widest_bound_mm(*evidence.covariance, evidence.skin) <= limits.open_bound_mm);
}

}  // namespace

std::string_view to_string(Doubt doubt) {
  switch (doubt) {
    case Doubt::kNoBody:
      return "no-body";
    case Doubt::kResidual:
      return "residual";
    case Doubt::kLittleSeen:
      return "little-seen";
    case Doubt::kUnexplained:
      return "unexplained";
    case Doubt::kFloating:
      return "floating";
    case Doubt::kOpenDirection:
      return "open-direction";
    case Doubt::kJump:
      return "jump";
  }
  return "no-body";
}

Result<void> JudgementLimits::check() const {
  const auto refuse = [](std::string_view name, double weak, double bad) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{}: bad must lie beyond weak, got {} and {}", name, bad, weak));
  };
  const auto check_pair = [&](std::string_view name, const Pair& pair, bool falls) -> Result<void> {
    const double beyond = falls ? pair.weak - pair.bad : pair.bad - pair.weak;
    if (!(beyond >= 0.0)) return refuse(name, pair.weak, pair.bad);
    return {};
  };
  MOR_CHECK(check_pair("seen_fraction", seen_fraction, true));
  MOR_CHECK(check_pair("seen_share", seen_share, true));
  MOR_CHECK(check_pair("explained_fraction", explained_fraction, true));
  MOR_CHECK(check_pair("floating_fraction", floating_fraction, false));
  MOR_CHECK(check_pair("behind_fraction", behind_fraction, false));
  MOR_CHECK(check_pair("residual_scale", residual_scale, false));
  return check_pair("unevenness", unevenness, false);
}

Judgement judge_evidence(const FrameEvidence& evidence, const JudgementLimits& limits) {
  const RegistrationResult& result = evidence.result;
  const SkinEvidence& skin = evidence.skin;
  Judge judge;
  if (result.status == RegistrationStatus::kTooFewPairs || !result.information) {
    judge.doubt(Doubt::kNoBody, Verdict::kBad);
    return judge.judgement();
  }
  judge.at_least(Doubt::kLittleSeen, skin.seen_fraction(), limits.seen_fraction);
  judge.at_least(Doubt::kLittleSeen, skin.seen_share(), limits.seen_share);
  judge.at_least(Doubt::kUnexplained, result.explained_fraction, limits.explained_fraction);
  judge.at_most(Doubt::kFloating, skin.floating_fraction(), limits.floating_fraction);
  judge.at_most(Doubt::kResidual, skin.behind_fraction(), limits.behind_fraction);
  judge.at_most(Doubt::kResidual, result.information->residual_scale, limits.residual_scale);
  judge.at_most(Doubt::kResidual, result.information->unevenness, limits.unevenness);
  if (is_open(evidence, limits)) judge.doubt(Doubt::kOpenDirection, Verdict::kWeak);
  if (jumped(evidence, limits)) judge.doubt(Doubt::kJump, Verdict::kWeak);
  return judge.judgement();
}

double relief_mm(const PointCloud& surface) {
  constexpr std::size_t kStride = 8;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  double count = 0.0;
  for (std::size_t i = 0; i < surface.size(); i += kStride, count += 1.0) {
    const Eigen::Vector3d point = (surface.points[i] - surface.points[0]).cast<double>();
    sum += point;
    squares += point * point.transpose();
  }
  if (count == 0.0) return 0.0;
  const Eigen::Matrix3d scatter = squares / count - sum * sum.transpose() / (count * count);
  const double least =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter, Eigen::EigenvaluesOnly)
          .eigenvalues()[0];
  return std::sqrt(std::max(0.0, least));
}

}  // namespace mor
