// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/view_gatherer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "morgagni/geometry/rigid.h"

namespace mor {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// What a good sweep reaches; docs/self-calibration.md, "How to move".
constexpr double kWantedDepthMm = 200.0;
constexpr double kWantedRollRad = 30.0 * kDegree;
constexpr double kWantedTurnRad = 60.0 * kDegree;
constexpr int kWantedViewsInPart = 2;
/// Of a part's blocks, so many on the skin fill it.
constexpr double kFilledShare = 0.1;

std::size_t part_of(int at, int size) {
  return static_cast<std::size_t>(
      std::clamp(MotionCoverage::kParts * at / std::max(1, size), 0, MotionCoverage::kParts - 1));
}

/// Rotation about the viewing axis, of the first camera's to this one.
double roll_rad(const Eigen::Isometry3d& first, const Eigen::Isometry3d& now) {
  const Eigen::Quaterniond turn((first.linear().transpose() * now.linear()).eval());
  const double angle = 2.0 * std::atan2(turn.z(), turn.w());
  return std::remainder(angle, 2.0 * std::numbers::pi);
}

}  // namespace

std::vector<std::string> MotionCoverage::missing() const {
  std::vector<std::string> sentences;
  if (far_mm - near_mm < kWantedDepthMm) {
    sentences.emplace_back("Move nearer to the body and farther away, by 30 cm in all.");
  }
  if (roll_rad < kWantedRollRad) {
    sentences.emplace_back("Roll the camera to the left and to the right.");
  }
  const auto row = [this](std::size_t y, std::size_t x) { return views_in_part[kParts * y + x]; };
  const auto reached = [](int a, int b, int c) { return a + b + c >= kWantedViewsInPart; };
  std::vector<std::string> edges;
  if (!reached(row(0, 0), row(0, 1), row(0, 2))) edges.emplace_back("top");
  if (!reached(row(2, 0), row(2, 1), row(2, 2))) edges.emplace_back("bottom");
  if (!reached(row(0, 0), row(1, 0), row(2, 0))) edges.emplace_back("left");
  if (!reached(row(0, 2), row(1, 2), row(2, 2))) edges.emplace_back("right");
  if (!edges.empty()) {
    std::string places = edges.front();
    for (std::size_t i = 1; i < edges.size(); ++i) {
      places += (i + 1 == edges.size() ? " and the " : ", the ") + edges[i];
    }
    sentences.push_back("Aim so that the body is at the " + places + " of the picture.");
  }
  if (turn_rad < kWantedTurnRad) sentences.emplace_back("Look at the body from its sides.");
  return sentences;
}

bool ViewPace::wants(const Eigen::Isometry3d& ct_from_depth, TimePoint captured_at) const {
  if (!last_) return true;
  // A recording that begins anew goes back in time.
  if (captured_at >= last_->captured_at && captured_at - last_->captured_at < kApartTime) {
    return false;
  }
  const auto& last = last_->ct_from_depth;
  return (ct_from_depth.translation() - last.translation()).norm() >= kApartMm ||
         rotation_angle_rad(last.inverse() * ct_from_depth) >= kApartRad;
}

void ViewPace::keep(const Eigen::Isometry3d& ct_from_depth, TimePoint captured_at) {
  last_ = {ct_from_depth, captured_at};
}

void ViewGatherer::add(SensedSkin view, ViewPace::TimePoint captured_at) {
  pace_.keep(view.ct_from_depth, captured_at);
  summaries_.push_back(summary_of(view));
  views_.push_back(std::move(view));
}

void ViewGatherer::drop_oldest(std::size_t count) {
  const auto gone = static_cast<std::ptrdiff_t>(std::min(count, views_.size()));
  views_.erase(views_.begin(), views_.begin() + gone);
  summaries_.erase(summaries_.begin(), summaries_.begin() + gone);
}

ViewGatherer::Summary ViewGatherer::summary_of(const SensedSkin& view) const {
  Summary summary;
  const int columns = depth_.width_px / SkinReading::kBlockPx;
  const int rows = depth_.height_px / SkinReading::kBlockPx;
  std::array<int, MotionCoverage::kParts * MotionCoverage::kParts> counts{};
  std::vector<float> distances_mm;
  for (const auto& reading : view.readings) {
    ++counts[MotionCoverage::kParts * part_of(reading.row, rows) +
             part_of(reading.column, columns)];
    distances_mm.push_back(reading.z_mm);
  }
  const double enough = kFilledShare * columns * rows / static_cast<double>(counts.size());
  for (std::size_t i = 0; i < counts.size(); ++i) summary.fills[i] = counts[i] >= enough;
  if (!distances_mm.empty()) {
    const auto middle = distances_mm.begin() + static_cast<std::ptrdiff_t>(distances_mm.size() / 2);
    std::nth_element(distances_mm.begin(), middle, distances_mm.end());
    summary.distance_mm = static_cast<double>(*middle);
  }
  return summary;
}

MotionCoverage ViewGatherer::coverage() const {
  MotionCoverage coverage;
  if (views_.empty()) return coverage;
  coverage.near_mm = std::numeric_limits<double>::max();
  double least_roll = 0.0;
  double most_roll = 0.0;
  const auto& first = views_.front().ct_from_depth;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    const auto& summary = summaries_[i];
    coverage.near_mm = std::min(coverage.near_mm, summary.distance_mm);
    coverage.far_mm = std::max(coverage.far_mm, summary.distance_mm);
    for (std::size_t part = 0; part < summary.fills.size(); ++part) {
      if (summary.fills[part]) ++coverage.views_in_part[part];
    }
    const auto& pose = views_[i].ct_from_depth;
    const double roll = roll_rad(first, pose);
    least_roll = std::min(least_roll, roll);
    most_roll = std::max(most_roll, roll);
    for (std::size_t other = 0; other < i; ++other) {
      const double cosine = views_[other].ct_from_depth.linear().col(2).dot(pose.linear().col(2));
      coverage.turn_rad = std::max(coverage.turn_rad, std::acos(std::clamp(cosine, -1.0, 1.0)));
    }
  }
  coverage.roll_rad = most_roll - least_roll;
  return coverage;
}

}  // namespace mor
