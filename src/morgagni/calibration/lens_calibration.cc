// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/lens_calibration.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <opencv2/calib3d.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/calibration/internal/opencv_types.h"
#include "morgagni/core/statistics.h"

namespace mor {
namespace {

using internal::Correspondences;

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr std::size_t kMinCorners = 8;
constexpr int kNumFolds = 4;
/// A view this many times worse than the middle one, and worse than so much, shows another board,
/// or a bent one, or moved.
constexpr double kOddRatio = 4.0;
constexpr double kOddPx = 0.8;
/// More odd views than this share, and it is the set that is wrong.
constexpr double kMaxOddShare = 0.25;
/// The views' corners must reach over this share of the picture's width and height.
constexpr double kMinCoverage = 0.5;
/// Poses nearer to each other than this, in mm and degrees, are one.
constexpr double kSamePoseMm = 15.0;
constexpr double kSamePoseDeg = 2.5;
/// Distortion k3 of a lens like these is nothing that such boards determine.
constexpr int kFlags = cv::CALIB_FIX_K3;

tl::unexpected<Error> refuse(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, std::move(message));
}

/// What OpenCV found from a set of views.
struct Solved {
  PinholeCamera camera;
  PinholeCamera sd;
  double rms_px = 0.0;
  std::vector<Eigen::Isometry3d> camera_from_board;
  std::vector<double> view_rms_px;
};

Solved solve(const std::vector<Correspondences>& views, int width_px, int height_px) {
  std::vector<std::vector<cv::Point3f>> board_mm;
  std::vector<std::vector<cv::Point2f>> px;
  for (const auto& view : views) {
    board_mm.push_back(view.board_mm);
    px.push_back(view.px);
  }
  cv::Mat matrix;
  cv::Mat distortion;
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> shifts;
  cv::Mat sd;
  cv::Mat sd_poses;
  cv::Mat errors;
  Solved solved;
  solved.rms_px = cv::calibrateCamera(board_mm,
                                      px,
                                      cv::Size(width_px, height_px),
                                      matrix,
                                      distortion,
                                      rotations,
                                      shifts,
                                      sd,
                                      sd_poses,
                                      errors,
                                      kFlags);
  solved.camera = internal::pinhole_of(matrix, distortion, width_px, height_px);
  solved.sd = {width_px,
               height_px,
               sd.at<double>(0),
               sd.at<double>(1),
               sd.at<double>(2),
               sd.at<double>(3),
               {sd.at<double>(4), sd.at<double>(5), sd.at<double>(6), sd.at<double>(7), 0.0}};
  for (std::size_t i = 0; i < views.size(); ++i) {
    solved.camera_from_board.push_back(internal::rigid_of(rotations[i], shifts[i]));
    solved.view_rms_px.push_back(errors.at<double>(static_cast<int>(i)));
  }
  return solved;
}

/// Share of the picture's width and height that corners reach over.
Eigen::Vector2d coverage(const std::vector<Correspondences>& views, int width_px, int height_px) {
  Eigen::AlignedBox2d box;
  for (const auto& view : views) {
    for (const auto& p : view.px) box.extend(Eigen::Vector2d(p.x, p.y));
  }
  return box.sizes().cwiseQuotient(Eigen::Vector2d(width_px, height_px));
}

double angle_deg(const Eigen::Matrix3d& rotation) {
  return kDegPerRad * Eigen::AngleAxisd(rotation).angle();
}

/// How many poses there are, those close to each other counted once.
int num_distinct(const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<Eigen::Isometry3d> kept;
  for (const auto& pose : poses) {
    const bool is_known = std::ranges::any_of(kept, [&](const Eigen::Isometry3d& other) {
      return (pose.translation() - other.translation()).norm() < kSamePoseMm &&
             angle_deg(pose.linear().transpose() * other.linear()) < kSamePoseDeg;
    });
    if (!is_known) kept.push_back(pose);
  }
  return static_cast<int>(kept.size());
}

/// The widest angle between two boards' normals.
double widest_tilt_deg(const std::vector<Eigen::Isometry3d>& poses) {
  double least_cosine = 1.0;
  for (const auto& a : poses) {
    for (const auto& b : poses) {
      least_cosine = std::min(least_cosine, a.linear().col(2).dot(b.linear().col(2)));
    }
  }
  return kDegPerRad * std::acos(std::clamp(least_cosine, -1.0, 1.0));
}

Result<void> check_poses(const Solved& solved, const LensOptions& options) {
  const int num_poses = num_distinct(solved.camera_from_board);
  const auto num_views = solved.camera_from_board.size();
  if (num_poses < std::max(3, options.min_views / 2)) {
    return refuse(fmt::format(
        "the {} views show the board in only {} different poses: move and tilt it between views",
        num_views,
        num_poses));
  }
  const double tilt_deg = widest_tilt_deg(solved.camera_from_board);
  if (tilt_deg < options.min_tilt_deg) {
    return refuse(fmt::format(
        "the board is held nearly parallel in all {} views (within {:.0f} degrees, at least {:.0f} "
        "are needed): tilt it to the left, to the right, forward and back, by 20 degrees or more",
        num_views,
        tilt_deg,
        options.min_tilt_deg));
  }
  return {};
}

Result<void> check_fit(const Solved& solved, const LensOptions& options) {
  if (solved.rms_px > options.max_rms_px) {
    return refuse(fmt::format(
        "the views do not fit one flat board and one lens: {:.2f} px off in the mean, at most "
        "{:.2f} are allowed; is the board flat, are its squares counted right, is it the same in "
        "all views?",
        solved.rms_px,
        options.max_rms_px));
  }
  const double sd_share = std::max(solved.sd.focal_x_px / solved.camera.focal_x_px,
                                   solved.sd.focal_y_px / solved.camera.focal_y_px);
  if (!(sd_share <= options.max_focal_sd_share)) {
    return refuse(fmt::format(
        "the views leave the focal length uncertain by {:.1f} %, at most {:.1f} % are allowed: add "
        "views in which the board is near and tilted",
        100.0 * sd_share,
        100.0 * options.max_focal_sd_share));
  }
  return {};
}

/// Squared error sum and count at every other corner, of a pose from those between.
std::pair<double, std::size_t> held_out_error(const Correspondences& view,
                                              const PinholeCamera& camera) {
  Correspondences known;
  Correspondences asked;
  for (std::size_t i = 0; i < view.px.size(); ++i) {
    auto& part = i % 2 == 0 ? known : asked;
    part.board_mm.push_back(view.board_mm[i]);
    part.px.push_back(view.px[i]);
  }
  cv::Mat rotation;
  cv::Mat shift;
  const auto matrix = internal::matrix_of(camera);
  const auto distortion = internal::distortion_of(camera);
  if (!cv::solvePnP(known.board_mm, known.px, matrix, distortion, rotation, shift)) return {0.0, 0};
  std::vector<cv::Point2f> projected;
  cv::projectPoints(asked.board_mm, rotation, shift, matrix, distortion, projected);
  double sum = 0.0;
  for (std::size_t i = 0; i < projected.size(); ++i) {
    const auto d = projected[i] - asked.px[i];
    sum += static_cast<double>(d.dot(d));
  }
  return {sum, projected.size()};
}

double held_out_rms(const std::vector<Correspondences>& views, int width_px, int height_px) {
  double sum = 0.0;
  std::size_t count = 0;
  for (int fold = 0; fold < kNumFolds; ++fold) {
    std::vector<Correspondences> rest;
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (static_cast<int>(i) % kNumFolds != fold) rest.push_back(views[i]);
    }
    const auto camera = solve(rest, width_px, height_px).camera;
    for (auto i = static_cast<std::size_t>(fold); i < views.size(); i += kNumFolds) {
      const auto [view_sum, view_count] = held_out_error(views[i], camera);
      sum += view_sum;
      count += view_count;
    }
  }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

/// Views fit for use, and why the others are not.
struct Selection {
  std::vector<std::size_t> used;
  std::vector<Correspondences> views;
  int num_blurred = 0;
};

Selection select(const CalibrationBoard& board,
                 const std::vector<LensView>& views,
                 const LensOptions& options,
                 std::vector<LensViewQuality>& quality) {
  Selection selection;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto& sighting = views[i].sighting;
    quality.push_back({.name = views[i].name, .rms_px = 0.0, .is_used = false, .reason = {}});
    if (sighting.edge_width_px > options.max_edge_width_px) {
      ++selection.num_blurred;
      quality.back().reason = fmt::format("blurred: edges {:.1f} px wide, at most {:.1f}",
                                          sighting.edge_width_px,
                                          options.max_edge_width_px);
    } else if (sighting.corners.size() < kMinCorners) {
      quality.back().reason = fmt::format("only {} corners of the board are seen, at least {}",
                                          sighting.corners.size(),
                                          kMinCorners);
    } else {
      selection.used.push_back(i);
      selection.views.push_back(internal::correspondences_of(board, sighting));
    }
  }
  return selection;
}

