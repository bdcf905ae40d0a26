// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/plane_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <spdlog/fmt/fmt.h>

namespace mor {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr std::size_t kMinPlanes = 6;
constexpr double kMinTiltDeg = 12.0;
constexpr int kMaxSteps = 30;
/// Readings of a board share the sensor's systematic error, which is of this share of the distance:
/// together they weigh as so many with it.
constexpr double kSystematicShare = 0.005;
constexpr double kEffectiveReadings = 4.0;

/// Changes from the design, each in a unit in which the design is good to 1.
enum Unknown : int {
  kTurnX,
  kTurnY,
  kTurnZ,
  kShiftX,
  kShiftY,
  kShiftZ,
  kFocal,
  kCenterX,
  kCenterY,
  kScale,
  kOffset,
  kNumUnknowns
};

struct Meaning {
  const char* name;
  double unit;      ///< Of the change: standard deviation of the design's error.
  double shown_as;  ///< Unit to the name's.
};

constexpr std::array<Meaning, kNumUnknowns> kMeanings = {
    {{"rotation x, degrees", 1.5 / kDegPerRad, kDegPerRad},
     {"rotation y, degrees", 1.5 / kDegPerRad, kDegPerRad},
     {"rotation z, degrees", 1.5 / kDegPerRad, kDegPerRad},
     {"shift x, mm", 5.0, 1.0},
     {"shift y, mm", 5.0, 1.0},
     {"shift z, mm", 5.0, 1.0},
     {"focal length, %", 0.02, 100.0},
     {"centre x, px", 8.0, 1.0},
     {"centre y, px", 8.0, 1.0},
     {"depth scale, %", 0.01, 100.0},
     {"depth offset, mm", 5.0, 1.0}}};

using Unknowns = Eigen::Matrix<double, kNumUnknowns, 1>;

struct Geometry {
  PinholeCamera depth;
  Eigen::Isometry3d color_from_depth;
  double scale = 1.0;
  double offset_mm = 0.0;
};

Geometry geometry_of(const Unknowns& unknowns, const RgbdCalibration& design) {
  const auto change = [&](Unknown i) {
    return unknowns[i] * kMeanings[static_cast<std::size_t>(i)].unit;
  };
  Geometry geometry{design.depth, design.color_from_depth};
  geometry.depth.focal_x_px *= 1.0 + change(kFocal);
  geometry.depth.focal_y_px *= 1.0 + change(kFocal);
  geometry.depth.center_x_px += change(kCenterX);
  geometry.depth.center_y_px += change(kCenterY);
  const Eigen::Vector3d turn(change(kTurnX), change(kTurnY), change(kTurnZ));
  if (turn.norm() > 0.0) {
    geometry.color_from_depth.linear() =
        Eigen::AngleAxisd(turn.norm(), turn.normalized()) * design.color_from_depth.linear();
  }
  geometry.color_from_depth.translation() +=
      Eigen::Vector3d(change(kShiftX), change(kShiftY), change(kShiftZ));
  geometry.scale += change(kScale);
  geometry.offset_mm = change(kOffset);
  return geometry;
}

/// Distances of all readings from their planes, mm, view by view.
std::vector<double> distances_mm(const std::vector<PlaneView>& views, const Geometry& geometry) {
  std::vector<double> distances;
  for (const auto& view : views) {
    const Eigen::Vector3d normal = view.color_from_board.linear().col(2);
    const double plane_mm = normal.dot(view.color_from_board.translation());
    for (const auto& reading : view.readings) {
      const double z_mm = geometry.scale * reading.seen_mm + geometry.offset_mm;
      const Eigen::Vector3d point = z_mm * geometry.depth.ray(reading.px).homogeneous();
      distances.push_back(normal.dot(geometry.color_from_depth * point) - plane_mm);
    }
  }
  return distances;
}

/// Weight of each reading; a far-off one counts little (Huber).
std::vector<double> weights_of(const std::vector<PlaneView>& views,
                               const std::vector<double>& distances) {
  constexpr double kHuber = 2.5;
  std::vector<double> weights;
  std::size_t i = 0;
  for (const auto& view : views) {
    const double of_view = static_cast<double>(view.readings.size());
    for (const auto& reading : view.readings) {
      const double sd_mm = kSystematicShare * reading.seen_mm;
      const double size = std::abs(distances[i++]) / sd_mm;
      const double huber = size > kHuber ? kHuber / size : 1.0;
      weights.push_back(huber * std::min(1.0, kEffectiveReadings / of_view) / (sd_mm * sd_mm));
    }
  }
  return weights;
}

struct NormalEquations {
  Eigen::Matrix<double, kNumUnknowns, kNumUnknowns> matrix;
  Unknowns right;
};

NormalEquations linearise(const std::vector<PlaneView>& views,
                          const RgbdCalibration& design,
                          const Unknowns& at) {
  constexpr double kStep = 1e-4;
  const auto base = distances_mm(views, geometry_of(at, design));
  const auto weights = weights_of(views, base);
  Eigen::Matrix<double, Eigen::Dynamic, kNumUnknowns> slopes(base.size(), kNumUnknowns);
  for (int k = 0; k < kNumUnknowns; ++k) {
    Unknowns beside = at;
    beside[k] += kStep;
    const auto moved = distances_mm(views, geometry_of(beside, design));
    for (std::size_t i = 0; i < base.size(); ++i) {
      slopes(static_cast<Eigen::Index>(i), k) = (moved[i] - base[i]) / kStep;
    }
  }
  // The design is believed as far as each unknown's unit says.
  NormalEquations equations{Eigen::Matrix<double, kNumUnknowns, kNumUnknowns>::Identity(), -at};
  for (std::size_t i = 0; i < base.size(); ++i) {
    const auto row = slopes.row(static_cast<Eigen::Index>(i));
    equations.matrix += weights[i] * row.transpose() * row;
    equations.right -= weights[i] * base[i] * row.transpose();
  }
  return equations;
}

Result<void> check_views(const std::vector<PlaneView>& views) {
  if (views.size() < kMinPlanes) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("the depth camera saw the board in only {} views, at least {} are "
                    "needed",
                    views.size(),
                    kMinPlanes));
  }
  double least_cosine = 1.0;
  for (const auto& a : views) {
    for (const auto& b : views) {
      least_cosine = std::min(
          least_cosine, a.color_from_board.linear().col(2).dot(b.color_from_board.linear().col(2)));
    }
  }
  const double tilt_deg = kDegPerRad * std::acos(std::clamp(least_cosine, -1.0, 1.0));
  if (tilt_deg >= kMinTiltDeg) return {};
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("the planes are parallel within {:.0f} degrees: tilt the board to "
                                "the left, to the right, forward and back",
                                tilt_deg));
}

}  // namespace

