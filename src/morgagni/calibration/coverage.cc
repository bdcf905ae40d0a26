// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/coverage.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <spdlog/fmt/fmt.h>

#include "morgagni/calibration/lens_calibration.h"

namespace mor {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr double kTiltedDeg = 14.0;
constexpr int kWantedTilts = 2;  ///< Each way.
constexpr double kSameDistance = 0.08;
constexpr int kWantedDistances = 4;
constexpr double kWantedRange = 1.4;  ///< Farthest over nearest.
constexpr int kCornersInPart = 4;
constexpr double kNearWallMm = 650.0;  ///< A view on the wall from at most so far,
constexpr double kFarWallMm = 1050.0;  ///< and one from at least so far.

constexpr std::array<const char*, 9> kParts = {"upper left corner",
                                               "upper edge",
                                               "upper right corner",
                                               "left edge",
                                               "middle",
                                               "right edge",
                                               "lower left corner",
                                               "lower edge",
                                               "lower right corner"};

void count_parts(const BoardSighting& sighting, const PinholeCamera& camera, Coverage& coverage) {
  std::array<int, 9> corners{};
  for (const auto& corner : sighting.corners) {
    const int x = std::clamp(static_cast<int>(3.0 * corner.px.x() / camera.width_px), 0, 2);
    const int y = std::clamp(static_cast<int>(3.0 * corner.px.y() / camera.height_px), 0, 2);
    ++corners[static_cast<std::size_t>(3 * y + x)];
  }
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (corners[i] >= kCornersInPart) ++coverage.views_in_part[i];
  }
}

void ask_for_tilts(const std::vector<BoardPlace>& places, std::vector<std::string>& missing) {
  const auto lacks = [&](auto is_so) {
    return std::ranges::count_if(places, is_so) < kWantedTilts;
  };
  if (lacks([](const BoardPlace& p) { return p.right_nearer_deg > kTiltedDeg; })) {
    missing.emplace_back("tilt the board so that its right edge is nearer to the camera");
  }
  if (lacks([](const BoardPlace& p) { return p.right_nearer_deg < -kTiltedDeg; })) {
    missing.emplace_back("tilt the board so that its left edge is nearer to the camera");
  }
  if (lacks([](const BoardPlace& p) { return p.low_nearer_deg > kTiltedDeg; })) {
    missing.emplace_back("tilt the board so that its lower edge is nearer to the camera");
  }
  if (lacks([](const BoardPlace& p) { return p.low_nearer_deg < -kTiltedDeg; })) {
    missing.emplace_back("tilt the board so that its upper edge is nearer to the camera");
  }
}

void ask_for_distances(const std::vector<BoardPlace>& places, Coverage& coverage) {
  std::vector<double> distances;
  for (const auto& place : places) distances.push_back(place.distance_mm);
  std::ranges::sort(distances);
  double last_mm = 0.0;
  for (const double distance_mm : distances) {
    if (distance_mm < last_mm * (1.0 + kSameDistance)) continue;
    last_mm = distance_mm;
    ++coverage.num_distances;
  }
  if (distances.empty()) return;
  const double near_mm = distances.front();
  if (coverage.num_distances < kWantedDistances || distances.back() < kWantedRange * near_mm) {
    coverage.missing.push_back(
        fmt::format("change the distance: so far the board was {:.0f} to {:.0f} cm away",
                    near_mm / 10.0,
                    distances.back() / 10.0));
  }
}

/// Asked for when the board has been in the hand often enough.
void ask_for_wall(const std::vector<double>& distances_mm, int wanted, Coverage& coverage) {
  const auto [near, far] = std::ranges::minmax_element(distances_mm);
  const int lacking = wanted - coverage.num_on_wall;
  if (distances_mm.empty()) {
    coverage.missing.push_back(fmt::format(
        "now hang the board on a flat wall, or lay it on a wide table, for {} views from 50 to 120 "
        "cm, a little tilted",
        lacking));
  } else if (*near > kNearWallMm) {
    coverage.missing.push_back(
        fmt::format("nearer to the wall: 50 to 65 cm; so far it was {:.0f} cm", *near / 10.0));
  } else if (*far < kFarWallMm) {
    coverage.missing.push_back(
        fmt::format("farther from the wall: 105 to 125 cm; so far it was {:.0f} cm", *far / 10.0));
  } else if (lacking > 0) {
    coverage.missing.push_back(
        fmt::format("{} more of the board on the wall, each from another distance", lacking));
  }
}

}  // namespace

std::optional<BoardPlace> place_of(const CalibrationBoard& board,
                                   const BoardSighting& sighting,
                                   const PinholeCamera& camera) {
  const auto pose = camera_from_board(board, sighting, camera);
  if (!pose) return std::nullopt;
  BoardPlace place;
  place.distance_mm = (*pose * (0.5 * board.corner_mm(board.num_corners() - 1))).z();
  const Eigen::Vector3d into_board = pose->linear().col(2);
  place.right_nearer_deg = kDegPerRad * std::atan2(into_board.x(), into_board.z());
  place.low_nearer_deg = kDegPerRad * std::atan2(into_board.y(), into_board.z());
  return place;
}

Coverage coverage_of(const CalibrationBoard& board,
                     const std::vector<BoardSighting>& views,
                     const std::vector<bool>& on_wall,
                     const PinholeCamera& camera,
                     const WantedViews& wanted) {
  Coverage coverage;
  coverage.num_views = static_cast<int>(views.size());
  std::vector<BoardPlace> places;
  std::vector<double> wall_distances_mm;
  for (std::size_t i = 0; i < views.size(); ++i) {
    count_parts(views[i], camera, coverage);
    const auto place = place_of(board, views[i], camera);
    if (place) places.push_back(*place);
    if (!on_wall[i]) continue;
    ++coverage.num_on_wall;
    if (place) wall_distances_mm.push_back(place->distance_mm);
  }
  for (std::size_t i = 0; i < kParts.size(); ++i) {
    if (coverage.views_in_part[i] == 0) {
      coverage.missing.push_back(fmt::format("hold the board at the {} of the picture", kParts[i]));
    }
  }
  ask_for_tilts(places, coverage.missing);
  ask_for_distances(places, coverage);
  const int in_hand = coverage.num_views - coverage.num_on_wall;
  if (coverage.missing.empty() && in_hand < wanted.in_hand) {
    coverage.missing.push_back(
        fmt::format("take {} more, each in another pose", wanted.in_hand - in_hand));
  }
  if (coverage.missing.empty() && wanted.on_wall > 0) {
    ask_for_wall(wall_distances_mm, wanted.on_wall, coverage);
  }
  return coverage;
}

}  // namespace mor
