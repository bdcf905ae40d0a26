// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/tracking/tracker.h"

#include <utility>

#include <spdlog/fmt/fmt.h>

namespace mor {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Fewer points say nothing about a pose: the camera looks past the body, or is covered.
constexpr std::size_t kMinPoints = 200;

bool has_pose(const RegistrationResult& result) {
  return result.status == RegistrationStatus::kConverged ||
         result.status == RegistrationStatus::kMaxIterations;
}

}  // namespace

std::string_view to_string(TrackingState state) {
  switch (state) {
    case TrackingState::kWaiting:
      return "waiting";
    case TrackingState::kTracking:
      return "tracking";
    case TrackingState::kSkipped:
      return "skipped";
    case TrackingState::kLost:
      return "lost";
  }
  return "waiting";
}

Result<void> TrackingOptions::check() const {
  const auto refuse = [](std::string_view name, std::string_view range, double value) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{} must be {}, got {}", name, range, value));
  };
  if (!(residual_ratio > 1.0)) return refuse("residual_ratio", "above 1", residual_ratio);
  if (lost_after.count() <= 0) {
    return refuse("lost_after", "above 0 ms", static_cast<double>(lost_after.count()));
  }
  if (!(start_max_rms_mm > 0.0)) return refuse("start_max_rms_mm", "above 0", start_max_rms_mm);
  if (!(start_min_explained > 0.0 && start_min_explained <= 1.0)) {
    return refuse("start_min_explained", "in (0, 1]", start_min_explained);
  }
  return {};
}

Result<Tracker> Tracker::create(const TrackingOptions& options,
                                BodySurfaceExtractor extractor,
                                std::unique_ptr<FineRegistration> registration) {
  MOR_CHECK(options.check());
  return Tracker(options, std::move(extractor), std::move(registration));
}

Tracker::Tracker(const TrackingOptions& options,
                 BodySurfaceExtractor extractor,
                 std::unique_ptr<FineRegistration> registration)
    : options_(options), extractor_(std::move(extractor)), registration_(std::move(registration)) {}

void Tracker::start_by_placement(const Eigen::Isometry3d& ct_from_depth) {
  ct_from_ghost_ = ct_from_depth;
  last_valid_ct_from_depth_.reset();
  state_ = TrackingState::kWaiting;
}

Result<void> Tracker::start_at(const RgbdFrame& frame, const Eigen::Isometry3d& ct_from_depth) {
  MOR_TRY(const auto surface, extractor_.extract(frame.depth_mm.view()));
  MOR_TRY(const auto result,
          registration_->align(surface.cloud, ct_from_depth, StartQuality::kRough));
  if (!is_a_start(result)) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("the body does not fit at this start: {:.0f} % of what the camera sees lies on "
                    "the CT skin ({:.0f} % are needed), residual {:.1f} mm (limit {:.1f} mm)",
                    100.0 * result.explained_fraction,
                    100.0 * options_.start_min_explained,
                    result.rms_distance_mm,
                    options_.start_max_rms_mm));
  }
  begin(result, frame.captured_at);
  return {};
}

Result<TrackedFrame> Tracker::process(std::shared_ptr<const RgbdFrame> frame) {
  TrackedFrame tracked;
  const auto depth_started = Clock::now();
  MOR_TRY(const auto surface, extractor_.extract(frame->depth_mm.view()));
  tracked.depth_ms = ms_since(depth_started);

  const auto& init = ct_from_ghost_ ? ct_from_ghost_ : last_valid_ct_from_depth_;
  if (init) {
    RegistrationResult result{.status = RegistrationStatus::kTooFewPairs};
    const auto registration_started = Clock::now();
    if (surface.cloud.size() >= kMinPoints) {
      // After a frame without a pose the camera may have moved on: look further around.
      const auto start =
          state_ == TrackingState::kTracking ? StartQuality::kTracked : StartQuality::kRough;
      MOR_TRY(result, registration_->align(surface.cloud, *init, start));
    }
    tracked.registration_ms = ms_since(registration_started);
    judge(result, frame->captured_at);
    tracked.registration = result;
  }

  tracked.state = state_;
  tracked.ct_from_ghost = ct_from_ghost_;
  if (last_valid_ct_from_depth_) {
    tracked.valid_rms_mm = valid_rms_mm_;
    if (state_ != TrackingState::kLost) tracked.ct_from_depth = last_valid_ct_from_depth_;
  }
  tracked.counts = counts_;
  tracked.frame = std::move(frame);
  return tracked;
}

bool Tracker::is_a_start(const RegistrationResult& result) const {
  return has_pose(result) && result.rms_distance_mm <= options_.start_max_rms_mm &&
         result.explained_fraction >= options_.start_min_explained;
}

void Tracker::begin(const RegistrationResult& result, Clock::time_point when) {
  ct_from_ghost_.reset();
  last_valid_ct_from_depth_ = result.fixed_from_moving;
  valid_rms_mm_ = result.rms_distance_mm;
  last_valid_at_ = when;
  state_ = TrackingState::kTracking;
}

void Tracker::judge(const RegistrationResult& result, Clock::time_point when) {
  if (ct_from_ghost_) {
    if (!is_a_start(result)) return;
    begin(result, when);
    ++counts_.tracked;
    return;
  }
  if (has_pose(result) && result.rms_distance_mm < options_.residual_ratio * valid_rms_mm_) {
    last_valid_ct_from_depth_ = result.fixed_from_moving;
    last_valid_at_ = when;
    state_ = TrackingState::kTracking;
    ++counts_.tracked;
    return;
  }
  ++counts_.skipped;
  if (when - last_valid_at_ < options_.lost_after) {
    state_ = TrackingState::kSkipped;
  } else if (state_ != TrackingState::kLost) {
    state_ = TrackingState::kLost;
    ++counts_.lost;
  }
}

}  // namespace mor