Result<void> check_count(const Selection& selection, const LensOptions& options) {
  if (static_cast<int>(selection.used.size()) >= options.min_views) return {};
  return refuse(fmt::format("only {} views show the board well{}, at least {} are needed",
                            selection.used.size(),
                            selection.num_blurred == 0
                                ? ""
                                : fmt::format(" ({} are blurred: hold still, and give more light)",
                                              selection.num_blurred),
                            options.min_views));
}

/// Takes out views that fit much worse than the others. @return How many.
int leave_out_odd(const Solved& solved,
                  Selection& selection,
                  std::vector<LensViewQuality>& quality) {
  const double limit_px = std::max(kOddPx, kOddRatio * quantile(solved.view_rms_px, 0.5));
  Selection kept;
  kept.num_blurred = selection.num_blurred;
  int num_odd = 0;
  for (std::size_t k = 0; k < selection.used.size(); ++k) {
    const auto i = selection.used[k];
    quality[i].rms_px = solved.view_rms_px[k];
    if (solved.view_rms_px[k] > limit_px) {
      ++num_odd;
      quality[i].reason = fmt::format(
          "does not fit the others ({:.1f} px off): another board, or it moved or was bent",
          solved.view_rms_px[k]);
    } else {
      kept.used.push_back(i);
      kept.views.push_back(std::move(selection.views[k]));
    }
  }
  selection = std::move(kept);
  return num_odd;
}

