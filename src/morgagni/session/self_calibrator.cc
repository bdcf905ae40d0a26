// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/self_calibrator.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <utility>

#include <spdlog/fmt/fmt.h>
#include <sys/resource.h>
#include <unistd.h>

#include "morgagni/calibration/corrected_calibration.h"
#include "morgagni/calibration/skin_readings.h"
#include "morgagni/core/log.h"
#include "morgagni/core/printable_text.h"
#include "morgagni/core/utc.h"

namespace mor {
namespace {

constexpr std::chrono::milliseconds kWakeUp{500};
/// Where the views say too little, so many of them make room for others, and so often.
constexpr int kDroppedShare = 3;  ///< A third.
constexpr int kMostEstimates = 3;
/// A depth error of 1 mm (root mean square) moved the simulated bodies' points by 0.7 mm
/// (docs/error-bound.md, the bias rows): the bias that leaves a known error of the pose.
constexpr double kBiasPerShift = 1.45;
/// A skin that has changed by 1 mm since its CT moves the poses by so much
/// (docs/self-calibration.md).
constexpr double kShiftPerSkin = 2.0;
constexpr std::size_t kMostOriginWords = 200;

double thread_cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

bool is_good(const TrackedFrame& tracked) {
  return tracked.state == TrackingState::kTracking && tracked.frame && tracked.ct_from_depth &&
         !tracked.is_held && tracked.doubts.empty();
}

/// What stays unknown of the depth once the correction is made, and the same while it is not: as
/// a bias, root mean square.
double bias_after_mm(const SelfCalibration& found) {
  const double by_skin_mm = found.follows_skin ? 0.0 : kShiftPerSkin * found.skin_rms_mm;
  return kBiasPerShift * std::hypot(found.left_mm(), by_skin_mm);
}
double bias_before_mm(const SelfCalibration& found) {
  const double by_sensor_mm = found.corrects_sensor() ? found.shift_mm : 0.0;
  const double by_skin_mm = found.follows_skin ? kShiftPerSkin * found.skin_rms_mm : 0.0;
  return std::hypot(bias_after_mm(found), kBiasPerShift * std::hypot(by_sensor_mm, by_skin_mm));
}

/// How far two forms of a skin lie apart at most.
double most_apart_mm(const TriangleMesh& a, const TriangleMesh& b) {
  float most_mm = 0.0F;
  for (std::size_t i = 0; i < std::min(a.vertices.size(), b.vertices.size()); ++i) {
    most_mm = std::max(most_mm, (a.vertices[i] - b.vertices[i]).norm());
  }
  return static_cast<double>(most_mm);
}

}  // namespace

std::string_view to_string(SelfCalibratorPhase phase) {
  switch (phase) {
    case SelfCalibratorPhase::kGathering:
      return "gathering";
    case SelfCalibratorPhase::kEstimating:
      return "estimating";
    case SelfCalibratorPhase::kProposed:
      return "proposed";
    case SelfCalibratorPhase::kResting:
      return "resting";
  }
  return "resting";
}

SelfCalibrator::SelfCalibrator(std::shared_ptr<const Case> body,
                               CalibrationInUse in_use,
                               std::string device_id,
                               CalibrationStore store,
                               Hindrance hindrance,
                               SelfCalibratorOptions options)
    : body_(std::move(body)),
      in_use_(std::move(in_use)),
      device_id_(std::move(device_id)),
      store_(std::move(store)),
      hindrance_(std::move(hindrance)),
      options_(std::move(options)) {
  status_.wanted_views = options_.num_views;
  status_.device_id = device_id_;
  thread_ = std::jthread([this](std::stop_token stop) { run(stop); });
}

SelfCalibrator::~SelfCalibrator() = default;

void SelfCalibrator::look(const TrackedFrame& tracked) {
  if (!wants_views_ || !is_good(tracked)) return;
  {
    // Whoever holds it may be a thread that hardly runs: another frame will do as well.
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock || !pace_.wants(*tracked.ct_from_depth, tracked.frame->captured_at)) return;
    pace_.keep(*tracked.ct_from_depth, tracked.frame->captured_at);
  }
  slot_.put(View{tracked.frame, *tracked.ct_from_depth, tracked.fixed});
}

