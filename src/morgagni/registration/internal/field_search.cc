// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/field_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace mor::internal {
namespace {

constexpr float kOnSkinMm = 8.0F;
/// Beyond these it is most likely wrong.
constexpr double kPoorPrecision = 0.4;
constexpr double kPoorFloating = 0.1;
/// With this share of all points' weight on the skin a poor pose is more likely that of a sensor
/// with a systematic error than a wrong one: no more than the first round is spent on it.
constexpr double kSupport = 0.15;

/// Places around the start that are looked at, as far off as a rough start may be, and how many
/// tries are spent from the best of them while the best pose is poor.
struct Round {
  int num_places;
  int num_tries;
};
constexpr std::array<Round, 2> kRounds = {{{64, 24}, {192, 60}}};
/// One try in so many is a plain approach, and one in so many starts near the best pose so far: low
/// approaches from near by find skin among clutter, plain ones a body that is far off.
constexpr int kPlainTry = 6;
constexpr int kNearTry = 3;
/// Tries while the best pose is in doubt, though not poor.
constexpr int kNumTries = 12;
constexpr double kPlaceShiftMm = 30.0;
constexpr double kPlaceTurnRad = 20.0 * std::numbers::pi / 180.0;
/// Places around the best pose, for one that has slid along the body or lies on a cloth.
constexpr double kNearShiftMm = 15.0;
constexpr double kNearTurnRad = 10.0 * std::numbers::pi / 180.0;
constexpr Stage kFirstLook = {{12.0F, 40.0F, 0.5F}, false, PointShare::kFew};
constexpr float kAboutOnSkinMm = 20.0F;
/// An approached pose with less than this share of the best score is not worth refining.
constexpr double kHopeless = 0.4;
/// Poses that move the points by less against each other are one.
constexpr double kSameMm = 4.0;

/// Spread evenly over [-1, 1]^6: the additive recurrence R_6 (Roberts, "The unreasonable
/// effectiveness of quasirandom sequences", 2018), whose steps are powers of the golden ratio's
/// kin.
Vector6d spread_evenly(int number) {
  constexpr double kRatio = 1.1347241384015194;  // x^7 = x + 1
  Vector6d place;
  double step = 1.0;
  for (double& value : place) {
    step /= kRatio;
    const double x = 0.5 + step * number;
    value = 2.0 * (x - std::floor(x)) - 1.0;
  }
  return place;
}

Eigen::Vector3d middle_of(const PointCloud& cloud) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& point : cloud.points) sum += point.cast<double>();
  return sum / static_cast<double>(std::max<std::size_t>(1, cloud.size()));
}

Eigen::Isometry3d moved(const Eigen::Isometry3d& pose,
                        const Eigen::Vector3d& turn_rad,
                        const Eigen::Vector3d& about_mm,
                        const Eigen::Vector3d& shift_mm) {
  return Eigen::Translation3d(about_mm + shift_mm) *
         Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized()) *
         Eigen::Translation3d(-about_mm) * pose;
}

}  // namespace

/// For choosing among several.
double FieldSearch::Candidate::score() const {
  return fit.evidence() * (1.0 - 0.5 * view.absent_fraction());
}

bool FieldSearch::Candidate::is_clear(const Clearness& least) const {
  return fit.share_of_near() >= least.least_precision && fit.pair_fraction >= least.least_support &&
         view.absent_fraction() <= least.most_absent;
}

bool FieldSearch::Candidate::is_poor() const {
  return fit.share_of_near() < kPoorPrecision || view.floating_fraction() > kPoorFloating;
}

bool FieldSearch::Candidate::has_support() const {
  return fit.pair_fraction >= kSupport && view.floating_fraction() <= kPoorFloating;
}

FieldSearch::FieldSearch(FieldAlignment& alignment,
                         const SkinProbe& probe,
                         const PointCloud& moving,
                         int max_iterations)
    : alignment_(alignment),
      probe_(probe),
      moving_(moving),
      map_(moving),
      max_iterations_(max_iterations) {}

