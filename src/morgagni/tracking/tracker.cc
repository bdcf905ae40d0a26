// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/tracking/tracker.h"

#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/registration/visible_place.h"

namespace mor {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Fewer points say nothing about a pose: the camera looks past the body, or is covered.
constexpr std::size_t kMinPoints = 200;
/// Readings within this of the skin are taken as the skin's: sensor noise and millimetres of bias.
constexpr double kOnSkinMm = 8.0;
/// The same at a pose that is only expected, and the share of the skin that must be seen there.
constexpr double kRoughlyOnSkinMm = 30.0;
constexpr double kRoughlyMinSeen = 0.3;
/// An offered start is tried on so many frames.
constexpr int kOfferFrames = 6;
/// After so many missed frames a new start is worth its time.
constexpr int kMissesBeforeStart = 2;

bool has_pose(const RegistrationResult& result) {
  return result.status == RegistrationStatus::kConverged ||
         result.status == RegistrationStatus::kMaxIterations;
}

/// How much of the skin speaks for the pose, for choosing among several.
double support(const SkinEvidence& skin) {
  return skin.seen_fraction() * (1.0 - skin.floating_fraction());
}

}  // namespace

std::string_view to_string(TrackingState state) {
  switch (state) {
    case TrackingState::kWaiting:
      return "waiting";
    case TrackingState::kTracking:
      return "tracking";
    case TrackingState::kUncertain:
      return "uncertain";
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
  MOR_CHECK(limits.check());
  if (!(sensor_bias_mm >= 0.0 && sensor_bias_mm <= kMostSensorBiasMm)) {
    return refuse("sensor_bias_mm", "in [0, 50]", sensor_bias_mm);
  }
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
                                std::shared_ptr<const FixedSurface> fixed,
                                BodySurfaceExtractor extractor,
                                std::unique_ptr<FineRegistration> registration) {
  MOR_CHECK(options.check());
  if (fixed->mesh.empty() || fixed->mesh.normals.size() != fixed->mesh.vertices.size()) {
    return make_error(ErrorCode::kInvalidArgument, "tracking needs a skin surface with normals");
  }
  return Tracker(options, std::move(fixed), std::move(extractor), std::move(registration));
}

Tracker::Tracker(const TrackingOptions& options,
                 std::shared_ptr<const FixedSurface> fixed,
                 BodySurfaceExtractor extractor,
                 std::unique_ptr<FineRegistration> registration)
    : options_(options),
      fixed_(std::move(fixed)),
      samples_(fixed_->mesh),
      extractor_(std::move(extractor)),
      registration_(std::move(registration)) {}

void Tracker::use_skin(std::shared_ptr<const FixedSurface> fixed,
                       std::unique_ptr<FineRegistration> registration) {
  fixed_ = std::move(fixed);
  samples_ = SkinSamples(fixed_->mesh);
  registration_ = std::move(registration);
}

Result<void> Tracker::expect_bias(double sensor_bias_mm) {
  TrackingOptions options = options_;
  options.sensor_bias_mm = sensor_bias_mm;
  MOR_CHECK(options.check());
  options_ = options;
  return {};
}

void Tracker::wait_for_start() {
  ct_from_ghost_.reset();
  offer_.reset();
  motion_.forget();
  covariance_.reset();
  num_missed_ = 0;
  state_ = TrackingState::kWaiting;
}

void Tracker::start_by_placement(const Eigen::Isometry3d& ct_from_depth) {
  wait_for_start();
  ct_from_ghost_ = ct_from_depth;
}

Result<void> Tracker::start_at(const std::shared_ptr<const RgbdFrame>& given,
                               const Eigen::Isometry3d& ct_from_depth) {
  const auto corrected = depth_corrected(given, levels_);
  const RgbdFrame& frame = *corrected;
  MOR_TRY(const auto scene, segment(frame, ct_from_depth));
  MOR_TRY(const auto found, attempt(scene, ct_from_depth, StartQuality::kRough));
  if (is_a_start(found)) {
    begin(found, frame.captured_at);
    return {};
  }
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format("the body does not fit at this start: {:.0f} % of what the camera sees lies on "
                  "the CT skin, {:.0f} % of the skin that should be seen is there, {:.0f} % of it "
                  "would float before what the camera sees, residual {:.1f} mm (limit {:.1f} mm)",
                  100.0 * found.result.explained_fraction,
                  100.0 * found.skin.seen_fraction(),
                  100.0 * found.skin.floating_fraction(),
                  found.result.rms_distance_mm,
                  options_.start_max_rms_mm));
}

void Tracker::offer_start(const RgbdFrame& frame, const Eigen::Isometry3d& ct_from_depth) {
  const auto skin = samples_.compare(
      frame.depth_mm.view(), frame.calibration->depth, ct_from_depth, kRoughlyOnSkinMm);
  if (skin.num_seen == 0) return;
  offer_ = Offer{{ct_from_depth, skin.seen_center_mm}, kOfferFrames};
}

