// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "morgagni/camera/range_camera.h"
#include "morgagni/casefile/case.h"
#include "morgagni/core/result.h"
#include "morgagni/depth/body_surface.h"
#include "morgagni/registration/automatic_start.h"
#include "morgagni/registration/start.h"
#include "morgagni/session/start_search.h"
#include "morgagni/tracking/tracker.h"

namespace mor {

/// How the tracking begins, and begins again after a loss.
enum class StartMethod : std::uint8_t {
  kAutomatic,  ///< Searched for in the depth picture.
  kPlacement,  ///< The body hangs before the camera; the user moves the camera to it.
};

struct LiveTrackingOptions {
  BodySurfaceOptions depth = {.far_mm = kHandHeldFarMm};
  RegistrationOptions registration;
  TrackingOptions tracking;
  StartMethod start = StartMethod::kAutomatic;
  PlacementOptions placement;
  /// A search is waited for: a recording gives the same poses each time. Else it goes on beside
  /// the tracking.
  bool in_step = false;
};

/// What the search for a start says, for the page.
struct SearchStatus {
  bool is_searching = false;
  std::optional<AutomaticStartStatus> last;  ///< Of the last search that ended. None: none yet.
  std::string reason;                        ///< Why it found no start, in words.
};

/// Follows the body from frame to frame, and searches for it where the tracking needs a start.
/// @threads follow() on one thread, the others on any.
class LiveTracking {
 public:
  /// @param camera  The camera's own calibration.
  /// @errors As the stages' own.
  [[nodiscard]] static Result<std::unique_ptr<LiveTracking>> create(
      std::shared_ptr<const Case> body,
      const RgbdCalibration& camera,
      const LiveTrackingOptions& options);

  /// The frame's pose and what it is worth. @errors As Tracker::process.
  [[nodiscard]] Result<TrackedFrame> follow(std::shared_ptr<const RgbdFrame> frame);

  /// As LiveLoop::use_calibration.
  [[nodiscard]] Result<void> use_calibration(std::shared_ptr<const RgbdCalibration> calibration,
                                             std::shared_ptr<const FixedSurface> skin,
                                             double sensor_bias_mm);
  /// As LiveLoop::expect_bias.
  void expect_bias(double sensor_bias_mm) { told_bias_mm_ = sensor_bias_mm; }
  /// Under which the frames are tracked.
  [[nodiscard]] std::shared_ptr<const RgbdCalibration> calibration() const;
  /// To which they are registered: the CT's, or as it was found to be.
  [[nodiscard]] std::shared_ptr<const FixedSurface> skin() const;

  /// Searches for the body in the depth picture, from now on and after each loss.
  void start_automatically();
  /// Looks for the body where it is placed. @errors kInvalidArgument: bad options.
  [[nodiscard]] Result<void> start_by_placement(const PlacementOptions& options);
  /// Starts from a pose on this frame. @errors As Tracker::start_at.
  [[nodiscard]] Result<void> start_at(std::shared_ptr<const RgbdFrame> frame,
                                      const Eigen::Isometry3d& ct_from_depth);

  [[nodiscard]] SearchStatus search_status() const;

  /// Gives up a search that goes on.
  void stop() { search_.cancel(); }

 private:
  using Clock = std::chrono::steady_clock;

  LiveTracking(std::shared_ptr<const Case> body,
               const RgbdCalibration& camera,
               Tracker tracker,
               std::shared_ptr<const AutomaticStart> automatic,
               const LiveTrackingOptions& options);

  [[nodiscard]] Result<void> check_size(const RgbdCalibration& calibration) const;
  void look_for_start(const TrackedFrame& tracked);
  void offer(const Result<SearchedFrame>& ended);
  void forget_search();

  const std::shared_ptr<const Case> body_;
  const std::shared_ptr<const RgbdCalibration> camera_;
  const BodySurfaceOptions depth_options_;
  const RegistrationOptions registration_options_;
  const double sensor_bias_mm_;
  std::atomic<double> told_bias_mm_ = 0.0;  ///< On top of it.
  const bool in_step_;

  std::mutex tracker_mutex_;  ///< Guards the tracker and what it is started from.
  Tracker tracker_;
  std::atomic<std::shared_ptr<const StartSearch::Find>> find_;
  std::optional<Clock::time_point> last_searched_at_;  ///< When that frame was captured.
  StartSearch search_;

  mutable std::mutex status_mutex_;
  /// Written under both mutexes, so either one reads it. None: the camera's own.
  std::shared_ptr<const RgbdCalibration> calibration_;
  std::shared_ptr<const FixedSurface> skin_;  ///< The same.
  SearchStatus search_status_;
};

}  // namespace mor
