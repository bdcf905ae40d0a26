// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/calibration/skin_readings.h"
#include "morgagni/geometry/pinhole_camera.h"

namespace mor {

/// How the camera has moved over the views that were kept: what self-calibration lives on.
struct MotionCoverage {
  static constexpr int kParts = 3;  ///< Of the picture, each way.

  double near_mm = 0.0;  ///< Distance of the body in the nearest view, median of its readings.
  double far_mm = 0.0;
  double roll_rad = 0.0;  ///< Between the views rolled most to either side.
  double turn_rad = 0.0;  ///< Between the viewing directions that lie farthest apart.
  /// Views in which the body fills a good share of each part of the picture, row by row.
  std::array<int, kParts * kParts> views_in_part{};

  /// What to do next, in sentences, the most useful first. Empty: enough.
  [[nodiscard]] std::vector<std::string> missing() const;
};

/// Decides which of the tracked frames become views: those on which the camera has moved on.
class ViewPace {
 public:
  static constexpr double kApartMm = 20.0;
  static constexpr double kApartRad = 0.0523599;  // 3 degrees
  /// So that the views reach over the whole motion.
  static constexpr std::chrono::milliseconds kApartTime{700};

  using TimePoint = std::chrono::steady_clock::time_point;

  /// Whether a frame of this pose and time would be kept. @cost Below a microsecond.
  [[nodiscard]] bool wants(const Eigen::Isometry3d& ct_from_depth, TimePoint captured_at) const;
  void keep(const Eigen::Isometry3d& ct_from_depth, TimePoint captured_at);

 private:
  struct Kept {
    Eigen::Isometry3d ct_from_depth;
    TimePoint captured_at;
  };
  std::optional<Kept> last_;
};

/// Views in the order of time, and what they cover of the motion. @threads One call at a time.
class ViewGatherer {
 public:
  explicit ViewGatherer(const PinholeCamera& depth) : depth_(depth) {}

  void add(SensedSkin view, ViewPace::TimePoint captured_at);
  /// Makes room: the oldest views go.
  void drop_oldest(std::size_t count);

  [[nodiscard]] const std::vector<SensedSkin>& views() const { return views_; }
  [[nodiscard]] const ViewPace& pace() const { return pace_; }
  [[nodiscard]] MotionCoverage coverage() const;

 private:
  /// What coverage() needs of a view, so that it need not look through all readings again.
  struct Summary {
    double distance_mm = 0.0;
    std::array<bool, MotionCoverage::kParts * MotionCoverage::kParts> fills{};
  };
  [[nodiscard]] Summary summary_of(const SensedSkin& view) const;

  PinholeCamera depth_;
  std::vector<SensedSkin> views_;
  std::vector<Summary> summaries_;
  ViewPace pace_;
};

}  // namespace mor