Result<TrackedFrame> Tracker::process(std::shared_ptr<const RgbdFrame> frame) {
  TrackedFrame tracked;
  judgement_ms_ = 0.0;
  const auto depth_started = Clock::now();
  // The one place where the depth is corrected: what the sensor gave goes no further.
  frame = depth_corrected(std::move(frame), levels_);
  MOR_TRY(const auto scene, segment(*frame, expected_pose(*frame)));
  tracked.depth_ms = ms_since(depth_started);

  if (ct_from_ghost_ || offer_ || motion_.is_known()) {
    const auto registration_started = Clock::now();
    MOR_TRY(const auto found, attempt_frame(scene));
    tracked.registration_ms = ms_since(registration_started) - judgement_ms_;
    take(found, frame->captured_at);
    tracked.registration = found.result;
    tracked.skin = found.skin;
    tracked.doubts = found.judgement.doubts;
  }

  tracked.state = state_;
  tracked.ct_from_ghost = ct_from_ghost_;
  if (motion_.is_known()) {
    tracked.valid_rms_mm = valid_rms_mm_;
    tracked.is_held = num_missed_ > 0;
    if (state_ != TrackingState::kLost) {
      tracked.ct_from_depth = motion_.last();
      // A held pose is an old one: how far it is off now, nobody knows.
      if (!tracked.is_held) tracked.covariance = covariance_;
    }
  }
  const bool sees_something = scene.surface.cloud.size() >= kMinPoints;
  tracked.needs_start = sees_something && !ct_from_ghost_ && !offer_ &&
                        (state_ == TrackingState::kWaiting || num_missed_ >= kMissesBeforeStart);
  tracked.counts = counts_;
  tracked.judgement_ms = judgement_ms_;
  tracked.frame = std::move(frame);
  tracked.fixed = fixed_;
  return tracked;
}

std::optional<Eigen::Isometry3d> Tracker::expected_pose(const RgbdFrame& frame) const {
  if (ct_from_ghost_) return ct_from_ghost_;
  if (offer_) return offer_->seen.ct_from_depth;
  if (!motion_.is_known()) return std::nullopt;
  // The paper starts from the last valid pose.
  const bool is_papers = options_.gate == TrackingGate::kResidual;
  const Eigen::Isometry3d expected =
      is_papers ? motion_.last() : motion_.expected(frame.captured_at);
  if (num_missed_ == 0) return expected;
  // The body may be elsewhere by now, and what lies where it was the table.
  const auto there =
      samples_.compare(frame.depth_mm.view(), frame.calibration->depth, expected, kRoughlyOnSkinMm);
  if (there.seen_fraction() < kRoughlyMinSeen) return std::nullopt;
  return expected;
}

bool Tracker::judges_by_residual(const RegistrationResult& result) const {
  return options_.gate == TrackingGate::kResidual || (has_pose(result) && !result.information);
}

Result<Tracker::Scene> Tracker::segment(const RgbdFrame& frame,
                                        const std::optional<Eigen::Isometry3d>& expected) {
  const auto depth_mm = frame.depth_mm.view();
  MOR_TRY(auto surface,
          expected ? extractor_.extract(depth_mm, places_facing_camera(fixed_->mesh, *expected))
                   : extractor_.extract(depth_mm));
  const double relief = relief_mm(surface.cloud);
  return Scene{frame, std::move(surface), relief};
}

Result<Tracker::Attempt> Tracker::attempt(const Scene& scene,
                                          const Eigen::Isometry3d& start,
                                          StartQuality quality,
                                          const std::optional<ExpectedPose>& expected) {
  Attempt made;
  MOR_TRY(made.result, registration_->align(scene.surface.cloud, start, quality));
  const auto judgement_started = Clock::now();
  made.skin = samples_.compare(scene.frame.depth_mm.view(),
                               scene.frame.calibration->depth,
                               made.result.fixed_from_moving,
                               kOnSkinMm);
  if (made.result.information) made.covariance = pose_covariance(*made.result.information);
  made.surface_relief_mm = scene.relief_mm;
  made.expected = expected;
  made.judgement = judged(made);
  // A bias is no doubt of a frame; it only makes each pose less exact.
  if (made.covariance && options_.sensor_bias_mm > 0.0) {
    const double distance_mm =
        (made.result.fixed_from_moving.translation() - made.skin.seen_center_mm).norm();
    made.covariance = pose_covariance(
        *made.result.information,
        with_sensor_bias(default_bound_calibration(), options_.sensor_bias_mm, distance_mm));
  }
  judgement_ms_ += ms_since(judgement_started);
  return made;
}

Judgement Tracker::judged(const FrameEvidence& evidence) const {
  const auto& result = evidence.result;
  if (!judges_by_residual(result)) return judge_evidence(evidence, options_.limits);
  if (!has_pose(result)) return {Verdict::kBad, {Doubt::kNoBody}};
  // A start has no e_valid yet.
  if (motion_.is_known() && result.rms_distance_mm >= options_.residual_ratio * valid_rms_mm_) {
    return {Verdict::kBad, {Doubt::kResidual}};
  }
  return {};
}

