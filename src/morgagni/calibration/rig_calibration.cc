// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/rig_calibration.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <opencv2/calib3d.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/calibration/internal/opencv_types.h"
#include "morgagni/core/statistics.h"

namespace mor {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr std::size_t kMinShared = 8;
constexpr std::size_t kMinStereoViews = 5;
constexpr int kJackknifeBlocks = 6;
constexpr double kMaxOffsetPx = 50.0;
/// Squares that the depth camera measures so much larger or smaller were measured wrong.
constexpr double kMaxSquareError = 0.04;

tl::unexpected<Error> refuse(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, std::move(message));
}

/// The views in which a camera saw the board; `index` says where each stands among all.
struct LensSet {
  std::vector<LensView> views;
  std::vector<std::size_t> index;
};

LensSet lens_set(const std::vector<RigView>& views,
                 std::optional<BoardSighting> RigView::*sighting) {
  LensSet set;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!(views[i].*sighting)) continue;
    set.views.push_back({views[i].name, *(views[i].*sighting)});
    set.index.push_back(i);
  }
  return set;
}

/// Of all views, in their order.
std::vector<std::optional<Eigen::Isometry3d>> spread(
    const std::vector<std::optional<Eigen::Isometry3d>>& poses,
    const LensSet& set,
    std::size_t num_views) {
  std::vector<std::optional<Eigen::Isometry3d>> result(num_views);
  for (std::size_t k = 0; k < set.index.size(); ++k) result[set.index[k]] = poses[k];
  return result;
}

struct Stereo {
  Eigen::Isometry3d color_from_depth = Eigen::Isometry3d::Identity();
  double rms_px = 0.0;
};

Stereo solve_stereo(const std::vector<internal::SharedCorners>& shared,
                    const PinholeCamera& depth,
                    const PinholeCamera& color) {
  std::vector<std::vector<cv::Point3f>> board_mm;
  std::vector<std::vector<cv::Point2f>> depth_px;
  std::vector<std::vector<cv::Point2f>> color_px;
  for (const auto& view : shared) {
    board_mm.push_back(view.board_mm);
    depth_px.push_back(view.first_px);
    color_px.push_back(view.second_px);
  }
  cv::Mat depth_matrix(internal::matrix_of(depth));
  cv::Mat color_matrix(internal::matrix_of(color));
  auto depth_distortion = internal::distortion_of(depth);
  auto color_distortion = internal::distortion_of(color);
  cv::Mat rotation;
  cv::Mat shift;
  cv::Mat essential;
  cv::Mat fundamental;
  Stereo stereo;
  stereo.rms_px = cv::stereoCalibrate(board_mm,
                                      depth_px,
                                      color_px,
                                      depth_matrix,
                                      depth_distortion,
                                      color_matrix,
                                      color_distortion,
                                      cv::Size(),
                                      rotation,
                                      shift,
                                      essential,
                                      fundamental,
                                      cv::CALIB_FIX_INTRINSIC);
  stereo.color_from_depth = internal::rigid_of(rotation, shift);
  return stereo;
}

/// How far it wanders when a sixth of the views is left out in turn (Tukey's jackknife).
StereoQuality jackknife(const std::vector<internal::SharedCorners>& shared,
                        const Stereo& all,
                        const PinholeCamera& depth,
                        const PinholeCamera& color) {
  StereoQuality quality{.rms_px = all.rms_px, .num_views = static_cast<int>(shared.size())};
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  double turns = 0.0;
  for (int block = 0; block < kJackknifeBlocks; ++block) {
    std::vector<internal::SharedCorners> rest;
    for (std::size_t i = 0; i < shared.size(); ++i) {
      if (static_cast<int>(i) % kJackknifeBlocks != block) rest.push_back(shared[i]);
    }
    const auto without = solve_stereo(rest, depth, color);
    const Eigen::Vector3d moved =
        without.color_from_depth.translation() - all.color_from_depth.translation();
    squares += moved.cwiseAbs2();
    const double turn = Eigen::AngleAxisd(without.color_from_depth.linear().transpose() *
                                          all.color_from_depth.linear())
                            .angle();
    turns += turn * turn;
  }
  constexpr double kScale = (kJackknifeBlocks - 1.0) / kJackknifeBlocks;
  quality.shift_sd_mm = (kScale * squares).cwiseSqrt();
  quality.turn_sd_deg = kDegPerRad * std::sqrt(kScale * turns);
  return quality;
}

/// One calibration under way.
class Rig {
 public:
  Rig(const CalibrationBoard& board,
      const std::vector<RigView>& views,
      const RgbdCalibration& by_design,
      const RigOptions& options)
      : board_(board), views_(views), design_(by_design), options_(options) {}

