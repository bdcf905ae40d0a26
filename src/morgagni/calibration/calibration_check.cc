// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/calibration_check.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/statistics.h"

namespace mor {
namespace {

constexpr std::size_t kMinReadings = 6;
constexpr double kGoodPx = 0.6;
constexpr double kUsablePx = 1.5;
constexpr double kGoodMm = 2.0;
constexpr double kUsableMm = 4.0;

/// The plane through corrected readings, frame depth.
struct FittedPlane {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double rms_mm = 0.0;
};

std::vector<Eigen::Vector3d> points_of(const std::vector<DepthReading>& readings,
                                       const RgbdCalibration& calibration) {
  std::vector<Eigen::Vector3d> points;
  for (const auto& reading : readings) {
    points.push_back(reading.seen_mm * calibration.depth.ray(reading.px).homogeneous());
  }
  return points;
}

FittedPlane plane_through(const std::vector<Eigen::Vector3d>& points) {
  FittedPlane plane;
  for (const auto& p : points) plane.center += p;
  plane.center /= static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const auto& p : points) spread += (p - plane.center) * (p - plane.center).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  plane.normal = solver.eigenvectors().col(0);
  plane.rms_mm =
      std::sqrt(std::max(0.0, solver.eigenvalues()[0]) / static_cast<double>(points.size()));
  return plane;
}

/// Adds what readings are wrong by.
Image<float> corrected(const Image<float>& depth_mm, const RgbdCalibration& calibration) {
  Image<float> result = depth_mm;
  if (!calibration.depth_correction) return result;
  for (int y = 0; y < result.height(); ++y) {
    for (int x = 0; x < result.width(); ++x) {
      float& z_mm = result(x, y);
      if (z_mm <= 0.0F) continue;
      z_mm += static_cast<float>(calibration.depth_correction->add_mm(
          Eigen::Vector2d(x, y), result.width(), result.height(), static_cast<double>(z_mm)));
    }
  }
  return result;
}

/// The longest distances along the board's rows and columns between corners seen: measured in space
/// where the colour camera's rays meet the depth's plane.
void measure_sides(const CalibrationBoard& board,
                   const BoardSighting& sighting,
                   const FittedPlane& plane,
                   const RgbdCalibration& calibration,
                   std::vector<std::pair<double, double>>& measured_and_true) {
  const Eigen::Vector3d normal = calibration.color_from_depth.linear() * plane.normal;
  const double distance_mm = normal.dot(calibration.color_from_depth * plane.center);
  std::vector<std::pair<int, Eigen::Vector3d>> places;
  for (const auto& corner : sighting.corners) {
    const Eigen::Vector3d ray = calibration.color.ray(corner.px).homogeneous();
    places.emplace_back(corner.id, distance_mm / normal.dot(ray) * ray);
  }
  const auto longest = [&](auto line_of) {
    for (std::size_t i = 0; i < places.size(); ++i) {
      std::optional<std::size_t> far;
      for (std::size_t k = i + 1; k < places.size(); ++k) {
        if (line_of(places[k].first) == line_of(places[i].first)) far = k;
      }
      const bool is_first = std::ranges::none_of(
          places.begin(), places.begin() + static_cast<std::ptrdiff_t>(i), [&](const auto& p) {
            return line_of(p.first) == line_of(places[i].first);
          });
      if (!far || !is_first) continue;
      const double true_mm =
          (board.corner_mm(places[*far].first) - board.corner_mm(places[i].first)).norm();
      measured_and_true.emplace_back((places[*far].second - places[i].second).norm(), true_mm);
    }
  };
  longest([&](int id) { return id / board.corner_columns(); });
  longest([&](int id) { return id % board.corner_columns(); });
}

}  // namespace

std::string CalibrationCheck::verdict() const {
  const double depth_mm = num_depth_views > 0 ? std::max(size_error_mm, depth_error_rms_mm) : 0.0;
  if (reprojection_px <= kGoodPx && depth_mm <= kGoodMm) return "good";
  if (reprojection_px <= kUsablePx && depth_mm <= kUsableMm) {
    return "usable, but a new calibration would be better";
  }
  return reprojection_px > kUsablePx ? "calibrate again: the colour camera's lens does not fit"
                                     : "calibrate again: the depth is off";
}

