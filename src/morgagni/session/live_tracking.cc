// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/live_tracking.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "morgagni/camera/depth_correction.h"
#include "morgagni/core/log.h"

namespace mor {
namespace {

/// From one search's frame to the next one's at least: the camera has moved on by then.
constexpr std::chrono::milliseconds kSearchPause{200};

}  // namespace

Result<std::unique_ptr<LiveTracking>> LiveTracking::create(std::shared_ptr<const Case> body,
                                                           const RgbdCalibration& camera,
                                                           const LiveTrackingOptions& options) {
  MOR_TRY(auto extractor, BodySurfaceExtractor::create(camera.depth, options.depth));
  MOR_TRY(auto registration, make_fine_registration(body->skin, options.registration));
  MOR_TRY(
      auto tracker,
      Tracker::create(options.tracking, body->skin, std::move(extractor), std::move(registration)));
  MOR_TRY(auto automatic, AutomaticStart::create(body->skin, camera.depth, {}));
  auto tracking = std::unique_ptr<LiveTracking>(
      new LiveTracking(std::move(body),
                       camera,
                       std::move(tracker),
                       std::make_shared<const AutomaticStart>(std::move(automatic)),
                       options));
  if (options.start == StartMethod::kPlacement) {
    MOR_CHECK(tracking->start_by_placement(options.placement));
  }
  return tracking;
}

LiveTracking::LiveTracking(std::shared_ptr<const Case> body,
                           const RgbdCalibration& camera,
                           Tracker tracker,
                           std::shared_ptr<const AutomaticStart> automatic,
                           const LiveTrackingOptions& options)
    : body_(std::move(body)),
      camera_(std::make_shared<const RgbdCalibration>(camera)),
      depth_options_(options.depth),
      registration_options_(options.registration),
      sensor_bias_mm_(options.tracking.sensor_bias_mm),
      in_step_(options.in_step),
      tracker_(std::move(tracker)),
      find_(std::make_shared<const StartSearch::Find>(search_on(std::move(automatic)))),
      search_([this](const RgbdFrame& frame, std::stop_token stop) {
        return (*find_.load())(frame, std::move(stop));
      }),
      skin_(body_->skin) {}

Result<TrackedFrame> LiveTracking::follow(std::shared_ptr<const RgbdFrame> frame) {
  const std::lock_guard lock(tracker_mutex_);
  // Here alone a frame gets another calibration than its camera's, so none is tracked half under
  // one and half under another.
  if (calibration_) frame = with_calibration(*frame, calibration_);
  MOR_CHECK(tracker_.expect_bias(std::min(std::hypot(sensor_bias_mm_, told_bias_mm_.load()),
                                          TrackingOptions::kMostSensorBiasMm)));
  if (auto ended = search_.take()) offer(*ended);
  MOR_TRY(auto tracked, tracker_.process(std::move(frame)));
  if (tracked.needs_start) {
    look_for_start(tracked);
  } else {
    if (search_.is_searching()) search_.cancel();
    if (tracked.state == TrackingState::kTracking) forget_search();
  }
  const std::lock_guard status_lock(status_mutex_);
  search_status_.is_searching = search_.is_searching();
  return tracked;
}

void LiveTracking::look_for_start(const TrackedFrame& tracked) {
  const auto captured_at = tracked.frame->captured_at;
  const bool is_due = !last_searched_at_ || captured_at - *last_searched_at_ >= kSearchPause ||
                      captured_at < *last_searched_at_;
  if (!is_due) return;
  if (in_step_) {
    last_searched_at_ = captured_at;
    offer(search_.search(tracked.frame));
  } else if (search_.begin(tracked.frame)) {
    last_searched_at_ = captured_at;
  }
}

/// A pose that the search found is only offered: the tracker judges it on a frame of now before it
/// is shown.
void LiveTracking::offer(const Result<SearchedFrame>& ended) {
  if (!ended) {
    log::warn("the search for the body failed: {}", ended.error().message);
    return;
  }
  const auto& [frame, result] = *ended;
  if (result.status == AutomaticStartStatus::kFound) {
    tracker_.offer_start(*frame, result.ct_from_depth);
  }
  const std::lock_guard lock(status_mutex_);
  search_status_.last = result.status;
  search_status_.reason = result.reason;
}

Result<void> LiveTracking::check_size(const RgbdCalibration& calibration) const {
  MOR_CHECK(calibration.depth.check());
  const auto same = [](const PinholeCamera& a, const PinholeCamera& b) {
    return a.width_px == b.width_px && a.height_px == b.height_px;
  };
  if (same(camera_->depth, calibration.depth) && same(camera_->color, calibration.color)) return {};
  return make_error(ErrorCode::kInvalidArgument,
                    "the calibration is for pictures of another size than the camera's");
}

Result<void> LiveTracking::use_calibration(std::shared_ptr<const RgbdCalibration> calibration,
                                           std::shared_ptr<const FixedSurface> skin,
                                           double sensor_bias_mm) {
  MOR_CHECK(check_size(*calibration));
  if (calibration->depth_correction) MOR_CHECK(calibration->depth_correction->check());
  // What takes time is made before the tracking is held up.
  MOR_TRY(auto extractor, BodySurfaceExtractor::create(calibration->depth, depth_options_));
  MOR_TRY(auto automatic, AutomaticStart::create(skin, calibration->depth, {}));
  MOR_TRY(auto registration, make_fine_registration(skin, registration_options_));
  const std::lock_guard lock(tracker_mutex_);
  tracker_.use_camera(std::move(extractor));
  tracker_.use_skin(skin, std::move(registration));
  told_bias_mm_ = sensor_bias_mm;
  search_.cancel();
  find_ = std::make_shared<const StartSearch::Find>(
      search_on(std::make_shared<const AutomaticStart>(std::move(automatic))));
  const std::lock_guard status_lock(status_mutex_);
  calibration_ = std::move(calibration);
  skin_ = std::move(skin);
  return {};
}

std::shared_ptr<const RgbdCalibration> LiveTracking::calibration() const {
  const std::lock_guard lock(status_mutex_);
  return calibration_ ? calibration_ : camera_;
}

std::shared_ptr<const FixedSurface> LiveTracking::skin() const {
  const std::lock_guard lock(status_mutex_);
  return skin_;
}

void LiveTracking::start_automatically() {
  {
    const std::lock_guard lock(tracker_mutex_);
    search_.cancel();
    tracker_.wait_for_start();
    last_searched_at_.reset();
  }
  forget_search();
}

Result<void> LiveTracking::start_by_placement(const PlacementOptions& options) {
  MOR_TRY(const auto ct_from_depth, place_in_front_of_camera(body_->skin->mesh.bounds(), options));
  {
    const std::lock_guard lock(tracker_mutex_);
    search_.cancel();
    tracker_.start_by_placement(ct_from_depth);
  }
  forget_search();
  return {};
}

Result<void> LiveTracking::start_at(std::shared_ptr<const RgbdFrame> frame,
                                    const Eigen::Isometry3d& ct_from_depth) {
  {
    const std::lock_guard lock(tracker_mutex_);
    MOR_CHECK(tracker_.start_at(std::move(frame), ct_from_depth));
    search_.cancel();
  }
  forget_search();
  return {};
}

SearchStatus LiveTracking::search_status() const {
  const std::lock_guard lock(status_mutex_);
  return search_status_;
}

void LiveTracking::forget_search() {
  const std::lock_guard lock(status_mutex_);
  search_status_ = {};
}

}  // namespace mor