Result<LensCalibration> calibrate(const CalibrationBoard& board,
                                  const std::vector<LensView>& views,
                                  int width_px,
                                  int height_px,
                                  const LensOptions& options) {
  LensCalibration result;
  Selection selection = select(board, views, options, result.views);
  MOR_CHECK(check_count(selection, options));
  const auto num_good = selection.used.size();
  Solved solved = solve(selection.views, width_px, height_px);
  MOR_CHECK(check_poses(solved, options));
  const int num_odd = leave_out_odd(solved, selection, result.views);
  if (num_odd > kMaxOddShare * static_cast<double>(num_good)) {
    return refuse(
        fmt::format("{} of {} views do not fit the others: are there two boards in this "
                    "set, or is the board bent?",
                    num_odd,
                    num_good));
  }
  MOR_CHECK(check_count(selection, options));
  if (num_odd > 0) solved = solve(selection.views, width_px, height_px);
  MOR_CHECK(check_fit(solved, options));
  const Eigen::Vector2d covered = coverage(selection.views, width_px, height_px);
  if (covered.minCoeff() < kMinCoverage) {
    return refuse(fmt::format(
        "the board was seen in only {:.0f} % of the picture's width and {:.0f} % of its height, at "
        "least {:.0f} % are needed: hold it near the picture's edges and corners too",
        100.0 * covered.x(),
        100.0 * covered.y(),
        100.0 * kMinCoverage));
  }
  result.camera = solved.camera;
  result.sd = solved.sd;
  result.rms_px = solved.rms_px;
  result.held_out_rms_px = held_out_rms(selection.views, width_px, height_px);
  result.camera_from_board.resize(views.size());
  for (std::size_t k = 0; k < selection.used.size(); ++k) {
    auto& quality = result.views[selection.used[k]];
    quality.is_used = true;
    quality.rms_px = solved.view_rms_px[k];
    result.camera_from_board[selection.used[k]] = solved.camera_from_board[k];
  }
  MOR_CHECK(result.camera.check());
  return result;
}

}  // namespace

Result<LensCalibration> calibrate_lens(const CalibrationBoard& board,
                                       const std::vector<LensView>& views,
                                       int width_px,
                                       int height_px,
                                       const LensOptions& options) {
  MOR_CHECK(board.check());
  try {
    return calibrate(board, views, width_px, height_px, options);
  } catch (const cv::Exception& error) {
    return refuse("the views do not determine the lens: " + error.err);
  }
}

std::optional<Eigen::Isometry3d> camera_from_board(const CalibrationBoard& board,
                                                   const BoardSighting& sighting,
                                                   const PinholeCamera& camera) {
  try {
    const auto view = internal::correspondences_of(board, sighting);
    cv::Mat rotation;
    cv::Mat shift;
    if (view.px.size() < 4 || !cv::solvePnP(view.board_mm,
                                            view.px,
                                            internal::matrix_of(camera),
                                            internal::distortion_of(camera),
                                            rotation,
                                            shift)) {
      return std::nullopt;
    }
    const auto pose = internal::rigid_of(rotation, shift);
    if (!pose.matrix().allFinite() || !(pose.translation().z() > 0.0)) return std::nullopt;
    return pose;
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
}

double reprojection_rms_px(const CalibrationBoard& board,
                           const BoardSighting& sighting,
                           const PinholeCamera& camera,
                           const Eigen::Isometry3d& camera_from_board) {
  double sum = 0.0;
  int count = 0;
  for (const auto& corner : sighting.corners) {
    const auto px = camera.project(camera_from_board * board.corner_mm(corner.id));
    if (!px) continue;
    sum += (*px - corner.px).squaredNorm();
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : 0.0;
}

}  // namespace mor