Result<PlaneGeometry> find_plane_geometry(const std::vector<PlaneView>& views,
                                          const RgbdCalibration& by_design) {
  MOR_CHECK(check_views(views));
  Unknowns unknowns = Unknowns::Zero();
  for (int step = 0; step < kMaxSteps; ++step) {
    const auto equations = linearise(views, by_design, unknowns);
    const Unknowns change = equations.matrix.ldlt().solve(equations.right);
    unknowns += change;
    if (change.cwiseAbs().maxCoeff() < 1e-5) break;
  }
  const auto equations = linearise(views, by_design, unknowns);
  const Eigen::Matrix<double, kNumUnknowns, kNumUnknowns> covariance = equations.matrix.inverse();
  const Geometry geometry = geometry_of(unknowns, by_design);
  PlaneGeometry result{.depth = geometry.depth, .color_from_depth = geometry.color_from_depth};
  for (int i = 0; i < kNumUnknowns; ++i) {
    const auto& meaning = kMeanings[static_cast<std::size_t>(i)];
    const double shown = meaning.unit * meaning.shown_as;
    result.unknowns.push_back(
        {meaning.name, unknowns[i] * shown, std::sqrt(covariance(i, i)) * shown, shown});
  }
  double sum = 0.0;
  const auto distances = distances_mm(views, geometry);
  for (const double d : distances) sum += d * d;
  result.rms_mm = std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, distances.size())));
  return result;
}

}  // namespace mor
