// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/board_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <opencv2/aruco.hpp>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/calibration/internal/charuco.h"
#include "morgagni/core/statistics.h"

namespace mor {
namespace {

/// A dim picture is stretched: an infrared one without its emitter has little light.
constexpr double kDimBrightness = 150.0;
constexpr std::size_t kMinCorners = 6;
/// Corners nearer to one line than this share of their spread say nothing about a pose.
constexpr double kMinSpreadRatio = 0.08;
/// Markers are printed so many times smaller than squares; more off, and it is another board.
constexpr double kMaxMarkerRatioError = 0.2;

cv::Mat as_mat(ImageView<const std::uint8_t> grey) {
  // OpenCV has no view of constant pixels; nothing here writes to it.
  return {grey.height(),
          grey.width(),
          CV_8UC1,
          const_cast<std::uint8_t*>(grey.row(0)),  // NOLINT(cppcoreguidelines-pro-type-const-cast)
          static_cast<std::size_t>(grey.stride())};
}

cv::Mat stretched(const cv::Mat& grey) {
  double least = 0.0;
  double most = 0.0;
  cv::minMaxLoc(grey, &least, &most);
  if (most >= kDimBrightness || most - least < 8.0) return grey;
  cv::Mat result;
  grey.convertTo(result, CV_8UC1, 255.0 / (most - least), -255.0 * least / (most - least));
  return result;
}

float bilinear(const cv::Mat& grey, const Eigen::Vector2d& px) {
  const double x = std::clamp(px.x(), 0.0, grey.cols - 1.001);
  const double y = std::clamp(px.y(), 0.0, grey.rows - 1.001);
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const auto fx = static_cast<float>(x - x0);
  const auto fy = static_cast<float>(y - y0);
  const auto* above = grey.ptr<std::uint8_t>(y0) + x0;
  const auto* below = grey.ptr<std::uint8_t>(y0 + 1) + x0;
  return (1.0F - fy) * ((1.0F - fx) * above[0] + fx * above[1]) +
         fy * ((1.0F - fx) * below[0] + fx * below[1]);
}

/// Width of the edge that runs through `middle` along `along`; none where there is little contrast.
/// @param free_share  Of the edge's length, up to which nothing but the two squares is beside it.
std::optional<double> edge_width(const cv::Mat& grey,
                                 const Eigen::Vector2d& middle,
                                 const Eigen::Vector2d& along,
                                 double free_share) {
  constexpr int kSteps = 41;
  const double length_px = along.norm();
  const double reach_px = std::min(8.0, free_share * length_px);
  if (reach_px < 1.5) return std::nullopt;
  const Eigen::Vector2d across(-along.y() / length_px, along.x() / length_px);
  std::array<float, kSteps> profile{};
  for (int i = 0; i < kSteps; ++i) {
    const double at_px = reach_px * (2.0 * i / (kSteps - 1) - 1.0);
    // A few places along the edge are averaged against the grain.
    for (const double share : {-0.12, -0.04, 0.04, 0.12}) {
      profile[static_cast<std::size_t>(i)] +=
          0.25F * bilinear(grey, middle + share * along + at_px * across);
    }
  }
  const float first = std::accumulate(profile.begin(), profile.begin() + kSteps / 2, 0.0F);
  const float second = std::accumulate(profile.end() - kSteps / 2, profile.end(), 0.0F);
  if (first > second) std::reverse(profile.begin(), profile.end());
  const float contrast = *std::max_element(profile.begin(), profile.end()) - profile.front();
  if (contrast < 20.0F) return std::nullopt;
  // Of the steepest half pixel: white strips beside markers may be too narrow to become white.
  const double step_px = 2.0 * reach_px / (kSteps - 1);
  const int span = std::clamp(static_cast<int>(std::lround(0.5 / step_px)), 1, kSteps / 2);
  float steepest = 0.0F;
  for (int i = 0; i + span < kSteps; ++i) {
    steepest = std::max(
        steepest,
        profile[static_cast<std::size_t>(i + span)] - profile[static_cast<std::size_t>(i)]);
  }
  // An edge blurred by a Gaussian is 2.56 standard deviations wide, and as steep as its contrast
  // over 2.51 of them.
  return 1.02 * static_cast<double>(contrast / steepest) * span * step_px;
}

/// Fills in edge widths and the squares' size. False where the corners lie on a line.
bool measure(const cv::Mat& grey, const CalibrationBoard& board, BoardSighting& sighting) {
  std::map<int, Eigen::Vector2d> by_id;
  Eigen::Vector2d mean_mm = Eigen::Vector2d::Zero();
  for (const auto& corner : sighting.corners) {
    by_id[corner.id] = corner.px;
    mean_mm += board.corner_mm(corner.id).head<2>();
  }
  mean_mm /= static_cast<double>(sighting.corners.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const auto& corner : sighting.corners) {
    const Eigen::Vector2d d = board.corner_mm(corner.id).head<2>() - mean_mm;
    spread += d * d.transpose();
  }
  const double trace = spread.trace();
  if (!(spread.determinant() > kMinSpreadRatio * kMinSpreadRatio * 0.25 * trace * trace)) {
    return false;
  }
  const double free_share =
      board.kind == BoardKind::kCharuco ? 0.45 * (1.0 - board.marker_mm / board.square_mm) : 0.35;
  std::vector<double> widths;
  std::vector<double> sides;
  for (const auto& [id, px] : by_id) {
    const bool has_right = (id + 1) % board.corner_columns() != 0;
    for (const int other : {has_right ? id + 1 : -1, id + board.corner_columns()}) {
      const auto next = by_id.find(other);
      if (next == by_id.end()) continue;
      const Eigen::Vector2d along = next->second - px;
      sides.push_back(along.norm());
      if (const auto width = edge_width(grey, 0.5 * (px + next->second), along, free_share)) {
        widths.push_back(*width);
      }
    }
  }
  sighting.edge_width_px = quantile(std::move(widths), 0.5);
  sighting.square_px = quantile(std::move(sides), 0.5);
  return true;
}

/// Which way up: with odd by even squares the board's colours change places when it is turned by
/// half. Whether `corners` are counted from the board's own upper left.
bool is_upright(const cv::Mat& grey,
                const CalibrationBoard& board,
                const std::vector<cv::Point2f>& corners) {
  std::array<double, 2> sum{};
  std::array<int, 2> count{};
  const int columns = board.corner_columns();
  for (int row = 0; row + 1 < board.corner_rows(); ++row) {
    for (int column = 0; column + 1 < columns; ++column) {
      const auto at = [&](int c, int r) {
        const auto& p = corners[static_cast<std::size_t>(r * columns + c)];
        return Eigen::Vector2d(p.x, p.y);
      };
      const Eigen::Vector2d middle = 0.25 * (at(column, row) + at(column + 1, row) +
                                             at(column, row + 1) + at(column + 1, row + 1));
      const std::size_t is_black = board.is_black(column + 1, row + 1) ? 1 : 0;
      sum[is_black] += static_cast<double>(bilinear(grey, middle));
      ++count[is_black];
    }
  }
  return sum[1] / count[1] <= sum[0] / count[0];
}

BoardSearch find_chessboard(const cv::Mat& grey, const CalibrationBoard& board) {
  std::vector<cv::Point2f> corners;
  const cv::Size size(board.corner_columns(), board.corner_rows());
  const bool is_found = cv::findChessboardCornersSB(
      grey, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_ACCURACY);
  if (!is_found || corners.size() != static_cast<std::size_t>(board.num_corners())) {
    return {{}, "no chessboard of this size is seen whole"};
  }
  if (!is_upright(grey, board, corners)) std::reverse(corners.begin(), corners.end());
  BoardSighting sighting;
  for (int i = 0; i < board.num_corners(); ++i) {
    const auto& px = corners[static_cast<std::size_t>(i)];
    sighting.corners.push_back({i, {px.x, px.y}});
  }
  if (!measure(grey, board, sighting)) return {{}, "the board's corners lie on a line"};
  return {{std::move(sighting)}, {}};
}

/// Side of the markers over that of the squares, as seen; 0 where it cannot be told.
double marker_ratio(const std::vector<std::vector<cv::Point2f>>& markers, double square_px) {
  std::vector<double> sides;
  for (const auto& marker : markers) {
    for (std::size_t i = 0; i < 4; ++i) sides.push_back(cv::norm(marker[i] - marker[(i + 1) % 4]));
  }
  return square_px > 0.0 ? quantile(std::move(sides), 0.5) / square_px : 0.0;
}

/// The shortest way from each corner to the next ones on the board, where those are seen.
std::vector<double> shortest_sides(const CalibrationBoard& board, const BoardSighting& sighting) {
  std::map<int, Eigen::Vector2d> by_id;
  for (const auto& corner : sighting.corners) by_id[corner.id] = corner.px;
  std::vector<double> sides;
  for (const auto& corner : sighting.corners) {
    const int column = corner.id % board.corner_columns();
    double side_px = sighting.square_px;
    for (const int other : {column > 0 ? corner.id - 1 : -1,
                            column + 1 < board.corner_columns() ? corner.id + 1 : -1,
                            corner.id - board.corner_columns(),
                            corner.id + board.corner_columns()}) {
      const auto next = by_id.find(other);
      if (next != by_id.end()) side_px = std::min(side_px, (next->second - corner.px).norm());
    }
    sides.push_back(side_px);
  }
  return sides;
}

/// Places a ChArUco board's corners again, each within a window that no marker reaches into: one in
/// the window pulls the corner aside, by a pixel where the board is tilted.
void refine(const cv::Mat& grey, const CalibrationBoard& board, BoardSighting& sighting) {
  constexpr int kMinReachPx = 2;
  constexpr int kMaxReachPx = 7;
  const double free_share = 0.5 * (1.0 - board.marker_mm / board.square_mm);
  const auto sides = shortest_sides(board, sighting);
  std::vector<SeenCorner> placed;
  for (std::size_t i = 0; i < sighting.corners.size(); ++i) {
    const auto& corner = sighting.corners[i];
    // The markers' own edges are blurred by a pixel.
    const int reach_px =
        std::clamp(static_cast<int>(free_share * sides[i] - 1.0), kMinReachPx, kMaxReachPx);
    std::vector<cv::Point2f> px = {
        {static_cast<float>(corner.px.x()), static_cast<float>(corner.px.y())}};
    cv::cornerSubPix(grey,
                     px,
                     cv::Size(reach_px, reach_px),
                     cv::Size(-1, -1),
                     cv::TermCriteria(cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 40, 0.001));
    const Eigen::Vector2d found(px[0].x, px[0].y);
    const Eigen::AlignedBox2d inside(
        Eigen::Vector2d::Constant(reach_px + 1.0),
        Eigen::Vector2d(grey.cols - reach_px - 2.0, grey.rows - reach_px - 2.0));
    // One that ran away was on nothing; one at the picture's rim has half a window.
    const bool has_stayed = (found - corner.px).norm() < 2.0;
    if (has_stayed && inside.contains(found)) placed.push_back({corner.id, found});
  }
  sighting.corners = std::move(placed);
}

BoardSearch find_charuco(const cv::Mat& grey, const CalibrationBoard& board) {
  const auto pattern = internal::charuco_board(board);
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> ids;
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->adaptiveThreshWinSizeMax = 33;
  cv::aruco::detectMarkers(grey, pattern->dictionary, markers, ids, parameters);
  if (ids.empty()) return {{}, "no board is seen"};
  const int num_markers = static_cast<int>(pattern->ids.size());
  const auto num_foreign = std::ranges::count_if(ids, [&](int id) { return id >= num_markers; });
  if (num_foreign * 4 > static_cast<std::ptrdiff_t>(ids.size())) {
    return {{},
            fmt::format("another board is seen: {} of its {} markers are not on {}",
                        num_foreign,
                        ids.size(),
                        to_string(board))};
  }
  cv::Mat corners;
  cv::Mat corner_ids;
  cv::aruco::interpolateCornersCharuco(markers, ids, grey, pattern, corners, corner_ids);
  if (corners.rows < static_cast<int>(kMinCorners)) {
    return {{}, "too little of the board is seen"};
  }
  BoardSighting sighting;
  for (int i = 0; i < corners.rows; ++i) {
    const auto& px = corners.at<cv::Point2f>(i);
    sighting.corners.push_back({corner_ids.at<int>(i), {px.x, px.y}});
  }
  std::ranges::sort(sighting.corners, {}, &SeenCorner::id);
  if (!measure(grey, board, sighting)) return {{}, "too little of the board is seen"};
  refine(grey, board, sighting);
  if (sighting.corners.size() < kMinCorners) return {{}, "too little of the board is seen"};
  const double ratio = marker_ratio(markers, sighting.square_px) * board.square_mm;
  if (std::abs(ratio / board.marker_mm - 1.0) > kMaxMarkerRatioError) {
    return {{},
            fmt::format("another board is seen: its markers are {:.2f} of a square wide, those of "
                        "{} {:.2f}",
                        ratio / board.square_mm,
                        to_string(board),
                        board.marker_mm / board.square_mm)};
  }
  return {{std::move(sighting)}, {}};
}

}  // namespace

BoardSearch find_board(ImageView<const std::uint8_t> grey, const CalibrationBoard& board) {
  if (grey.empty()) return {{}, "there is no picture"};
  try {
    const cv::Mat picture = stretched(as_mat(grey));
    return board.kind == BoardKind::kChessboard ? find_chessboard(picture, board)
                                                : find_charuco(picture, board);
  } catch (const cv::Exception& error) {
    return {{}, fmt::format("the picture cannot be searched: {}", error.err)};
  }
}

BoardSearch find_board(ImageView<const Rgb8> color, const CalibrationBoard& board) {
  Image<std::uint8_t> grey(color.width(), color.height());
  for (int y = 0; y < color.height(); ++y) {
    const Rgb8* from = color.row(y);
    for (int x = 0; x < color.width(); ++x) {
      grey(x, y) =
          static_cast<std::uint8_t>((77 * from[x].r + 150 * from[x].g + 29 * from[x].b) >> 8U);
    }
  }
  return find_board(grey.view(), board);
}

}  // namespace mor