/// What is known to be wrong with the depth and not removed, for the error bound. Under `mutex_`.
void SelfCalibrator::tell_bias() {
  const double applied_mm = status_.applied ? status_.applied->bias_mm : 0.0;
  const bool is_off = status_.found && status_.found->proposes();
  in_use_.expect_bias(std::max(applied_mm, is_off ? bias_before_mm(*status_.found) : 0.0));
}

void SelfCalibrator::rest_or_begin(SelfCalibratorPhase phase) {
  const std::lock_guard lock(mutex_);
  status_.phase = phase;
  status_.num_views = 0;
  status_.coverage = {};
  pace_ = {};
  wants_anew_ = true;
  estimating_.request_stop();
  estimating_ = {};
  wants_views_ = phase == SelfCalibratorPhase::kGathering;
}

void SelfCalibrator::look_again() {
  {
    const std::lock_guard lock(mutex_);
    status_.found.reset();
    status_.problem.clear();
    tell_bias();
  }
  rest_or_begin(SelfCalibratorPhase::kGathering);
  slot_.put(std::nullopt);
}

Result<void> SelfCalibrator::check_hindrance() const {
  const auto sentence = hindrance_ ? hindrance_() : std::string();
  if (sentence.empty()) return {};
  return make_error(ErrorCode::kInvalidArgument, sentence);
}

KeptCalibration SelfCalibrator::to_keep(const SelfCalibration& found,
                                        const RgbdCalibration& in_use) const {
  KeptCalibration made;
  made.device_id = device_id_;
  made.made_at = std::chrono::system_clock::now();
  const auto base = in_use.origin.empty() ? std::string("the camera's own") : in_use.origin;
  made.made_by = fmt::format("self-calibration on the CT skin, built on [{}]",
                             printable_text(base.substr(0, kMostOriginWords)));
  const auto& held = found.held_out;
  made.figures = {
      {"case", body_->name},
      {"overlay off before", fmt::format("{:.1f} mm", found.shift_mm)},
      {"the body's skin",
       found.follows_skin ? fmt::format("had changed by up to {:.1f} mm; that is "
                                        "the body's and not kept here",
                                        found.skin_most_mm)
                          : std::string("as in its CT")},
      {"stays unknown", fmt::format("{:.1f} mm", found.remaining_mm)},
      {"views", fmt::format("{}", found.num_views)},
      {"held-out views off the skin",
       fmt::format("{:.3f} mm before, {:.3f} mm after", held.as_it_is_mm, held.both_mm)},
      {"parts that agree", fmt::format("{} of {}", held.sensor.num_better, held.num_folds)}};
  return made;
}

void SelfCalibrator::keep(const KeptCalibration& made, AppliedCorrection& applied) {
  std::string problem;
  if (applied.corrects_sensor && !device_id_.empty()) {
    const auto file = store_.save(made);
    if (file) {
      applied.kept_in = file->string();
    } else {
      problem = "the correction is in use but could not be kept: " + file.error().message;
      log::warn("{}", problem);
    }
  }
  const std::lock_guard lock(mutex_);
  status_.problem = std::move(problem);
  status_.applied = applied;
}