  Result<RigCalibration> run() {
    result_.calibration = design_;
    result_.calibration.depth_correction = nullptr;
    result_.calibration.origin.clear();
    const auto colors = lens_set(views_, &RigView::color);
    MOR_TRY(result_.color, lens_of("colour camera", colors, design_.color));
    result_.calibration.color = result_.color.camera;
    color_from_board_ = spread(result_.color.camera_from_board, colors, views_.size());
    const auto infrareds = lens_set(views_, &RigView::infrared);
    if (infrareds.views.empty()) {
      MOR_CHECK(find_depth_camera_by_planes());
    } else {
      MOR_CHECK(find_depth_camera_by_infrared(infrareds));
    }
    if (options_.fits_depth) MOR_CHECK(find_correction());
    return std::move(result_);
  }

 private:
  Result<LensCalibration> lens_of(const char* name,
                                  const LensSet& set,
                                  const PinholeCamera& like) const {
    auto lens = calibrate_lens(board_, set.views, like.width_px, like.height_px, options_.lens);
    if (!lens) return refuse(fmt::format("{}: {}", name, lens.error().message));
    return lens;
  }

  Result<void> find_depth_camera_by_infrared(const LensSet& infrareds) {
    MOR_TRY(result_.infrared, lens_of("depth camera (infrared)", infrareds, design_.depth));
    result_.calibration.depth = result_.infrared->camera;
    const auto depth_from_board =
        spread(result_.infrared->camera_from_board, infrareds, views_.size());
    std::vector<internal::SharedCorners> shared;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (!color_from_board_[i] || !depth_from_board[i]) continue;
      auto corners = internal::shared_corners(board_, *views_[i].infrared, *views_[i].color);
      if (corners.board_mm.size() >= kMinShared) shared.push_back(std::move(corners));
    }
    if (shared.size() < kMinStereoViews) {
      return refuse(
          fmt::format("only {} views show the board well in the colour and in the infrared picture "
                      "of one pose, "
                      "at least {} are needed",
                      shared.size(),
                      kMinStereoViews));
    }
    const auto stereo = solve_stereo(shared, result_.calibration.depth, result_.calibration.color);
    if (stereo.rms_px > options_.lens.max_rms_px) {
      return refuse(fmt::format(
          "the colour and the infrared pictures do not fit one device: {:.2f} px off in the mean, "
          "at most {:.2f} are allowed; did the board move between the two?",
          stereo.rms_px,
          options_.lens.max_rms_px));
    }
    result_.calibration.color_from_depth = stereo.color_from_depth;
    result_.stereo =
        jackknife(shared, stereo, result_.calibration.depth, result_.calibration.color);
    // The lens is the same; only the picture was cut elsewhere.
    result_.calibration.depth.center_x_px += options_.infrared_offset_px.x();
    result_.calibration.depth.center_y_px += options_.infrared_offset_px.y();
    depth_from_board_ = depth_from_board;
    chain_missing();
    return check_square_size();
  }

  /// Where only the colour camera saw a board, its place for the depth camera follows.
  void chain_missing() {
    depth_from_board_.resize(views_.size());
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (depth_from_board_[i] || !color_from_board_[i]) continue;
      depth_from_board_[i] = result_.calibration.color_from_depth.inverse() * *color_from_board_[i];
    }
  }

  std::vector<DepthReading> readings(BoardArea area,
                                     std::size_t i,
                                     const DepthReader& reader) const {
    const auto& pose = depth_from_board_[i];
    if (views_[i].depth_mm.empty() || !pose) return {};
    return reader.read(views_[i].depth_mm, board_, *pose, area, static_cast<int>(i));
  }

  /// The depth camera measures the board's distance, which the squares' size says too.
  Result<void> check_square_size() const {
    const DepthReader reader(result_.calibration.depth);
    std::vector<double> ratios;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      for (const auto& reading : readings(BoardArea::kRough, i, reader)) {
        ratios.push_back(reading.seen_mm / reading.true_mm);
      }
    }
    if (ratios.empty()) return {};
    const double ratio = quantile(std::move(ratios), 0.5);
    if (std::abs(ratio - 1.0) <= kMaxSquareError) return {};
    return refuse(fmt::format(
        "by the depth camera the board's squares are {:.1f} mm wide, not {:.1f}: measure the print "
        "and say its true size",
        ratio * board_.square_mm,
        board_.square_mm));
  }

  Result<void> find_depth_camera_by_planes() {
    chain_missing();
    MOR_CHECK(check_square_size());
    const DepthReader reader(design_.depth);
    std::vector<PlaneView> planes;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      auto seen = readings(BoardArea::kInside, i, reader);
      if (seen.size() >= 6) planes.push_back({*color_from_board_[i], std::move(seen)});
    }
    if (planes.empty()) {
      result_.remarks.emplace_back(
          "There is neither an infrared picture nor a depth picture: only the colour camera was "
          "calibrated, the rest is the design's.");
      return {};
    }
    MOR_TRY(result_.planes, find_plane_geometry(planes, design_));
    result_.calibration.depth = result_.planes->depth;
    result_.calibration.color_from_depth = result_.planes->color_from_depth;
    std::string weak;
    for (const auto& unknown : result_.planes->unknowns) {
      if (unknown.is_determined()) continue;
      weak += (weak.empty() ? "" : ", ") + unknown.name.substr(0, unknown.name.find(','));
    }
    result_.remarks.push_back(fmt::format(
        "Without infrared pictures the depth camera was found by the board's plane alone: its "
        "lens's distortion stays the design's{}.",
        weak.empty() ? "" : ", and so, nearly, do what the views tell little of: " + weak));
    depth_from_board_.assign(views_.size(), std::nullopt);
    chain_missing();
    return {};
  }

  Result<void> find_correction() {
    const DepthReader reader(result_.calibration.depth);
    std::vector<DepthReading> all;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      for (const auto& reading : readings(BoardArea::kWhole, i, reader)) all.push_back(reading);
    }
    if (all.empty()) {
      result_.remarks.emplace_back("There is no depth of the board: the depth was not corrected.");
      return {};
    }
    auto fit = fit_depth(all, design_.depth.width_px, design_.depth.height_px, options_.depth);
    if (!fit) {
      result_.remarks.push_back("The depth was not corrected: " + fit.error().message + ".");
      return {};
    }
    result_.depth = *std::move(fit);
    if (!result_.depth->helps()) {
      result_.remarks.push_back(fmt::format(
          "The depth needs no correction: its error on views held out is {:.1f} mm without, {:.1f} "
          "mm with one.",
          result_.depth->rms_before_mm,
          result_.depth->rms_after_mm));
      return {};
    }
    result_.calibration.depth_correction =
        std::make_shared<const DepthCorrection>(result_.depth->correction);
    return {};
  }

  const CalibrationBoard& board_;
  const std::vector<RigView>& views_;
  const RgbdCalibration& design_;
  const RigOptions& options_;
  RigCalibration result_;
  std::vector<std::optional<Eigen::Isometry3d>> color_from_board_;
  std::vector<std::optional<Eigen::Isometry3d>> depth_from_board_;
};

