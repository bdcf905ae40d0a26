// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/live_loop.h"

#include <condition_variable>
#include <utility>

#include "morgagni/core/log.h"
#include "morgagni/core/printable_text.h"
#include "morgagni/session/depth_pick.h"

namespace mor {
namespace {

constexpr std::size_t kTimedFrames = 60;
constexpr std::chrono::milliseconds kCameraRetry{500};

}  // namespace

Result<std::unique_ptr<LiveLoop>> LiveLoop::create(std::shared_ptr<const Case> body,
                                                   std::unique_ptr<RangeCamera> camera,
                                                   const LiveLoopOptions& options) {
  MOR_TRY(auto tracking, LiveTracking::create(body, camera->calibration(), options));
  return std::unique_ptr<LiveLoop>(
      new LiveLoop(std::move(body), std::move(camera), std::move(tracking), options.in_step));
}

LiveLoop::LiveLoop(std::shared_ptr<const Case> body,
                   std::unique_ptr<RangeCamera> camera,
                   std::unique_ptr<LiveTracking> tracking,
                   bool in_step)
    : camera_(std::move(camera)),
      in_step_(in_step),
      tracking_(std::move(tracking)),
      pictures_(std::move(body)),
      wait_ms_(kTimedFrames),
      depth_ms_(kTimedFrames),
      registration_ms_(kTimedFrames),
      judgement_ms_(kTimedFrames) {}

LiveLoop::~LiveLoop() = default;

void LiveLoop::observe(Observe observe) {
  const std::lock_guard lock(observers_mutex_);
  observers_.push_back(std::move(observe));
}

void LiveLoop::mark(Mark mark) {
  pictures_.mark(std::move(mark));
}

void LiveLoop::take_fused_from(FreePictures::Fused fused) {
  pictures_.take_fused_from(std::move(fused));
}

Result<void> LiveLoop::run(Show show) {
  MOR_CHECK(pictures_.run(std::move(show)));
  tracking_thread_ = std::jthread([this](std::stop_token stop) { track(stop); });
  if (!in_step_) capture_thread_ = std::jthread([this](std::stop_token stop) { capture(stop); });
  return {};
}

void LiveLoop::stop() {
  capture_thread_ = {};
  tracking_thread_ = {};
  pictures_.stop();
  tracking_->stop();
}

std::shared_ptr<const RgbdCalibration> LiveLoop::calibration() const {
  return tracking_->calibration();
}

std::shared_ptr<const FixedSurface> LiveLoop::skin() const {
  return tracking_->skin();
}

Result<void> LiveLoop::use_calibration(std::shared_ptr<const RgbdCalibration> calibration,
                                       std::shared_ptr<const FixedSurface> skin,
                                       double sensor_bias_mm) {
  return tracking_->use_calibration(std::move(calibration), std::move(skin), sensor_bias_mm);
}

void LiveLoop::expect_bias(double sensor_bias_mm) {
  tracking_->expect_bias(sensor_bias_mm);
}

void LiveLoop::start_automatically() {
  tracking_->start_automatically();
  pictures_.end_landmarks();
}

Result<void> LiveLoop::start_by_placement(const PlacementOptions& options) {
  MOR_CHECK(tracking_->start_by_placement(options));
  pictures_.end_landmarks();
  return {};
}

Result<void> LiveLoop::begin_landmarks() {
  return pictures_.begin_landmarks();
}

Result<Eigen::Vector3d> LiveLoop::pick_landmark(const Eigen::Vector2d& color_pixel) {
  MOR_TRY(const auto frame, pictures_.landmark_frame());
  const auto point = depth_point_at(*frame, color_pixel);
  if (!point) {
    return make_error(ErrorCode::kInvalidArgument,
                      "the camera has no depth at this point: tap another one nearby");
  }
  return *point;
}

Result<void> LiveLoop::accept_landmarks(const std::vector<LandmarkPair>& pairs) {
  MOR_TRY(const auto frame, pictures_.landmark_frame());
  MOR_TRY(const auto start, start_from_landmarks(pairs));
  MOR_CHECK(tracking_->start_at(frame, start.ct_from_depth));
  pictures_.end_landmarks();
  return {};
}

void LiveLoop::cancel_landmarks() {
  pictures_.end_landmarks();
}

Result<TouchedPoint> LiveLoop::touch(const Eigen::Vector2d& pixel) {
  return pictures_.touch(pixel);
}

void LiveLoop::set_frozen(bool frozen) {
  pictures_.set_frozen(frozen);
}

ViewSettings LiveLoop::view() const {
  return pictures_.view();
}

void LiveLoop::set_view(const ViewSettings& view) {
  pictures_.set_view(view);
}

std::optional<Snapshot> LiveLoop::snapshot() const {
  return pictures_.snapshot();
}

LiveStatus LiveLoop::status() const {
  auto pictures = pictures_.state();
  const Eigen::Vector2d hole = pictures_.view().hole.center.cast<double>();
  const auto bound_mm = bound_at_mm(pictures.last, hole);
  const std::lock_guard lock(mutex_);
  return {.last = std::move(pictures.last),
          .frozen = pictures.frozen,
          .picking_landmarks = pictures.picking_landmarks,
          .search = tracking_->search_status(),
          .bound_mm = bound_mm,
          .colors_age_ms = pictures_.colors_age_ms(),
          .frame_rate = pictures.frame_rate,
          .num_dropped = captured_.num_dropped() + pictures.num_dropped,
          .wait_ms = wait_ms_.median(),
          .depth_ms = depth_ms_.median(),
          .registration_ms = registration_ms_.median(),
          .judgement_ms = judgement_ms_.median(),
          .render_ms = pictures.render_ms,
          .camera_error = camera_error_};
}

void LiveLoop::set_camera_error(std::optional<std::string> sentence) {
  const std::lock_guard lock(mutex_);
  if (sentence) sentence = printable_text(*sentence);
  if (sentence && sentence != camera_error_) log::warn("{}", *sentence);
  camera_error_ = std::move(sentence);
}

/// The camera's next frame; none at the end of the recording or of the session.
LiveLoop::FramePtr LiveLoop::next_frame(std::stop_token stop) {
  while (!stop.stop_requested()) {
    auto frame = camera_->next_frame(stop);
    if (!frame) {
      set_camera_error("the camera gives no picture: " + frame.error().message);
      std::unique_lock lock(retry_mutex_);
      std::condition_variable_any().wait_for(lock, stop, kCameraRetry, [] { return false; });
      continue;
    }
    if (*frame) {
      set_camera_error(std::nullopt);
    } else if (!stop.stop_requested()) {
      set_camera_error("the recording has ended");
    }
    return *std::move(frame);
  }
  return nullptr;
}

void LiveLoop::capture(std::stop_token stop) {
  while (auto frame = next_frame(stop)) captured_.put(std::move(frame));
}

void LiveLoop::track(std::stop_token stop) {
  const auto next = [&] {
    return in_step_ ? next_frame(stop) : captured_.take(stop).value_or(nullptr);
  };
  while (auto frame = next()) {
    // In step, a frame comes when it is asked for: its own time is the recording's.
    const auto came_at = in_step_ ? Clock::now() : frame->captured_at;
    const std::chrono::duration<double, std::milli> waited = Clock::now() - came_at;
    auto tracked = tracking_->follow(std::move(frame));
    if (!tracked) {
      set_camera_error("a picture of the camera cannot be used: " + tracked.error().message);
      continue;
    }
    count_times(*tracked, waited.count());
    tell_observers(*tracked);
    pictures_.put(*std::move(tracked), came_at);
  }
}

void LiveLoop::count_times(const TrackedFrame& tracked, double wait_ms) {
  const std::lock_guard lock(mutex_);
  wait_ms_.add(wait_ms);
  depth_ms_.add(tracked.depth_ms);
  judgement_ms_.add(tracked.judgement_ms);
  if (tracked.registration) registration_ms_.add(tracked.registration_ms);
}

void LiveLoop::tell_observers(const TrackedFrame& tracked) {
  const std::lock_guard lock(observers_mutex_);
  for (const Observe& observe : observers_) observe(tracked);
}

}  // namespace mor