Result<void> SelfCalibrator::apply() {
  const std::lock_guard command_lock(command_mutex_);
  MOR_CHECK(check_hindrance());
  const auto before_skin = in_use_.skin();
  auto skin = before_skin;
  const auto found = [&]() -> std::optional<SelfCalibration> {
    const std::lock_guard lock(mutex_);
    if (status_.phase != SelfCalibratorPhase::kProposed) return std::nullopt;
    if (status_.found->follows_skin) skin = found_skin_;
    return status_.found;
  }();
  if (!found) {
    return make_error(ErrorCode::kInvalidArgument, "no correction is proposed now");
  }
  const auto in_use = in_use_.get();
  auto made = to_keep(*found, *in_use);
  auto next = in_use;
  if (found->corrects_sensor()) {
    MOR_TRY(made.calibration, without_error(*in_use, *found));
    made.calibration.origin = fmt::format("{}, {}", made.made_by, utc_text(made.made_at));
    next = std::make_shared<const RgbdCalibration>(made.calibration);
  }
  const double bias_mm = bias_after_mm(*found);
  MOR_CHECK(in_use_.use(next, skin, bias_mm));
  AppliedCorrection applied{.origin = next->origin,
                            .corrects_sensor = found->corrects_sensor(),
                            .follows_skin = found->follows_skin,
                            .shift_mm = found->now_mm(),
                            .remaining_mm = found->left_mm(),
                            .skin_most_mm = found->skin_most_mm,
                            .bias_mm = bias_mm,
                            .kept_in = {}};
  keep(made, applied);
  replaced_.push_back({in_use, before_skin, applied, bias_before_mm(*found)});
  rest_or_begin(SelfCalibratorPhase::kGathering);
  slot_.put(std::nullopt);
  return {};
}

Result<void> SelfCalibrator::discard() {
  const std::lock_guard command_lock(command_mutex_);
  {
    const std::lock_guard lock(mutex_);
    if (status_.phase != SelfCalibratorPhase::kProposed) {
      return make_error(ErrorCode::kInvalidArgument, "no correction is proposed now");
    }
    status_.found.reset();
  }
  rest_or_begin(SelfCalibratorPhase::kResting);
  return {};
}

Result<void> SelfCalibrator::undo() {
  const std::lock_guard command_lock(command_mutex_);
  if (replaced_.empty()) {
    return make_error(ErrorCode::kInvalidArgument, "no correction was applied in this session");
  }
  MOR_CHECK(check_hindrance());
  const auto back_to = replaced_.back();
  const double earlier_mm = replaced_.size() < 2 ? 0.0 : replaced_[replaced_.size() - 2].by.bias_mm;
  // The sensor is no better for it: as after discard(), until look_again().
  MOR_CHECK(
      in_use_.use(back_to.calibration, back_to.skin, std::max(earlier_mm, back_to.bias_before_mm)));
  replaced_.pop_back();
  const auto taken_back =
      back_to.by.kept_in.empty() ? Result<void>() : store_.take_back(back_to.by.kept_in);
  {
    const std::lock_guard lock(mutex_);
    status_.found.reset();
    status_.applied = replaced_.empty() ? std::nullopt : std::optional(replaced_.back().by);
    status_.problem =
        taken_back ? "" : "it is out of use, but still kept: " + taken_back.error().message;
  }
  rest_or_begin(SelfCalibratorPhase::kResting);
  return {};
}

SelfCalibratorStatus SelfCalibrator::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void SelfCalibrator::begin_anew() {
  gatherer_.reset();
  gathered_with_.reset();
  gathered_on_.reset();
  levels_ = {};
  num_estimates_ = 0;
}

void SelfCalibrator::add(const View& view) {
  const auto& calibration = view.frame->calibration;
  if (gathered_with_ != calibration && gathered_with_ && *gathered_with_ != *calibration) {
    begin_anew();  // A device that came back with another calibration.
  }
  gathered_with_ = calibration;
  gathered_on_ = view.fixed;
  if (!gatherer_) gatherer_.emplace(calibration->depth);
  const double started_ms = thread_cpu_ms();
  levels_.learn(view.frame->depth_mm.view());
  gatherer_->add(read_skin(gathered_on_->mesh,
                           calibration->depth,
                           view.frame->depth_mm.view(),
                           levels_,
                           view.ct_from_depth),
                 view.frame->captured_at);
  const double view_ms = thread_cpu_ms() - started_ms;
  const auto coverage = gatherer_->coverage();
  const std::lock_guard lock(mutex_);
  if (wants_anew_) return;  // Meanwhile all this was told to be forgotten.
  status_.num_views = static_cast<int>(gatherer_->views().size());
  status_.coverage = coverage;
  status_.view_ms = view_ms;
}

