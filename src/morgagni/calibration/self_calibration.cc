// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/self_calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <spdlog/fmt/fmt.h>

#include "morgagni/calibration/internal/bundle.h"
#include "morgagni/calibration/internal/evidence.h"
#include "morgagni/calibration/internal/view_models.h"
#include "morgagni/core/statistics.h"

namespace mor {
namespace {

using internal::Bundle;
using internal::BundleModel;
using internal::BundleStart;
using internal::BundleState;
using internal::SensorModel;
using internal::SkinModel;

constexpr std::size_t kLeastViews = 20;
/// Sensors' errors are this much of what SensorPrior allows, before anything was seen; known as
/// well as from so many values.
constexpr double kUsualSizeRatio = 0.7;
constexpr double kUsualSizeValues = 6.0;
/// A skin is taken to have changed by no less.
constexpr double kLeastFoundMm = 0.1;
/// Expectations are drawn anew so often.
constexpr int kPasses = 3;

/// One model's fit to all views, with the expectations drawn where it ended.
struct ModelFit {
  BundleModel model;
  BundleState state;
  std::vector<Bundle::View> views;
};

class Estimation {
 public:
  Estimation(const TriangleMesh& skin,
             const RgbdCalibration& calibration,
             const std::vector<SensedSkin>& views,
             const SelfCalibrationOptions& options,
             std::stop_token stop)
      : views_(views),
        depth_(calibration.depth),
        knows_pinhole_(calibration.depth_sd.has_value()),
        options_(options),
        stop_(std::move(stop)),
        models_(skin, depth_, views, options),
        sensor_(models_.sensor()),
        skin_(models_.skin()) {}

  [[nodiscard]] SelfCalibration run() {
    SelfCalibration result;
    result.num_views = static_cast<int>(views_.size());
    result.num_parameters = static_cast<int>(sensor_.size());
    result.sees_table = models_.has_table();
    result.depth = depth_;
    if (views_.size() < 5) return result;
    ModelFit both{BundleModel::kSensorAndSkin, models_.start(), {}};
    fit(both, kPasses);
    if (stop_.stop_requested()) return result;
    const auto scatter = models_.scatter_of(both.views, both.state);
    models_.weigh_by(scatter, both.views);
    fit(both, 1);
    const Eigen::MatrixXd at_first = models_.sensor_prior();
    models_.learn_priors(information_of(both), both.state);
    fit(both, 1);
    if (stop_.stop_requested()) return result;
    describe(both.state, result);
    add_skin(both, result);
    add_uncertainty(information_of(both), both.state, at_first, result);
    if (views_.size() < kLeastViews) return result;
    ModelFit skin{BundleModel::kSkin, models_.start(), {}};
    fit(skin, kPasses);
    result.held_out = hold_out(skin, both);
    result.verdict = internal::judge_sensor(result, options_);
    // Where the sensor is left as it is, so is what was found of the skin along with it.
    const bool is_skin_alone = internal::speaks_for_skin_alone(result);
    if (is_skin_alone) add_skin(skin, result);
    if (is_skin_alone || result.corrects_sensor()) internal::judge_skin(options_, result);
    return result;
  }

 private:
  /// Draws the expectations where the state is and fits to them, so many times.
  void fit(ModelFit& fitted, int num_passes) const {
    for (int pass = 0; pass < num_passes && !stop_.stop_requested(); ++pass) {
      fitted.views = models_.expected(fitted.state);
      const Bundle bundle = models_.bundle(fitted.views);
      const auto start = pass == 0 ? BundleStart::kAnew : BundleStart::kNear;
      bundle.fit(all_views(), fitted.model, start, fitted.state);
    }
  }

