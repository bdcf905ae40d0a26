// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "morgagni/calibration/calibration_store.h"
#include "morgagni/calibration/self_calibration.h"
#include "morgagni/calibration/view_gatherer.h"
#include "morgagni/casefile/case.h"
#include "morgagni/core/latest_slot.h"
#include "morgagni/tracking/tracker.h"

namespace mor {

enum class SelfCalibratorPhase : std::uint8_t {
  kGathering,   ///< Views are kept while the tracking is good.
  kEstimating,  ///< There are enough; what they say is being worked out.
  kProposed,    ///< A correction waits for a yes or a no.
  kResting,     ///< Nothing goes on until look_again().
};

/// "gathering", "estimating", "proposed", "resting".
[[nodiscard]] std::string_view to_string(SelfCalibratorPhase phase);

/// A correction that is in use.
struct AppliedCorrection {
  std::string origin;           ///< Of the calibration in use now.
  bool corrects_sensor = true;  ///< What it is of: one at least.
  bool follows_skin = false;
  double shift_mm = 0.0;      ///< By which all of it moved the poses, as SelfCalibration has it.
  double remaining_mm = 0.0;  ///< SelfCalibration::left_mm().
  double skin_most_mm = 0.0;  ///< How far the skin lay off, where it is followed.
  double bias_mm = 0.0;       ///< What is not known of the depth then, for the error bound.
  std::string kept_in;        ///< File of the store. Empty: for this session alone.
};

struct SelfCalibratorStatus {
  SelfCalibratorPhase phase = SelfCalibratorPhase::kGathering;
  int num_views = 0;
  int wanted_views = 0;
  MotionCoverage coverage;
  std::optional<SelfCalibration> found;      ///< Of the last estimate. None: none yet.
  std::optional<AppliedCorrection> applied;  ///< The newest one.
  std::string device_id;                     ///< Empty: what is applied cannot be kept.
  std::string problem;   ///< Why something could not be done, in a sentence. Empty: nothing.
  double view_ms = 0.0;  ///< Processor time of the newest view,
  double found_s = 0.0;  ///< and of the last estimate.
};

struct SelfCalibratorOptions {
  int num_views = 60;  ///< That an estimate is made of. 20..200.
  SelfCalibrationOptions estimate;
  int niceness = 19;  ///< Of its thread: everything else goes first. 0..19.
};

/// The calibration that frames are tracked under and the skin that they are registered to, and how
/// both are changed: LiveLoop's.
struct CalibrationInUse {
  std::function<std::shared_ptr<const RgbdCalibration>()> get;
  std::function<std::shared_ptr<const FixedSurface>()> skin;  ///< To which they are registered.
  /// @param sensor_bias_mm  As LiveLoop::use_calibration().
  std::function<Result<void>(std::shared_ptr<const RgbdCalibration>,
                             std::shared_ptr<const FixedSurface> skin,
                             double sensor_bias_mm)>
      use;
  std::function<void(double sensor_bias_mm)> expect_bias;  ///< LiveLoop::expect_bias().
};

/// Finds the depth camera's systematic error and how the skin has changed since the CT while a body
/// is tracked, in a thread of its own at the lowest priority, and removes the one and follows the
/// other when it is told to (docs/self-calibration.md). What it looks at is what tracking sees:
/// corrected, where a correction is in use, so it checks its own.
/// @threads Any.
class SelfCalibrator {
 public:
  /// Says why the calibration may not change now. Empty: it may.
  using Hindrance = std::function<std::string()>;

  /// @param device_id  RangeCamera::device_id(), for the store.
  SelfCalibrator(std::shared_ptr<const Case> body,
                 CalibrationInUse in_use,
                 std::string device_id,
                 CalibrationStore store = CalibrationStore(),
                 Hindrance hindrance = {},
                 SelfCalibratorOptions options = {});
  ~SelfCalibrator();

  /// LiveLoop::Observe. Never waits.
  void look(const TrackedFrame& tracked);

  /// Uses what is proposed from the next frame on; gathering begins anew, to check it. The sensor's
  /// correction is kept for the device, and that it could not be is said in the status. The skin as
  /// found is this session's: a body goes on changing.
  /// @errors kInvalidArgument: nothing is proposed, or something is in the way.
  [[nodiscard]] Result<void> apply();
  /// No to the proposal. The sensor is no better for that: the error bound stays as wide as while
  /// it waited, until look_again(). @errors kInvalidArgument: there is none.
  [[nodiscard]] Result<void> discard();
  /// Back to the calibration before the newest apply(); what that kept is taken back.
  /// @errors kInvalidArgument: nothing was applied, or something is in the way.
  [[nodiscard]] Result<void> undo();
  /// Forgets the views and begins anew.
  void look_again();

  [[nodiscard]] SelfCalibratorStatus status() const;

 private:
  struct View {
    std::shared_ptr<const RgbdFrame> frame;
    Eigen::Isometry3d ct_from_depth;
    std::shared_ptr<const FixedSurface> fixed;
  };
  /// What apply() replaced.
  struct Replaced {
    std::shared_ptr<const RgbdCalibration> calibration;
    std::shared_ptr<const FixedSurface> skin;
    AppliedCorrection by;
    double bias_before_mm = 0.0;  ///< What was known to be off without it.
  };

  void run(std::stop_token stop);
  void add(const View& view);
  void estimate(std::stop_token stop);
  void take(const SelfCalibration& found, std::shared_ptr<const FixedSurface> skin);
  [[nodiscard]] Result<std::shared_ptr<const FixedSurface>> followed_skin(
      const SelfCalibration& found) const;
  void begin_anew();
  void tell_bias();
  void rest_or_begin(SelfCalibratorPhase phase);
  [[nodiscard]] Result<void> check_hindrance() const;
  [[nodiscard]] KeptCalibration to_keep(const SelfCalibration& found,
                                        const RgbdCalibration& in_use) const;
  void keep(const KeptCalibration& made, AppliedCorrection& applied);

  const std::shared_ptr<const Case> body_;
  const CalibrationInUse in_use_;
  const std::string device_id_;
  const CalibrationStore store_;
  const Hindrance hindrance_;
  const SelfCalibratorOptions options_;

  std::mutex command_mutex_;        ///< Held through apply() and undo(): one at a time.
  std::vector<Replaced> replaced_;  ///< Guarded by it.

  LatestSlot<std::optional<View>> slot_;  ///< An empty one wakes the thread.
  std::atomic<bool> wants_views_ = true;

  /// Guards everything down to the next blank line, for moments only: the tracking must not wait
  /// for a thread that hardly runs.
  mutable std::mutex mutex_;
  SelfCalibratorStatus status_;
  ViewPace pace_;
  bool wants_anew_ = false;
  std::shared_ptr<const FixedSurface> found_skin_;  ///< That is proposed to be followed.
  std::stop_source estimating_;

  std::optional<ViewGatherer> gatherer_;  ///< Of the thread alone, as the next four.
  std::shared_ptr<const RgbdCalibration> gathered_with_;
  std::shared_ptr<const FixedSurface> gathered_on_;
  DepthLevels levels_;     ///< Of the pictures looked at; a correction hides them.
  int num_estimates_ = 0;  ///< Of these views and those that were dropped for them.
  std::jthread thread_;
};

}  // namespace mor