/// A surface that was not grown from the body may be mostly the table, which no pose explains: once
/// more with what is seen where this pose puts the body.
Result<Tracker::Attempt> Tracker::attempt_there(const RgbdFrame& frame,
                                                const Eigen::Isometry3d& ct_from_depth) {
  MOR_TRY(const auto scene, segment(frame, ct_from_depth));
  return attempt(scene, ct_from_depth, StartQuality::kTracked);
}

/// The first of several poses around the last one that would do as a start. Bad where there is
/// none: after a loss nothing less is believed; the best of them tells why.
Result<Tracker::Attempt> Tracker::attempt_around(const Scene& scene, const LastSeen& last) {
  std::optional<Attempt> best;
  for (const auto& start : resume_starts(last, scene.surface.cloud, round_++)) {
    MOR_TRY(auto made, attempt(scene, start, StartQuality::kRough));
    if (made.judgement.doubts == std::vector{Doubt::kUnexplained}) {
      MOR_TRY(made, attempt_there(scene.frame, made.result.fixed_from_moving));
    }
    if (is_a_start(made)) return made;
    if (!best || support(made.skin) > support(best->skin)) best = std::move(made);
  }
  best->judgement.verdict = Verdict::kBad;
  return *std::move(best);
}

Result<Tracker::Attempt> Tracker::attempt_frame(const Scene& scene) {
  if (scene.surface.cloud.size() < kMinPoints) {
    Attempt none;
    none.result.status = RegistrationStatus::kTooFewPairs;
    none.judgement = {Verdict::kBad, {Doubt::kNoBody}};
    return none;
  }
  if (ct_from_ghost_) {
    MOR_TRY(auto made, attempt(scene, *ct_from_ghost_, StartQuality::kRough));
    if (!is_a_start(made)) made.judgement.verdict = Verdict::kBad;
    return made;
  }
  if (offer_) {
    MOR_TRY(auto made, attempt_around(scene, offer_->seen));
    if (made.judgement.verdict != Verdict::kBad || !motion_.is_known()) return made;
  }
  const auto when = scene.frame.captured_at;
  if (options_.gate == TrackingGate::kResidual) {
    // After a frame without a pose the camera may have moved on: look further around.
    const auto quality = num_missed_ > 0 ? StartQuality::kRough : StartQuality::kTracked;
    return attempt(scene, motion_.last(), quality);
  }
  if (num_missed_ == 0) {
    const ExpectedPose expected{motion_.expected(when), when - motion_.last_at()};
    MOR_TRY(auto made, attempt(scene, expected.ct_from_depth, StartQuality::kTracked, expected));
    if (made.judgement.verdict != Verdict::kBad) return made;
  }
  return attempt_around(scene, {motion_.last(), seen_center_mm_});
}

bool Tracker::is_a_start(const Attempt& attempt) const {
  const auto& result = attempt.result;
  if (result.rms_distance_mm > options_.start_max_rms_mm) return false;
  if (!judges_by_residual(result)) return attempt.judgement.verdict == Verdict::kGood;
  return has_pose(result) && result.explained_fraction >= options_.start_min_explained;
}

void Tracker::begin(const Attempt& attempt, TimePoint when) {
  wait_for_start();
  valid_rms_mm_ = attempt.result.rms_distance_mm;
  use(attempt, when);
}

void Tracker::use(const Attempt& attempt, TimePoint when) {
  motion_.add(attempt.result.fixed_from_moving, when);
  seen_center_mm_ = attempt.skin.seen_center_mm;
  covariance_ = attempt.covariance;
  num_missed_ = 0;
  state_ = attempt.judgement.verdict == Verdict::kGood ? TrackingState::kTracking
                                                       : TrackingState::kUncertain;
}

void Tracker::take(const Attempt& attempt, TimePoint when) {
  const bool is_usable = attempt.judgement.verdict != Verdict::kBad;
  if (ct_from_ghost_ || offer_) {
    if (is_usable) {
      begin(attempt, when);
      ++counts_.tracked;
      return;
    }
    if (offer_ && --offer_->frames_left <= 0) offer_.reset();
    if (!motion_.is_known()) return;
  }
  if (!is_usable) {
    miss(when);
    return;
  }
  if (state_ == TrackingState::kLost) ++counts_.resumed;
  use(attempt, when);
  ++(state_ == TrackingState::kTracking ? counts_.tracked : counts_.uncertain);
}

void Tracker::miss(TimePoint when) {
  ++num_missed_;
  if (when - motion_.last_at() < options_.lost_after) {
    state_ = TrackingState::kUncertain;
    ++counts_.uncertain;
  } else if (state_ != TrackingState::kLost) {
    state_ = TrackingState::kLost;
    ++counts_.lost;
  }
}

}  // namespace mor