void add_lens(const std::string& name,
              const LensCalibration& lens,
              std::vector<std::pair<std::string, std::string>>& figures) {
  const auto used = std::ranges::count(lens.views, true, &LensViewQuality::is_used);
  figures.emplace_back(
      name,
      fmt::format("focal length {:.2f} +- {:.2f} px, centre {:.2f} +- {:.2f}, {:.2f} +- {:.2f} px, "
                  "{} of {} views",
                  lens.camera.focal_x_px,
                  lens.sd.focal_x_px,
                  lens.camera.center_x_px,
                  lens.sd.center_x_px,
                  lens.camera.center_y_px,
                  lens.sd.center_y_px,
                  used,
                  lens.views.size()));
  figures.emplace_back(name + ", reprojection",
                       fmt::format("{:.2f} px, held out {:.2f} px ({:.2f} mm at 1 m)",
                                   lens.rms_px,
                                   lens.held_out_rms_px,
                                   lens.held_out_mm_at_1m()));
}

}  // namespace

std::vector<std::pair<std::string, std::string>> RigCalibration::figures() const {
  std::vector<std::pair<std::string, std::string>> result;
  add_lens("colour camera", color, result);
  if (infrared) add_lens("depth camera", *infrared, result);
  if (stereo) {
    const auto& shift = calibration.color_from_depth.translation();
    result.emplace_back(
        "from camera to camera",
        fmt::format("{:.1f} +- {:.2f} mm, rotation +- {:.3f} degrees, {} views, {:.2f} px",
                    shift.norm(),
                    stereo->shift_sd_mm.norm(),
                    stereo->turn_sd_deg,
                    stereo->num_views,
                    stereo->rms_px));
  }
  if (planes) {
    for (const auto& unknown : planes->unknowns) {
      result.emplace_back(
          "by planes: " + unknown.name,
          fmt::format("{:+.2f} +- {:.2f}{}",
                      unknown.value,
                      unknown.sd,
                      unknown.is_determined() ? "" : " (the views tell little of it)"));
    }
  }
  if (depth) {
    result.emplace_back(
        "depth error, views held out",
        fmt::format("{:.1f} mm before, {:.1f} mm after ({}, {} distances, {:.0f} % of the picture)",
                    depth->rms_before_mm,
                    depth->rms_after_mm,
                    to_string(depth->form),
                    depth->num_distances,
                    100.0 * depth->coverage));
  }
  return result;
}

Result<RigCalibration> calibrate_rig(const CalibrationBoard& board,
                                     const std::vector<RigView>& views,
                                     const RgbdCalibration& by_design,
                                     const RigOptions& options) {
  MOR_CHECK(board.check());
  if (!(options.infrared_offset_px.cwiseAbs().maxCoeff() <= kMaxOffsetPx)) {
    return refuse(fmt::format("the infrared offset must be in [-{0}, {0}] px, got {1} and {2}",
                              kMaxOffsetPx,
                              options.infrared_offset_px.x(),
                              options.infrared_offset_px.y()));
  }
  try {
    return Rig(board, views, by_design, options).run();
  } catch (const cv::Exception& error) {
    return refuse("the views do not determine the device: " + error.err);
  }
}

}  // namespace mor