std::vector<std::pair<std::string, std::string>> CalibrationCheck::figures() const {
  std::vector<std::pair<std::string, std::string>> result = {
      {"state", verdict()},
      {"colour camera",
       fmt::format("{:.2f} px, {:.2f} mm at 1 m, {} views",
                   reprojection_px,
                   reprojection_mm_at_1m,
                   num_views)}};
  if (num_depth_views == 0) {
    result.emplace_back("depth", "the board has no depth in any view: not checked");
    return result;
  }
  result.emplace_back("the board's sides in space",
                      fmt::format("{:.2f} mm off, {:+.2f} % in the mean, at {:.0f} mm",
                                  size_error_mm,
                                  size_error_percent,
                                  distance_mm));
  result.emplace_back("depth against colour",
                      fmt::format("{:+.1f} mm in the mean, {:.1f} mm root mean square",
                                  depth_error_mm,
                                  depth_error_rms_mm));
  result.emplace_back("flatness of the board", fmt::format("{:.1f} mm", flatness_mm));
  return result;
}

Result<CalibrationCheck> check_calibration(const CalibrationBoard& board,
                                           const std::vector<RigView>& views,
                                           const RgbdCalibration& calibration) {
  CalibrationCheck check;
  const DepthReader reader(calibration.depth);
  std::vector<std::pair<double, double>> sides;
  std::vector<double> distances;
  double px_sq = 0.0;
  double depth_sum = 0.0;
  double depth_sq = 0.0;
  double flat_sq = 0.0;
  std::size_t num_readings = 0;
  for (const auto& view : views) {
    if (!view.color) continue;
    const auto color_from_board = camera_from_board(board, *view.color, calibration.color);
    if (!color_from_board) continue;
    const double rms_px =
        reprojection_rms_px(board, *view.color, calibration.color, *color_from_board);
    px_sq += rms_px * rms_px;
    ++check.num_views;
    if (view.depth_mm.empty()) continue;
    const Eigen::Isometry3d depth_from_board =
        calibration.color_from_depth.inverse() * *color_from_board;
    const auto readings = reader.read(corrected(view.depth_mm, calibration),
                                      board,
                                      depth_from_board,
                                      BoardArea::kInside,
                                      check.num_depth_views);
    if (readings.size() < kMinReadings) continue;
    ++check.num_depth_views;
    for (const auto& reading : readings) {
      const double wrong_mm = reading.seen_mm - reading.true_mm;
      depth_sum += wrong_mm;
      depth_sq += wrong_mm * wrong_mm;
      distances.push_back(reading.true_mm);
    }
    num_readings += readings.size();
    const auto plane = plane_through(points_of(readings, calibration));
    flat_sq += plane.rms_mm * plane.rms_mm * static_cast<double>(readings.size());
    measure_sides(board, *view.color, plane, calibration, sides);
  }
  if (check.num_views == 0) {
    return make_error(ErrorCode::kInvalidArgument, "no view shows the board: is it the right one?");
  }
  check.reprojection_px = std::sqrt(px_sq / check.num_views);
  check.reprojection_mm_at_1m = 1000.0 * check.reprojection_px / calibration.color.focal_x_px;
  if (check.num_depth_views == 0 || sides.empty()) return check;
  const auto count = static_cast<double>(num_readings);
  check.distance_mm = quantile(std::move(distances), 0.5);
  check.depth_error_mm = depth_sum / count;
  check.depth_error_rms_mm = std::sqrt(depth_sq / count);
  check.flatness_mm = std::sqrt(flat_sq / count);
  double side_sq = 0.0;
  for (const auto& [measured_mm, true_mm] : sides) {
    side_sq += (measured_mm - true_mm) * (measured_mm - true_mm);
    check.size_error_percent +=
        100.0 * (measured_mm / true_mm - 1.0) / static_cast<double>(sides.size());
  }
  check.size_error_mm = std::sqrt(side_sq / static_cast<double>(sides.size()));
  return check;
}

}  // namespace mor
