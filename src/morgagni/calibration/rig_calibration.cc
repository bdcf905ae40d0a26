// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/rig_calibration.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <opencv2/calib3d.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/calibration/internal/opencv_types.h"
#include "morgagni/calibration/joint_calibration.h"
#include "morgagni/core/statistics.h"

namespace mor {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr std::size_t kMinShared = 8;
constexpr std::size_t kMinStereoViews = 5;
/// A board is a plane for the depth camera from so many readings on.
constexpr std::size_t kMinReadings = 6;
constexpr std::ptrdiff_t kMinPlanes = 6;
/// Every third view's depth is held out for the judgement; the last calibration takes all.
constexpr std::size_t kHoldOutEach = 3;
constexpr std::size_t kHoldOutAt = 1;
constexpr double kMaxOffsetPx = 50.0;
/// Squares that the depth camera measures so much larger or smaller were measured wrong.
constexpr double kMaxSquareError = 0.04;
/// Less than that no calibration is said to leave unknown of the depth camera's lens: what the
/// formal errors do not tell, of a lens that no model follows wholly and a board that is not flat.
constexpr PinholeSd kLeastSd{.focal_ratio = 0.001, .center_px = 0.2};

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

/// What the joint calibration found, and its uncertainty, in place of what a lens's own views said.
void adopt(const PinholeCamera& camera,
           const PinholeCamera& sd,
           double rms_px,
           LensCalibration& lens) {
  lens.camera = camera;
  lens.sd = sd;
  lens.rms_px = rms_px;
}

PinholeSd depth_sd_of(const JointCalibration& found) {
  const auto& sd = found.depth_sd;
  return {.focal_ratio = std::max({kLeastSd.focal_ratio,
                                   sd.focal_x_px / found.depth.focal_x_px,
                                   sd.focal_y_px / found.depth.focal_y_px}),
          .center_px = std::max({kLeastSd.center_px, sd.center_x_px, sd.center_y_px})};
}

/// Of a depth camera found by boards as planes.
std::vector<DesignChange> changes_from(const RgbdCalibration& design,
                                       const JointCalibration& found,
                                       const DesignTrust& trust) {
  const auto& depth = design.depth;
  const Eigen::AngleAxisd turned(found.color_from_depth.linear() *
                                 design.color_from_depth.linear().transpose());
  const Eigen::Vector3d turn = turned.angle() * turned.axis();
  const Eigen::Vector3d shift =
      found.color_from_depth.translation() - design.color_from_depth.translation();
  std::vector<DesignChange> changes;
  for (int i = 0; i < 3; ++i) {
    changes.push_back({fmt::format("rotation {}, degrees", "xyz"[i]),
                       kDegPerRad * turn[i],
                       kDegPerRad * found.turn_sd_rad[i],
                       kDegPerRad * trust.turn_rad});
  }
  for (int i = 0; i < 3; ++i) {
    changes.push_back(
        {fmt::format("shift {}, mm", "xyz"[i]), shift[i], found.shift_sd_mm[i], trust.shift_mm});
  }
  changes.push_back({"focal length, %",
                     100.0 * (found.depth.focal_x_px / depth.focal_x_px - 1.0),
                     100.0 * found.depth_sd.focal_x_px / depth.focal_x_px,
                     100.0 * trust.focal_share});
  changes.push_back({"centre x, px",
                     found.depth.center_x_px - depth.center_x_px,
                     found.depth_sd.center_x_px,
                     trust.center_px});
  changes.push_back({"centre y, px",
                     found.depth.center_y_px - depth.center_y_px,
                     found.depth_sd.center_y_px,
                     trust.center_px});
  for (std::size_t i = 0; i < 2; ++i) {
    changes.push_back({fmt::format("distortion k{}", i + 1),
                       found.depth.distortion[i] - depth.distortion[i],
                       found.depth_sd.distortion[i],
                       trust.radial});
  }
  return changes;
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
    start_ = design_;
    start_.depth_correction = nullptr;
    start_.origin.clear();
    start_.depth_sd.reset();
    const auto colors = lens_set(views_, &RigView::color);
    MOR_TRY(result_.color, lens_of("colour camera", colors, design_.color));
    start_.color = result_.color.camera;
    const auto color_from_board = spread(result_.color.camera_from_board, colors, views_.size());
    const auto infrareds = lens_set(views_, &RigView::infrared);
    std::vector<std::optional<Eigen::Isometry3d>> depth_from_board(views_.size());
    if (!infrareds.views.empty()) {
      MOR_TRY(result_.infrared, lens_of("depth camera (infrared)", infrareds, design_.depth));
      depth_from_board = spread(result_.infrared->camera_from_board, infrareds, views_.size());
      MOR_CHECK(find_stereo(color_from_board, depth_from_board));
    }
    gather(color_from_board, depth_from_board);
    MOR_CHECK(calibrate());
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

  /// From the views that both cameras saw well.
  Result<void> find_stereo(const std::vector<std::optional<Eigen::Isometry3d>>& color_from_board,
                           const std::vector<std::optional<Eigen::Isometry3d>>& depth_from_board) {
    start_.depth = result_.infrared->camera;
    std::vector<internal::SharedCorners> shared;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (!color_from_board[i] || !depth_from_board[i]) continue;
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
    const auto stereo = solve_stereo(shared, start_.depth, start_.color);
    if (stereo.rms_px > options_.lens.max_rms_px) {
      return refuse(fmt::format(
          "the colour and the infrared pictures do not fit one device: {:.2f} px off in the mean, "
          "at most {:.2f} are allowed; did the board move between the two?",
          stereo.rms_px,
          options_.lens.max_rms_px));
    }
    start_.color_from_depth = stereo.color_from_depth;
    result_.stereo =
        StereoQuality{.rms_px = stereo.rms_px, .num_views = static_cast<int>(shared.size())};
    return {};
  }

  /// The views with a place of the board, by the colour camera where it saw it.
  void gather(const std::vector<std::optional<Eigen::Isometry3d>>& color_from_board,
              const std::vector<std::optional<Eigen::Isometry3d>>& depth_from_board) {
    for (std::size_t i = 0; i < views_.size(); ++i) {
      JointView view;
      if (color_from_board[i]) {
        view.color = views_[i].color;
        view.depth_from_board = start_.color_from_depth.inverse() * *color_from_board[i];
      } else if (depth_from_board[i]) {
        view.depth_from_board = *depth_from_board[i];
      } else {
        continue;
      }
      if (depth_from_board[i]) view.infrared = views_[i].infrared;
      joint_views_.push_back(std::move(view));
      depth_pictures_.push_back(&views_[i].depth_mm);
    }
  }

  /// The depth picture's lens is that of the infrared one; only the picture was cut elsewhere.
  PinholeCamera depth_picture_lens(PinholeCamera lens) const {
    lens.center_x_px += infrared_offset_px().x();
    lens.center_y_px += infrared_offset_px().y();
    return lens;
  }
  Eigen::Vector2d infrared_offset_px() const {
    return result_.infrared ? options_.infrared_offset_px : Eigen::Vector2d::Zero();
  }

  std::vector<std::vector<DepthReading>> read(const PinholeCamera& depth, BoardArea area) const {
    const DepthReader reader(depth_picture_lens(depth));
    std::vector<std::vector<DepthReading>> readings(joint_views_.size());
    for (std::size_t i = 0; i < joint_views_.size(); ++i) {
      if (depth_pictures_[i]->empty()) continue;
      readings[i] = reader.read(
          *depth_pictures_[i], board_, joint_views_[i].depth_from_board, area, static_cast<int>(i));
    }
    return readings;
  }

  /// The depth camera measures the board's distance, which the squares' size says too.
  Result<void> check_square_size() const {
    std::vector<double> ratios;
    for (const auto& of_view : read(start_.depth, BoardArea::kRough)) {
      for (const auto& reading : of_view) ratios.push_back(reading.seen_mm / reading.true_mm);
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

  Result<void> calibrate() {
    MOR_CHECK(check_square_size());
    JointOptions joint{.depth = options_.depth, .infrared_offset_px = infrared_offset_px()};
    if (!result_.infrared) joint.design_trust = DesignTrust{};
    auto readings = read(start_.depth, BoardArea::kWhole);
    const auto num_planes = std::ranges::count_if(
        readings, [](const auto& of_view) { return of_view.size() >= kMinReadings; });
    if (!result_.infrared && num_planes == 0) {
      result_.remarks.emplace_back(
          "There is neither an infrared picture nor a depth picture: only the colour camera was "
          "calibrated, the rest is the design's.");
      result_.calibration = start_;
      return {};
    }
    if (!result_.infrared && num_planes < kMinPlanes) {
      return refuse(
          fmt::format("the depth camera saw the board in only {} views, at least {} are needed",
                      num_planes,
                      kMinPlanes));
    }
    const bool has_span = options_.fits_depth && can_correct(readings);
    // Without infrared pictures the readings tell of the lens, even where they are too few for a
    // correction.
    if (has_span || !result_.infrared) {
      choose_form(readings, joint, has_span);
      for (std::size_t i = 0; i < readings.size(); ++i) joint_views_[i].readings = readings[i];
    }
    found_ = calibrate_jointly(board_, joint_views_, start_, joint);
    return report(joint, has_span);
  }

  bool can_correct(const std::vector<std::vector<DepthReading>>& readings) {
    std::vector<DepthReading> all;
    for (const auto& of_view : readings) all.insert(all.end(), of_view.begin(), of_view.end());
    if (all.empty()) {
      result_.remarks.emplace_back("There is no depth of the board: the depth was not corrected.");
      return false;
    }
    auto span = depth_span(all, design_.depth.width_px, design_.depth.height_px, options_.depth);
    if (!span) {
      result_.remarks.push_back("The depth was not corrected: " + span.error().message + ".");
      return false;
    }
    result_.depth = DepthFit{.span = *span};
    return true;
  }

  /// Root mean square over a view, the median of those held out: a far board's pose is uncertain.
  ReadingErrors held_out_errors(const JointCalibration& found,
                                const std::vector<std::vector<DepthReading>>& readings) const {
    std::vector<double> before_mm;
    std::vector<double> after_mm;
    for (auto i = kHoldOutAt; i < readings.size(); i += kHoldOutEach) {
      if (readings[i].size() < kMinReadings) continue;
      const auto errors = reading_errors(board_, found, i, readings[i], infrared_offset_px());
      before_mm.push_back(errors.rms_before_mm);
      after_mm.push_back(errors.rms_after_mm);
    }
    return {quantile(std::move(before_mm), 0.5), quantile(std::move(after_mm), 0.5)};
  }

  /// Of the forms asked for, the one that does better on views whose depth it has not seen. What
  /// was found without them tells better which readings are of the board.
  void choose_form(std::vector<std::vector<DepthReading>>& readings,
                   JointOptions& joint,
                   bool is_reported) {
    auto views = joint_views_;
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (i % kHoldOutEach != kHoldOutAt) views[i].readings = readings[i];
    }
    std::optional<JointCalibration> best;
    double least_mm = 0.0;
    for (const auto form : {DepthForm::kDisparity, DepthForm::kTimeOfFlight}) {
      if (options_.depth.form != DepthForm::kAuto && options_.depth.form != form) continue;
      auto tried = joint;
      tried.form = form;
      auto found = calibrate_jointly(board_, views, start_, tried);
      const auto errors = held_out_errors(found, readings);
      if (best && errors.rms_after_mm >= least_mm) continue;
      best = std::move(found);
      least_mm = errors.rms_after_mm;
      joint.form = form;
      if (!is_reported) continue;
      result_.depth->form = form;
      result_.depth->rms_before_mm = errors.rms_before_mm;
      result_.depth->rms_after_mm = errors.rms_after_mm;
    }
    for (std::size_t i = 0; i < joint_views_.size(); ++i) {
      joint_views_[i].depth_from_board = best->depth_from_board[i];
    }
    readings = read(best->depth, BoardArea::kWhole);
  }

  Result<void> report(const JointOptions& joint, bool has_span) {
    adopt(found_.color, found_.color_sd, found_.color_rms_px, result_.color);
    if (result_.infrared) {
      adopt(found_.depth, found_.depth_sd, found_.infrared_rms_px, *result_.infrared);
      result_.stereo->shift_sd_mm = found_.shift_sd_mm;
      result_.stereo->turn_sd_deg = kDegPerRad * found_.turn_sd_rad.norm();
    } else {
      result_.changes = changes_from(design_, found_, *joint.design_trust);
      say_what_is_weak();
    }
    result_.calibration = start_;
    result_.calibration.color = found_.color;
    result_.calibration.depth = depth_picture_lens(found_.depth);
    result_.calibration.depth_sd = depth_sd_of(found_);
    result_.calibration.color_from_depth = found_.color_from_depth;
    if (!result_.calibration.color_from_depth.matrix().allFinite()) {
      return refuse("the views do not determine the device");
    }
    MOR_CHECK(result_.calibration.color.check());
    MOR_CHECK(result_.calibration.depth.check());
    if (!has_span) return {};
    result_.depth->correction = found_.correction;
    if (!result_.depth->helps()) {
      result_.remarks.push_back(fmt::format(
          "The depth needs no correction: its error on views held out is {:.1f} mm without, {:.1f} "
          "mm with one.",
          result_.depth->rms_before_mm,
          result_.depth->rms_after_mm));
      return {};
    }
    MOR_CHECK(found_.correction.check());
    result_.calibration.depth_correction =
        std::make_shared<const DepthCorrection>(found_.correction);
    return {};
  }

  void say_what_is_weak() {
    std::string weak;
    for (const auto& change : result_.changes) {
      if (change.is_determined()) continue;
      weak += (weak.empty() ? "" : ", ") + change.name.substr(0, change.name.find(','));
    }
    result_.remarks.push_back(
        "Without infrared pictures the depth camera was found by the board's planes alone, about "
        "four times less exactly" +
        (weak.empty() ? "."
                      : "; what the views tell little of stays near the design: " + weak + "."));
  }

  const CalibrationBoard& board_;
  const std::vector<RigView>& views_;
  const RgbdCalibration& design_;
  const RigOptions& options_;
  RgbdCalibration start_;  ///< By each lens alone.
  std::vector<JointView> joint_views_;
  std::vector<const Image<float>*> depth_pictures_;  ///< Of the same.
  JointCalibration found_;
  RigCalibration result_;
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
  for (const auto& change : changes) {
    result.emplace_back(
        "by planes: " + change.name,
        fmt::format("{:+.2f} +- {:.2f}{}",
                    change.value,
                    change.sd,
                    change.is_determined() ? "" : " (the views tell little of it)"));
  }
  if (depth) {
    result.emplace_back(
        "depth error, views held out",
        fmt::format("{:.1f} mm before, {:.1f} mm after ({}, {} distances, {:.0f} % of the picture)",
                    depth->rms_before_mm,
                    depth->rms_after_mm,
                    to_string(depth->form),
                    depth->span.num_distances,
                    100.0 * depth->span.coverage));
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