bool FieldSearch::run() {
  const Eigen::Isometry3d start = alignment_.pose();
  try_from(start, kApproach);
  const bool is_agreed =
      is_in_doubt() && try_from(start, kLowApproach) && best_ && best_->is_clear(kClearIfAgreed);
  if (is_in_doubt() && !is_agreed) try_around(start);
  alignment_.set_pose(best_ ? best_->pose : start);
  return best_.has_value();
}

void FieldSearch::try_around(const Eigen::Isometry3d& start) {
  int first_place = 1;
  int num_near = 0;
  for (const Round& round : kRounds) {
    if (first_place > 1 && best_ && best_->has_support()) return;
    const auto places = places_around(start, first_place, round.num_places);
    first_place += round.num_places;
    // Either approach takes the places in their order.
    std::size_t next_plain = 0;
    std::size_t next_low = 0;
    for (int i = 0; i < round.num_tries; ++i) {
      if (!is_in_doubt() || (i >= kNumTries && best_ && !best_->is_poor())) return;
      if (i % kPlainTry == 1) {
        try_from(places[next_plain++], kApproach);
      } else if (i % kNearTry == 2 && best_) {
        try_from(place_near(best_->pose, ++num_near), kLowApproach);
      } else {
        try_from(places[next_low++], kLowApproach);
      }
    }
  }
}

Eigen::Isometry3d FieldSearch::place_near(const Eigen::Isometry3d& pose, int number) const {
  const Vector6d place = spread_evenly(number);
  return moved(pose,
               kNearTurnRad * place.head<3>(),
               probe_.facing_center(pose),
               kNearShiftMm * place.tail<3>());
}

std::vector<Eigen::Isometry3d> FieldSearch::places_around(const Eigen::Isometry3d& start,
                                                          int first,
                                                          int count) {
  // A start may be turned about the body or about all that was cut out of the picture, most of
  // which may be a table: there 20 degrees are more than 100 mm at the body.
  const Eigen::Vector3d skin_mm = probe_.facing_center(start);
  const Eigen::Vector3d points_mm = start * middle_of(moving_);
  std::vector<Eigen::Isometry3d> places;
  std::vector<double> scores;
  for (int i = first; i < first + count; ++i) {
    const Vector6d place = spread_evenly(i);
    places.push_back(moved(start,
                           kPlaceTurnRad * place.head<3>(),
                           i % 2 == 0 ? skin_mm : points_mm,
                           kPlaceShiftMm * place.tail<3>()));
    alignment_.set_pose(places.back());
    const double absent = probe_.look(map_, places.back(), kAboutOnSkinMm).absent_fraction();
    scores.push_back(alignment_.fit(kFirstLook).score() * (1.0 - absent));
  }
  std::vector<std::size_t> order(places.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&scores](std::size_t a, std::size_t b) {
    return std::pair(-scores[a], a) < std::pair(-scores[b], b);
  });
  std::vector<Eigen::Isometry3d> sorted;
  for (const std::size_t i : order) sorted.push_back(places[i]);
  return sorted;
}

bool FieldSearch::try_from(const Eigen::Isometry3d& pose, Stages approach) {
  alignment_.set_pose(pose);
  if (!alignment_.run_all(approach.first(kHalfway), max_iterations_)) return false;
  if (!is_new(halfway_)) return true;
  if (!alignment_.run_all(approach.subspan(kHalfway), max_iterations_)) return false;
  if (!is_new(approached_)) return true;
  // Refinement takes most of a try's time and makes no poor pose a good one.
  if (best_ && candidate().score() < kHopeless * best_->score()) return false;
  if (!alignment_.run_all(kRefinement, max_iterations_)) return false;
  const Candidate found = candidate();
  if (!best_ || found.score() > best_->score()) best_ = found;
  return false;
}

FieldSearch::Candidate FieldSearch::candidate() {
  return {alignment_.pose(),
          alignment_.fit(kCloseLook),
          probe_.look(map_, alignment_.pose(), kOnSkinMm)};
}

bool FieldSearch::is_new(std::vector<Eigen::Isometry3d>& known) const {
  for (const Eigen::Isometry3d& pose : known) {
    if (alignment_.distance_mm(pose) < kSameMm) return false;
  }
  known.push_back(alignment_.pose());
  return true;
}

}  // namespace mor::internal