  [[nodiscard]] std::vector<std::size_t> all_views() const {
    std::vector<std::size_t> all(views_.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    return all;
  }

  void describe(const BundleState& state, SelfCalibration& result) const {
    const auto nodes = static_cast<Eigen::Index>(sensor_.num_nodes());
    const double* values = state.values.data();
    auto& correction = result.correction;
    correction.columns = sensor_.columns();
    correction.rows = sensor_.rows();
    correction.control.clear();
    for (Eigen::Index i = 0; i < nodes; ++i) {
      const double growing_mm = values[i];
      const double fixed_mm = values[nodes + i];
      correction.control.push_back(
          {-fixed_mm, (growing_mm + fixed_mm) / SensorModel::kReferenceMm, 0.0});
    }
    set_range(correction);
    const double* pinhole = values + 2 * nodes;
    result.focal_x_ratio = pinhole[0];
    result.focal_y_ratio = pinhole[1];
    result.depth = models_.camera_of(state);
    result.center_px = {result.depth.center_x_px - depth_.center_x_px,
                        result.depth.center_y_px - depth_.center_y_px};
  }

  /// It holds where the skin was seen, and a little beyond.
  void set_range(DepthCorrection& correction) const {
    constexpr double kBeyondMm = 100.0;
    double near_mm = correction.far_mm;
    double far_mm = correction.near_mm;
    for (const auto& view : views_) {
      for (const auto& reading : view.readings) {
        near_mm = std::min(near_mm, static_cast<double>(reading.z_mm));
        far_mm = std::max(far_mm, static_cast<double>(reading.z_mm));
      }
    }
    if (!(near_mm < far_mm)) return;
    correction.near_mm = std::max(1.0, near_mm - kBeyondMm);
    correction.far_mm = far_mm + kBeyondMm;
  }

  /// The most likely skin between and beyond the control points, given their values.
  [[nodiscard]] SkinChange skin_change(const BundleState& state) const {
    const auto size = static_cast<Eigen::Index>(skin_.size());
    const auto sensor = static_cast<Eigen::Index>(sensor_.size());
    const double sd_mm = models_.priors().skin_mm;
    const Eigen::VectorXd weights = sd_mm * sd_mm *
                                    models_.prior_precision().block(sensor, sensor, size, size) *
                                    state.values.segment(sensor, size);
    return {skin_.places_mm(), {weights.begin(), weights.end()}, options_.skin_reach_mm};
  }

  /// Where it was seen.
  [[nodiscard]] std::vector<double> skin_changes_mm(const BundleState& state) const {
    std::array<std::uint16_t, SkinModel::kNumTouched> index{};
    std::array<float, SkinModel::kNumTouched> share{};
    std::vector<double> changes_mm;
    for (const auto& place : models_.seen_mm()) {
      if (!skin_.weights(place, index, share)) continue;
      double value = 0.0;
      for (std::size_t i = 0; i < index.size(); ++i) {
        value += static_cast<double>(share[i]) *
                 state.values[static_cast<Eigen::Index>(sensor_.size() + index[i])];
      }
      changes_mm.push_back(std::abs(value));
    }
    return changes_mm;
  }

  [[nodiscard]] internal::BundleInformation information_of(const ModelFit& fitted) const {
    return models_.bundle(fitted.views).information(all_views(), fitted.state);
  }

  /// The skin as a fit has it, how far following it moves the poses found without it, and how much
  /// of that stays unknown: what looks like a pose, as large as the change is elsewhere.
  void add_skin(const ModelFit& fitted, SelfCalibration& result) const {
    auto changes_mm = skin_changes_mm(fitted.state);
    if (changes_mm.empty()) return;
    result.skin = skin_change(fitted.state);
    result.skin_rms_mm = root_mean_square(changes_mm);
    result.skin_most_mm = quantile(std::move(changes_mm), 0.99);
    const auto sensor = static_cast<Eigen::Index>(sensor_.size());
    const auto size = static_cast<Eigen::Index>(skin_.size());
    const auto information = information_of(fitted);
    const auto form = displacement_form(information.pivot_mm);
    const Eigen::MatrixXd precision = information.matrix + models_.prior_precision();
    const Eigen::Index rest = precision.rows() - sensor;
    const Eigen::MatrixXd posterior =
        internal::inverse_of(precision.bottomRightCorner(rest, rest)).topLeftCorner(size, size);
    const Eigen::VectorXd values = fitted.state.values.segment(sensor, size);
    double shift_sq = 0.0;
    double remaining_sq = 0.0;
    for (const auto& follows : information.pose_from_values) {
      const Eigen::MatrixXd of_skin = follows.middleCols(sensor, size);
      const Eigen::Matrix<double, 6, 1> move = of_skin * values;
      shift_sq += move.dot(form * move);
      remaining_sq += (form * (of_skin * posterior * of_skin.transpose())).trace();
    }
    const auto count = static_cast<double>(information.pose_from_values.size());
    result.skin_shift_mm = std::sqrt(shift_sq / count);
    result.skin_remaining_mm =
        result.skin_rms_mm / models_.priors().skin_mm * std::sqrt(remaining_sq / count);
  }

  /// Mean over places on the skin of J^T J: a small motion's mean square displacement.
  [[nodiscard]] Eigen::Matrix<double, 6, 6> displacement_form(const Eigen::Vector3d& pivot) const {
    Eigen::Matrix<double, 6, 6> form = Eigen::Matrix<double, 6, 6>::Zero();
    constexpr std::size_t kPlaces = 500;
    const std::size_t step = std::max<std::size_t>(1, models_.seen_mm().size() / kPlaces);
    std::size_t count = 0;
    for (std::size_t i = 0; i < models_.seen_mm().size(); i += step, ++count) {
      const Eigen::Vector3d arm = models_.seen_mm()[i] - pivot;
      Eigen::Matrix<double, 3, 6> jacobian;
      jacobian << 0.0, arm.z(), -arm.y(), 1.0, 0.0, 0.0,  //
          -arm.z(), 0.0, arm.x(), 0.0, 1.0, 0.0,          //
          arm.y(), -arm.x(), 0.0, 0.0, 0.0, 1.0;
      form += jacobian.transpose() * jacobian;
    }
    return form / static_cast<double>(std::max<std::size_t>(1, count));
  }

  /// @param at_first  Covariance of the sensor's values before any view was seen.
  /// @pre add_skin().
  void add_uncertainty(const internal::BundleInformation& information,
                       const BundleState& state,
                       const Eigen::MatrixXd& at_first,
                       SelfCalibration& result) const {
    const auto sensor = static_cast<Eigen::Index>(sensor_.size());
    const Eigen::MatrixXd posterior =
        internal::inverse_of(information.matrix + models_.prior_precision());
    const Eigen::VectorXd values = state.values.head(sensor);
    const auto seen = what_was_seen(posterior.topLeftCorner(sensor, sensor), values);
    result.num_open = seen.num_open;
    result.size_ratio = seen.size_ratio;
    const auto num_seen = static_cast<double>(sensor - seen.num_open);
    const double size_sq = (kUsualSizeValues * kUsualSizeRatio * kUsualSizeRatio +
                            num_seen * seen.size_ratio * seen.size_ratio) /
                           (kUsualSizeValues + num_seen);
    // The same of a sensor whose errors are as large as this one's.
    Eigen::MatrixXd sized_prior = models_.prior_precision();
    const auto sized =
        sensor - (knows_pinhole_ ? static_cast<Eigen::Index>(SensorModel::kNumPinhole) : 0);
    sized_prior.topLeftCorner(sized, sized) /= size_sq;
    const Eigen::MatrixXd sized_posterior = internal::inverse_of(information.matrix + sized_prior);
    // Whether the camera has moved enough is asked of a skin that has changed as it was found to:
    // the prior's change is caution where it has changed more.
    Eigen::MatrixXd found_prior = models_.prior_precision();
    const double per_found = models_.priors().skin_mm / std::max(kLeastFoundMm, result.skin_rms_mm);
    const auto skin = static_cast<Eigen::Index>(skin_.size());
    found_prior.block(sensor, sensor, skin, skin) *= per_found * per_found;
    const Eigen::MatrixXd open = internal::inverse_of(information.matrix + found_prior);
    // How far the sensor's part of the values moves the poses found without it.
    const auto form = displacement_form(information.pivot_mm);
    double shift_sq = 0.0;
    double before_sq = 0.0;
    double open_sq = 0.0;
    double remaining_sq = 0.0;
    for (const auto& follows : information.pose_from_values) {
      const Eigen::MatrixXd of_sensor = follows.leftCols(sensor);
      const Eigen::Matrix<double, 6, 1> move = of_sensor * values;
      const auto spread_sq = [&](const Eigen::MatrixXd& covariance) {
        return (form *
                (of_sensor * (covariance.topLeftCorner(sensor, sensor) * of_sensor.transpose())))
            .trace();
      };
      shift_sq += move.dot(form * move);
      before_sq += spread_sq(at_first);
      open_sq += spread_sq(open);
      remaining_sq += spread_sq(sized_posterior);
    }
    const auto count =
        static_cast<double>(std::max<std::size_t>(1, information.pose_from_values.size()));
    result.shift_mm = std::sqrt(shift_sq / count);
    result.before_mm = std::sqrt(before_sq / count);
    result.open_share = std::sqrt(std::max(0.0, open_sq / std::max(1e-12, before_sq)));
    result.remaining_mm = std::sqrt(std::max(0.0, remaining_sq / count));
  }

  struct Seen {
    int num_open = 0;         ///< Directions in which the posterior keeps more than half the prior.
    double size_ratio = 1.0;  ///< Of the values found to what the prior expects, in the others.
  };

  [[nodiscard]] Seen what_was_seen(const Eigen::MatrixXd& posterior,
                                   const Eigen::VectorXd& values) const {
    const Eigen::LLT<Eigen::MatrixXd> prior(models_.sensor_prior());
    Eigen::MatrixXd white = prior.matrixL().solve(posterior);
    white = prior.matrixL().solve(white.transpose()).eval();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(white);
    const Eigen::VectorXd found = solver.eigenvectors().transpose() * prior.matrixL().solve(values);
    Seen seen;
    double squares = 0.0;
    for (Eigen::Index i = 0; i < found.size(); ++i) {
      const double left = solver.eigenvalues()[i];
      if (left > 0.5) {
        ++seen.num_open;
      } else {
        squares += found[i] * found[i] / (1.0 - left);
      }
    }
    const auto count = static_cast<double>(std::max<Eigen::Index>(1, found.size() - seen.num_open));
    seen.size_ratio = std::sqrt(squares / count);
    return seen;
  }

  [[nodiscard]] internal::HeldOutRest left_by(const ModelFit& fitted) const {
    internal::HeldOutRest left;
    for (int fold = 0; fold < options_.num_folds && !stop_.stop_requested(); ++fold) {
      std::vector<std::size_t> train;
      std::vector<std::size_t> test;
      for (std::size_t i = 0; i < views_.size(); ++i) {
        const bool is_held = static_cast<int>(i * static_cast<std::size_t>(options_.num_folds) /
                                              views_.size()) == fold;
        (is_held ? test : train).push_back(i);
      }
      left.folds.push_back(judge_views(fitted, train, test));
    }
    return left;
  }

  [[nodiscard]] HeldOutFit hold_out(const ModelFit& skin, const ModelFit& both) const {
    ModelFit as_it_is{BundleModel::kPoses, models_.start(), {}};
    ModelFit sensor{BundleModel::kSensor, models_.start(), {}};
    fit(as_it_is, kPasses);
    fit(sensor, kPasses);
    const auto left_as_it_is = left_by(as_it_is);
    const auto left_by_skin = left_by(skin);
    const auto left_by_sensor = left_by(sensor);
    const auto left_by_both = left_by(both);
    HeldOutFit held;
    held.num_folds = options_.num_folds;
    if (stop_.stop_requested()) return held;
    held.as_it_is_mm = left_as_it_is.mm();
    held.skin_mm = left_by_skin.mm();
    held.sensor_mm = left_by_sensor.mm();
    held.both_mm = left_by_both.mm();
    held.sensor = internal::gain_of(left_by_both, left_by_skin);
    held.skin = internal::gain_of(left_by_skin, left_as_it_is);
    held.skin_and_sensor = internal::gain_of(left_by_both, left_by_sensor);
    return held;
  }

  /// How well a model that was fitted to some views explains others, each at its best pose.
  [[nodiscard]] internal::ViewFit judge_views(const ModelFit& fitted,
                                              const std::vector<std::size_t>& train,
                                              const std::vector<std::size_t>& test) const {
    const Bundle bundle = models_.bundle(fitted.views);
    BundleState state = fitted.state;
    bundle.fit(train, fitted.model, BundleStart::kNear, state);
    internal::ViewFit sum;
    for (const std::size_t view : test) {
      bundle.fit_pose(view, state);
      const auto fit = bundle.judge(view, state);
      sum.sum_sq_mm2 += fit.sum_sq_mm2;
      sum.sum_weights += fit.sum_weights;
    }
    return sum;
  }

  const std::vector<SensedSkin>& views_;
  const PinholeCamera& depth_;
  bool knows_pinhole_;  ///< How exactly `depth_` is known was said, not taken from SensorPrior.
  const SelfCalibrationOptions& options_;
  std::stop_token stop_;  ///< Asked for between steps; what comes of them then is thrown away.
  internal::ViewModels models_;
  const SensorModel& sensor_;  ///< Of them.
  const SkinModel& skin_;
};

}  // namespace

std::string_view to_string(SelfCalibrationVerdict verdict) {
  switch (verdict) {
    case SelfCalibrationVerdict::kTooFewViews:
      return "too-few-views";
    case SelfCalibrationVerdict::kTooLittleMotion:
      return "too-little-motion";
    case SelfCalibrationVerdict::kOtherBody:
      return "other-body";
    case SelfCalibrationVerdict::kSkinChanged:
      return "skin-changed";
    case SelfCalibrationVerdict::kNoError:
      return "no-error";
    case SelfCalibrationVerdict::kSmall:
      return "small";
    case SelfCalibrationVerdict::kError:
      return "error";
  }
  return "too-few-views";
}

double SelfCalibration::now_mm() const {
  return std::hypot(corrects_sensor() ? std::hypot(shift_mm, remaining_mm) : 0.0,
                    follows_skin ? std::hypot(skin_shift_mm, skin_remaining_mm) : 0.0);
}

double SelfCalibration::left_mm() const {
  return std::hypot(corrects_sensor() ? remaining_mm : 0.0, follows_skin ? skin_remaining_mm : 0.0);
}

Result<void> SelfCalibrationOptions::check() const {
  const auto bad = [](std::string_view what, auto value) {
    return make_error(ErrorCode::kInvalidArgument, fmt::format("{}, got {}", what, value));
  };
  if (columns < 3 || columns > 40) return bad("columns must be in [3, 40]", columns);
  if (rows < 3 || rows > 40) return bad("rows must be in [3, 40]", rows);
  if (num_folds < 3 || num_folds > 20) return bad("num_folds must be in [3, 20]", num_folds);
  for (const double value : {prior.offset_mm,
                             prior.tilt_mm,
                             prior.shape_mm,
                             prior.shape_reach,
                             prior.not_growing_ratio,
                             prior.focal_difference_ratio,
                             prior.pinhole.focal_ratio,
                             prior.pinhole.center_px,
                             skin_mm,
                             skin_reach_mm}) {
    if (!(value > 0.0 && std::isfinite(value))) {
      return bad("each standard deviation and reach must be above 0", value);
    }
  }
  return {};
}

Result<SelfCalibration> estimate_self_calibration(const TriangleMesh& skin,
                                                  const RgbdCalibration& calibration,
                                                  const std::vector<SensedSkin>& views,
                                                  const SelfCalibrationOptions& options,
                                                  std::stop_token stop) {
  MOR_CHECK(options.check());
  MOR_CHECK(calibration.depth.check());
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto& view = views[i];
    if (!view.ct_from_depth.matrix().allFinite()) {
      return make_error(ErrorCode::kInvalidArgument,
                        fmt::format("view {} has a pose that is not finite", i));
    }
  }
  SelfCalibrationOptions known = options;
  known.prior.pinhole = calibration.depth_sd.value_or(options.prior.pinhole);
  auto found = Estimation(skin, calibration, views, known, stop).run();
  if (stop.stop_requested()) {
    return make_error(ErrorCode::kCancelled, "the self-calibration was stopped");
  }
  return found;
}

}  // namespace mor
