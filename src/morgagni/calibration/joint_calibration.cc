// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/joint_calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Cholesky>

#include "morgagni/calibration/internal/depth_model.h"
#include "morgagni/calibration/internal/equations.h"
#include "morgagni/calibration/internal/joint_rows.h"
#include "morgagni/core/statistics.h"

namespace mor {
namespace {

using internal::DepthModel;
using internal::Equations;
using internal::kLensSize;
using internal::SlopeRow;

/// Where the unknowns' steps stand; after them the depth's correction, then six of each pose.
constexpr int kColorLens = 0;
constexpr int kDepthLens = kLensSize;
constexpr int kRigTurn = 2 * kLensSize;
constexpr int kRigShift = kRigTurn + 3;
constexpr int kWallBehind = kRigShift + 3;
constexpr int kWallTilt = kWallBehind + 1;
constexpr int kCorrection = kWallTilt + 2;
constexpr int kPoseSize = 6;

constexpr int kMinSteps = 5;
constexpr int kMaxSteps = 25;
/// Steps smaller than this share of what each unknown is uncertain by alone are the last.
constexpr double kEnough = 0.01;
constexpr double kHuberSds = 2.5;  ///< Corners farther off count less,
constexpr double kTukeySds = 5.0;  ///< readings farther off not at all.
constexpr double kMadToSd = 1.4826;
constexpr double kFirstCornerSdPx = 0.3;
constexpr double kLeastCornerSdPx = 0.02;
constexpr double kCornersOfAll = 30.0;
/// Of the depth model's own standard deviation.
constexpr double kFirstDepthSd = 2.0;
constexpr double kLeastDepthSd = 0.1;
/// The readings of a view weigh together as so many: what the model does not follow (patterns of
/// the sensor, a slant's influence) is alike in neighbours, and must not bend lenses and poses.
/// On synthetic boards 20 to 60 do equally well; from 300 on the focal length is pulled.
constexpr double kEffectiveReadings = 40.0;
/// A board is some millimetres thick, and what it lies on goes on behind it nearly even.
constexpr double kWallBehindSdMm = 5.0;
constexpr double kWallTiltSdRad = 0.003;

double huber(double sds) {
  return std::abs(sds) > kHuberSds ? kHuberSds / std::abs(sds) : 1.0;
}

double tukey(double sds) {
  const double share = std::min(1.0, std::abs(sds) / kTukeySds);
  return (1.0 - share * share) * (1.0 - share * share);
}

/// Standard deviation of what scatters about 0, whatever a few wild ones do.
double robust_sd(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return kMadToSd * quantile(std::move(values), 0.5);
}

std::vector<double> joined(const std::vector<std::vector<double>>& parts) {
  std::vector<double> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

double reading_quantile(const std::vector<JointView>& views, double share, double if_none) {
  std::vector<double> distances;
  for (const auto& view : views) {
    for (const auto& reading : view.readings) distances.push_back(reading.seen_mm);
  }
  return distances.empty() ? if_none : quantile(std::move(distances), share);
}

PinholeCamera lens_of_depth_picture(const JointCalibration& calibration,
                                    const Eigen::Vector2d& infrared_offset_px) {
  PinholeCamera lens = calibration.depth;
  lens.center_x_px += infrared_offset_px.x();
  lens.center_y_px += infrared_offset_px.y();
  return lens;
}

/// What a reading should lie on: the board, or what the board lies on.
struct Surface {
  Surface(const JointCalibration& calibration,
          const Eigen::Isometry3d& depth_from_board,
          const Eigen::Vector3d& middle_mm,
          bool is_beside)
      : normal(depth_from_board.linear().col(2)), on_plane(depth_from_board * middle_mm) {
    if (!is_beside) return;
    on_plane += calibration.wall_behind_mm * normal;
    normal += depth_from_board.linear().leftCols<2>() * calibration.wall_tilt_rad;
  }

  Eigen::Vector3d normal;
  Eigen::Vector3d on_plane;
};

Eigen::Vector3d middle_of(const CalibrationBoard& board) {
  return 0.5 * board.corner_mm(board.num_corners() - 1);
}

class Joint {
 public:
  Joint(const CalibrationBoard& board,
        const std::vector<JointView>& views,
        const RgbdCalibration& start,
        const JointOptions& options)
      : board_(board),
        views_(views),
        start_(start),
        options_(options),
        model_(options.depth,
               options.form,
               start.depth.width_px,
               start.depth.height_px,
               reading_quantile(views, 0.01, 500.0),
               reading_quantile(views, 0.99, 1000.0)),
        middle_mm_(middle_of(board)),
        correction_(Eigen::VectorXd::Zero(model_.num_unknowns())),
        color_sd_px_(views.size(), kFirstCornerSdPx),
        infrared_sd_px_(views.size(), kFirstCornerSdPx) {
    result_.color = start.color;
    result_.depth = start.depth;
    result_.color_from_depth = start.color_from_depth;
    for (const auto& view : views) result_.depth_from_board.push_back(view.depth_from_board);
  }

  JointCalibration run() {
    for (int step = 0; step < kMaxSteps; ++step) {
      const Equations equations = gather();
      const Eigen::VectorXd change = equations.matrix().ldlt().solve(equations.right());
      take(change);
      learn_noise();
      const double most =
          (change.array().square() * equations.matrix().diagonal().array()).maxCoeff();
      if (step + 1 >= kMinSteps && most < kEnough * kEnough) break;
    }
    finish();
    return std::move(result_);
  }

 private:
  [[nodiscard]] int pose_at(std::size_t view) const {
    return kCorrection + model_.num_unknowns() + kPoseSize * static_cast<int>(view);
  }
  [[nodiscard]] int size() const { return pose_at(views_.size()); }

  Equations gather() {
    Equations equations(size());
    color_off_px_.assign(views_.size(), {});
    infrared_off_px_.assign(views_.size(), {});
    depth_off_sds_.clear();
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (views_[i].color) add_color(i, equations);
      if (views_[i].infrared) add_infrared(i, equations);
      add_readings(i, equations);
    }
    add_beliefs(equations);
    if (options_.design_trust) add_design(*options_.design_trust, equations);
    return equations;
  }

  void add_color(std::size_t view, Equations& equations) {
    const auto& depth_from_board = result_.depth_from_board[view];
    const Eigen::Matrix3d turn = result_.color_from_depth.linear();
    for (const auto& corner : views_[view].color->corners) {
      const Eigen::Vector3d in_depth = depth_from_board * board_.corner_mm(corner.id);
      const auto seen = internal::see(result_.color, result_.color_from_depth * in_depth);
      if (!seen) continue;
      const Eigen::Vector3d from_middle = in_depth - depth_from_board * middle_mm_;
      for (int axis = 0; axis < 2; ++axis) {
        const Eigen::Vector3d by_point = seen->by_point.row(axis);
        const Eigen::Vector3d by_in_depth = turn.transpose() * by_point;
        SlopeRow row;
        row.put_all(kColorLens, seen->by_lens.row(axis));
        row.put_all(kRigTurn, (turn * in_depth).cross(by_point));
        row.put_all(kRigShift, by_point);
        row.put_all(pose_at(view), from_middle.cross(by_in_depth));
        row.put_all(pose_at(view) + 3, by_in_depth);
        const double off_px = seen->px[axis] - corner.px[axis];
        color_off_px_[view].push_back(off_px);
        add_corner(row, off_px, color_sd_px_[view], equations);
      }
    }
  }

  void add_infrared(std::size_t view, Equations& equations) {
    const auto& depth_from_board = result_.depth_from_board[view];
    for (const auto& corner : views_[view].infrared->corners) {
      const Eigen::Vector3d point = depth_from_board * board_.corner_mm(corner.id);
      const auto seen = internal::see(result_.depth, point);
      if (!seen) continue;
      const Eigen::Vector3d from_middle = point - depth_from_board * middle_mm_;
      for (int axis = 0; axis < 2; ++axis) {
        const Eigen::Vector3d by_point = seen->by_point.row(axis);
        SlopeRow row;
        row.put_all(kDepthLens, seen->by_lens.row(axis));
        row.put_all(pose_at(view), from_middle.cross(by_point));
        row.put_all(pose_at(view) + 3, by_point);
        const double off_px = seen->px[axis] - corner.px[axis];
        infrared_off_px_[view].push_back(off_px);
        add_corner(row, off_px, infrared_sd_px_[view], equations);
      }
    }
  }

  static void add_corner(const SlopeRow& row, double off_px, double sd_px, Equations& equations) {
    equations.add(row, off_px, huber(off_px / sd_px) / (sd_px * sd_px));
  }

  void add_readings(std::size_t view, Equations& equations) {
    const auto& readings = views_[view].readings;
    const PinholeCamera lens = lens_of_depth_picture(result_, options_.infrared_offset_px);
    const Eigen::Matrix3d axes = result_.depth_from_board[view].linear();
    const double together = std::min(
        1.0, kEffectiveReadings / std::max<double>(1.0, static_cast<double>(readings.size())));
    for (const auto& reading : readings) {
      const Surface surface(result_, result_.depth_from_board[view], middle_mm_, reading.is_beside);
      const auto ray = internal::ray_of(lens, reading.px);
      const auto met = internal::meet(ray.ray, surface.normal, surface.on_plane);
      SlopeRow row;
      row.put_all(kDepthLens, -met.by_ray.transpose() * ray.by_lens);
      row.put_all(pose_at(view), -met.by_turn);
      row.put_all(pose_at(view) + 3, -met.by_shift);
      if (reading.is_beside) {
        row.put(kWallBehind, -met.by_shift.dot(axes.col(2)));
        row.put_all(kWallTilt, -axes.leftCols<2>().transpose() * met.by_normal);
      }
      const auto correction = model_.row(reading);
      double off_mm = reading.seen_mm - met.z_mm;
      for (const auto& [index, factor] : correction.entries) {
        row.put(kCorrection + index, factor);
        off_mm += factor * correction_[index];
      }
      depth_off_sds_.push_back(off_mm / correction.sd);
      const double sd_mm = depth_sd_ * correction.sd;
      equations.add(row, off_mm, together * tukey(off_mm / sd_mm) / (sd_mm * sd_mm));
    }
  }

  void add_beliefs(Equations& equations) const {
    equations.believe(kWallBehind, result_.wall_behind_mm, kWallBehindSdMm);
    equations.believe(kWallTilt, result_.wall_tilt_rad.x(), kWallTiltSdRad);
    equations.believe(kWallTilt + 1, result_.wall_tilt_rad.y(), kWallTiltSdRad);
    for (const auto& prior : model_.prior()) {
      SlopeRow row;
      double off = -prior.amount;
      for (const auto& [index, factor] : prior.entries) {
        row.put(kCorrection + index, factor);
        off += factor * correction_[index];
      }
      equations.add(row, off, 1.0 / (prior.sd * prior.sd));
    }
  }

  void add_design(const DesignTrust& trust, Equations& equations) const {
    const internal::LensVector off =
        internal::lens_vector(result_.depth) - internal::lens_vector(start_.depth);
    const double focal_px = start_.depth.focal_x_px;
    const double aspect_sd_px = trust.aspect_share * focal_px;
    SlopeRow aspect;
    aspect.put(kDepthLens, 1.0);
    aspect.put(kDepthLens + 1, -1.0);
    equations.add(aspect, off[0] - off[1], 1.0 / (aspect_sd_px * aspect_sd_px));
    equations.believe(kDepthLens, off[0], trust.focal_share * focal_px);
    const std::array<double, 6> sds = {trust.center_px,
                                       trust.center_px,
                                       trust.radial,
                                       trust.radial,
                                       trust.tangential,
                                       trust.tangential};
    for (int i = 0; i < 6; ++i) {
      equations.believe(kDepthLens + 2 + i, off[2 + i], sds[static_cast<std::size_t>(i)]);
    }
    const Eigen::AngleAxisd turned(result_.color_from_depth.linear() *
                                   start_.color_from_depth.linear().transpose());
    const Eigen::Vector3d turn = turned.angle() * turned.axis();
    const Eigen::Vector3d shift =
        result_.color_from_depth.translation() - start_.color_from_depth.translation();
    for (int i = 0; i < 3; ++i) {
      equations.believe(kRigTurn + i, turn[i], trust.turn_rad);
      equations.believe(kRigShift + i, shift[i], trust.shift_mm);
    }
  }

  void take(const Eigen::VectorXd& change) {
    internal::set_lens(internal::lens_vector(result_.color) + change.segment<kLensSize>(kColorLens),
                       result_.color);
    internal::set_lens(internal::lens_vector(result_.depth) + change.segment<kLensSize>(kDepthLens),
                       result_.depth);
    internal::move(change.segment<3>(kRigTurn),
                   change.segment<3>(kRigShift),
                   result_.color_from_depth.translation(),
                   result_.color_from_depth);
    result_.wall_behind_mm += change[kWallBehind];
    result_.wall_tilt_rad += change.segment<2>(kWallTilt);
    correction_ += change.segment(kCorrection, model_.num_unknowns());
    for (std::size_t i = 0; i < views_.size(); ++i) {
      auto& pose = result_.depth_from_board[i];
      internal::move(change.segment<3>(pose_at(i)),
                     change.segment<3>(pose_at(i) + 3),
                     pose * middle_mm_,
                     pose);
    }
  }

  void learn_noise() {
    learn_corner_noise(color_off_px_, color_sd_px_);
    learn_corner_noise(infrared_off_px_, infrared_sd_px_);
    if (!depth_off_sds_.empty()) {
      depth_sd_ = std::max(kLeastDepthSd, robust_sd(depth_off_sds_));
    }
  }

  /// View by view: far, slanted and dim boards are placed worse.
  static void learn_corner_noise(const std::vector<std::vector<double>>& off_px,
                                 std::vector<double>& sd_px) {
    const double of_all_px = robust_sd(joined(off_px));
    for (std::size_t i = 0; i < off_px.size(); ++i) {
      const auto count = static_cast<double>(off_px[i].size());
      const double own_px = robust_sd(off_px[i]);
      // A view of few corners takes part of what all have.
      const double variance = (count * own_px * own_px + kCornersOfAll * of_all_px * of_all_px) /
                              (count + kCornersOfAll);
      sd_px[i] = std::max(kLeastCornerSdPx, std::sqrt(variance));
    }
  }

  void finish() {
    const Equations equations = gather();
    const Eigen::MatrixXd covariance =
        equations.matrix().ldlt().solve(Eigen::MatrixXd::Identity(size(), kWallBehind));
    const Eigen::VectorXd sd = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    result_.color_sd = result_.color;
    result_.depth_sd = result_.depth;
    internal::set_lens(sd.segment<kLensSize>(kColorLens), result_.color_sd);
    internal::set_lens(sd.segment<kLensSize>(kDepthLens), result_.depth_sd);
    result_.turn_sd_rad = sd.segment<3>(kRigTurn);
    result_.shift_sd_mm = sd.segment<3>(kRigShift);
    result_.color_rms_px = std::numbers::sqrt2 * root_mean_square(joined(color_off_px_));
    result_.infrared_rms_px = std::numbers::sqrt2 * root_mean_square(joined(infrared_off_px_));
    result_.correction = model_.correction(correction_);
  }

  const CalibrationBoard& board_;
  const std::vector<JointView>& views_;
  const RgbdCalibration& start_;
  const JointOptions& options_;
  const DepthModel model_;
  const Eigen::Vector3d middle_mm_;
  JointCalibration result_;
  Eigen::VectorXd correction_;
  std::vector<std::vector<double>> color_off_px_;  ///< View by view.
  std::vector<std::vector<double>> infrared_off_px_;
  std::vector<double> depth_off_sds_;
  std::vector<double> color_sd_px_;
  std::vector<double> infrared_sd_px_;
  double depth_sd_ = kFirstDepthSd;
};

}  // namespace

JointCalibration calibrate_jointly(const CalibrationBoard& board,
                                   const std::vector<JointView>& views,
                                   const RgbdCalibration& start,
                                   const JointOptions& options) {
  return Joint(board, views, start, options).run();
}

ReadingErrors reading_errors(const CalibrationBoard& board,
                             const JointCalibration& calibration,
                             std::size_t view,
                             const std::vector<DepthReading>& readings,
                             const Eigen::Vector2d& infrared_offset_px) {
  const PinholeCamera lens = lens_of_depth_picture(calibration, infrared_offset_px);
  std::vector<double> before_mm;
  std::vector<double> after_mm;
  for (const auto& reading : readings) {
    const Surface surface(
        calibration, calibration.depth_from_board[view], middle_of(board), reading.is_beside);
    const double true_mm =
        internal::meet(lens.ray(reading.px), surface.normal, surface.on_plane).z_mm;
    before_mm.push_back(reading.seen_mm - true_mm);
    after_mm.push_back(
        before_mm.back() +
        calibration.correction.add_mm(reading.px, lens.width_px, lens.height_px, reading.seen_mm));
  }
  return {root_mean_square(before_mm), root_mean_square(after_mm)};
}

}  // namespace mor