void SelfCalibrator::estimate(std::stop_token stop) {
  std::stop_source estimating;
  {
    const std::lock_guard lock(mutex_);
    if (wants_anew_) return;
    status_.phase = SelfCalibratorPhase::kEstimating;
    wants_views_ = false;
    estimating = estimating_;
  }
  const std::stop_callback at_the_end(stop, [&] { estimating.request_stop(); });
  const double started_ms = thread_cpu_ms();
  auto found = estimate_self_calibration(gathered_on_->mesh,
                                         *gathered_with_,
                                         gatherer_->views(),
                                         options_.estimate,
                                         estimating.get_token());
  ++num_estimates_;
  std::shared_ptr<const FixedSurface> skin;
  if (found && found->follows_skin) {
    auto made = followed_skin(*found);
    if (made) {
      skin = *std::move(made);
    } else {
      found = tl::unexpected(made.error());
    }
  }
  {
    const std::lock_guard lock(mutex_);
    status_.found_s = 1e-3 * (thread_cpu_ms() - started_ms);
    if (wants_anew_ || stop.stop_requested()) return;
    if (!found) {
      status_.phase = SelfCalibratorPhase::kResting;
      status_.problem = found.error().message;
      return;
    }
  }
  take(*found, std::move(skin));
}

/// The skin to be registered to. It takes a second, so it is made before anybody asks for it.
Result<std::shared_ptr<const FixedSurface>> SelfCalibrator::followed_skin(
    const SelfCalibration& found) const {
  auto now = found.skin.applied_to(gathered_on_->mesh);
  auto words = fmt::format("as it was found to be now, up to {:.1f} mm from the CT's ({})",
                           most_apart_mm(now, body_->skin->mesh),
                           utc_text(std::chrono::system_clock::now()));
  return skin_as_found(std::move(now), std::move(words));
}

/// Proposes, goes on gathering where the motion told too little, or rests.
void SelfCalibrator::take(const SelfCalibration& found, std::shared_ptr<const FixedSurface> skin) {
  const bool is_proposal = found.proposes();
  const auto coverage = gatherer_->coverage();
  const bool lacks_motion =
      found.verdict == SelfCalibrationVerdict::kTooLittleMotion || !coverage.missing().empty();
  const bool goes_on = !is_proposal && lacks_motion && num_estimates_ < kMostEstimates;
  if (goes_on) {
    gatherer_->drop_oldest(gatherer_->views().size() / kDroppedShare);
  } else {
    begin_anew();
  }
  const std::lock_guard lock(mutex_);
  if (wants_anew_) return;
  status_.found = found;
  found_skin_ = std::move(skin);
  tell_bias();
  status_.phase = is_proposal ? SelfCalibratorPhase::kProposed
                  : goes_on   ? SelfCalibratorPhase::kGathering
                              : SelfCalibratorPhase::kResting;
  status_.num_views = goes_on ? static_cast<int>(gatherer_->views().size()) : found.num_views;
  status_.coverage = goes_on ? gatherer_->coverage() : coverage;
  wants_views_ = goes_on;
}

void SelfCalibrator::run(std::stop_token stop) {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), options_.niceness);
  while (!stop.stop_requested()) {
    const auto arrived = slot_.take(stop, kWakeUp);
    const bool anew = [this] {
      const std::lock_guard lock(mutex_);
      return std::exchange(wants_anew_, false);
    }();
    if (anew) begin_anew();
    if (!arrived || !*arrived || !wants_views_) continue;
    // A frame of before the change may lie there still.
    if (*(**arrived).frame->calibration != *in_use_.get()) continue;
    if ((**arrived).fixed != in_use_.skin()) continue;
    add(**arrived);
    if (gatherer_->views().size() >= static_cast<std::size_t>(options_.num_views)) estimate(stop);
  }
}

}  // namespace mor
