// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/live_loop.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <future>
#include <mutex>
#include <thread>
#include <utility>

#include "morgagni/camera/depth_correction.h"
#include "morgagni/core/latest_slot.h"
#include "morgagni/core/log.h"
#include "morgagni/core/statistics.h"
#include "morgagni/session/depth_pick.h"
#include "morgagni/session/frame_rate.h"
#include "morgagni/session/free_pictures.h"
#include "morgagni/session/scene_view.h"
#include "morgagni/session/start_search.h"

namespace mor {
namespace {

using Clock = std::chrono::steady_clock;
using FramePtr = std::shared_ptr<const RgbdFrame>;

constexpr std::size_t kTimedFrames = 60;
/// A still picture (frozen, or the camera silent) is drawn anew this often, so that changes of the
/// view show and viewers who join see something.
constexpr std::chrono::milliseconds kStillPeriod{100};
/// While nothing arrives, a change of the view is looked for this often: a finger is on it.
constexpr std::chrono::milliseconds kLookPeriod{33};
constexpr std::chrono::milliseconds kCameraRetry{500};
/// From one search's frame to the next one's at least: the camera has moved on by then.
constexpr std::chrono::milliseconds kSearchPause{200};

double ms_between(Clock::time_point start, Clock::time_point end) {
  return std::chrono::duration<double, std::milli>(end - start).count();
}

class Loop final : public LiveLoop {
 public:
  Loop(std::shared_ptr<const Case> body,
       std::unique_ptr<RangeCamera> camera,
       Tracker tracker,
       std::shared_ptr<const AutomaticStart> automatic,
       const LiveLoopOptions& options)
      : body_(std::move(body)),
        camera_(std::move(camera)),
        depth_options_(options.depth),
        sensor_bias_mm_(options.tracking.sensor_bias_mm),
        in_step_(options.in_step),
        free_pictures_(bounding_sphere(body_->skin->mesh)),
        tracker_(std::move(tracker)),
        find_(std::make_shared<const StartSearch::Find>(search_on(std::move(automatic)))),
        search_([this](const RgbdFrame& frame, std::stop_token stop) {
          return (*find_.load())(frame, std::move(stop));
        }) {
    view_ = first_view(*body_);
  }

  void observe(Observe observe) override {
    const std::lock_guard lock(observers_mutex_);
    observers_.push_back(std::move(observe));
  }

  void mark(Mark mark) override { mark_ = std::move(mark); }

  void take_fused_from(FreePictures::Fused fused) override {
    free_pictures_.take_fused_from(std::move(fused));
  }

  Result<void> run(Show show) override {
    std::promise<Result<void>> renderer_ready;
    auto ready = renderer_ready.get_future();
    render_thread_ =
        std::jthread([this, show = std::move(show), &renderer_ready](std::stop_token stop) {
          render(stop, show, renderer_ready);
        });
    MOR_CHECK(ready.get());
    tracking_thread_ = std::jthread([this](std::stop_token stop) { track(stop); });
    if (!in_step_) capture_thread_ = std::jthread([this](std::stop_token stop) { capture(stop); });
    return {};
  }

  void stop() override {
    capture_thread_ = {};
    tracking_thread_ = {};
    render_thread_ = {};
    search_.cancel();
  }

  std::shared_ptr<const RgbdCalibration> calibration() const override {
    const std::lock_guard lock(mutex_);
    if (calibration_) return calibration_;
    return std::make_shared<const RgbdCalibration>(camera_->calibration());
  }

  Result<void> use_calibration(std::shared_ptr<const RgbdCalibration> calibration,
                               double sensor_bias_mm) override {
    MOR_CHECK(check_size(*calibration));
    if (calibration->depth_correction) MOR_CHECK(calibration->depth_correction->check());
    // What takes time is made before the tracking is held up.
    MOR_TRY(auto extractor, BodySurfaceExtractor::create(calibration->depth, depth_options_));
    MOR_TRY(auto automatic, AutomaticStart::create(body_->skin, calibration->depth, {}));
    const std::lock_guard lock(tracker_mutex_);
    MOR_CHECK(
        tracker_.use_camera(std::move(extractor), std::hypot(sensor_bias_mm_, sensor_bias_mm)));
    search_.cancel();
    find_ = std::make_shared<const StartSearch::Find>(
        search_on(std::make_shared<const AutomaticStart>(std::move(automatic))));
    const std::lock_guard status_lock(mutex_);
    calibration_ = std::move(calibration);
    return {};
  }

  void start_automatically() override {
    {
      const std::lock_guard lock(tracker_mutex_);
      search_.cancel();
      tracker_.wait_for_start();
      last_searched_at_.reset();
    }
    forget_search();
    cancel_landmarks();
  }

  Result<void> start_by_placement(const PlacementOptions& options) override {
    MOR_TRY(const auto ct_from_depth,
            place_in_front_of_camera(body_->skin->mesh.bounds(), options));
    {
      const std::lock_guard lock(tracker_mutex_);
      search_.cancel();
      tracker_.start_by_placement(ct_from_depth);
    }
    forget_search();
    cancel_landmarks();
    return {};
  }

  Result<void> begin_landmarks() override {
    const std::lock_guard lock(mutex_);
    if (!last_.frame) {
      return make_error(ErrorCode::kInvalidArgument,
                        "the camera has not sent a picture yet: wait for one");
    }
    still_ = last_;
    still_->ct_from_depth.reset();
    still_->ct_from_ghost.reset();
    picking_landmarks_ = true;
    return {};
  }

  Result<Eigen::Vector3d> pick_landmark(const Eigen::Vector2d& color_pixel) override {
    MOR_TRY(const auto frame, landmark_frame());
    const auto point = depth_point_at(*frame, color_pixel);
    if (!point) {
      return make_error(ErrorCode::kInvalidArgument,
                        "the camera has no depth at this point: tap another one nearby");
    }
    return *point;
  }

  Result<void> accept_landmarks(const std::vector<LandmarkPair>& pairs) override {
    MOR_TRY(const auto frame, landmark_frame());
    MOR_TRY(const auto start, start_from_landmarks(pairs));
    {
      const std::lock_guard lock(tracker_mutex_);
      MOR_CHECK(tracker_.start_at(frame, start.ct_from_depth));
      search_.cancel();
    }
    forget_search();
    cancel_landmarks();
    return {};
  }

  void cancel_landmarks() override {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(picking_landmarks_, false)) return;
    still_.reset();
  }

  Result<TouchedPoint> touch(const Eigen::Vector2d& pixel) override {
    if (free_pictures_.is_shown()) return free_pictures_.touch(pixel);
    const TrackedFrame shown = [this] {
      const std::lock_guard lock(mutex_);
      return still_ ? *still_ : last_;
    }();
    if (!shown.ct_from_depth) {
      return make_error(ErrorCode::kInvalidArgument,
                        "the body is not tracked: there is no CT point here");
    }
    const auto touched = touched_point(shown, pixel);
    if (!touched) {
      return make_error(ErrorCode::kInvalidArgument,
                        "the camera has no depth at this point: tap another one nearby");
    }
    return *touched;
  }

  void set_frozen(bool frozen) override {
    const std::lock_guard lock(mutex_);
    if (picking_landmarks_ || frozen == still_.has_value()) return;
    still_ = frozen && last_.frame ? std::optional(last_) : std::nullopt;
  }

  ViewSettings view() const override {
    const std::lock_guard lock(mutex_);
    return view_;
  }

  void set_view(const ViewSettings& view) override {
    const std::lock_guard lock(mutex_);
    view_ = view;
    ++view_version_;
  }

  std::optional<Snapshot> snapshot() const override {
    const std::lock_guard lock(picture_mutex_);
    return snapshot_;
  }

  LiveStatus status() const override {
    LiveStatus status = [this] {
      const std::lock_guard lock(mutex_);
      return LiveStatus{.last = last_,
                        .frozen = still_.has_value() && !picking_landmarks_,
                        .picking_landmarks = picking_landmarks_,
                        .search = search_status_,
                        .bound_mm = std::nullopt,
                        .colors_age_ms = std::nullopt,
                        .frame_rate = shown_rate_.per_second(Clock::now()),
                        .num_dropped = captured_.num_dropped() + tracked_.num_dropped(),
                        .wait_ms = wait_ms_.median(),
                        .depth_ms = depth_ms_.median(),
                        .registration_ms = registration_ms_.median(),
                        .judgement_ms = judgement_ms_.median(),
                        .render_ms = render_ms_.median(),
                        .camera_error = camera_error_};
    }();
    status.bound_mm = bound_in_hole(status.last);
    status.colors_age_ms = free_pictures_.colors_age_ms();
    return status;
  }

 private:
  Result<FramePtr> landmark_frame() const {
    const std::lock_guard lock(mutex_);
    if (!picking_landmarks_) {
      return make_error(ErrorCode::kInvalidArgument, "begin with the landmarks first");
    }
    return still_->frame;
  }

  Result<void> check_size(const RgbdCalibration& calibration) const {
    MOR_CHECK(calibration.depth.check());
    const auto& own = camera_->calibration();
    const auto same = [](const PinholeCamera& a, const PinholeCamera& b) {
      return a.width_px == b.width_px && a.height_px == b.height_px;
    };
    if (same(own.depth, calibration.depth) && same(own.color, calibration.color)) return {};
    return make_error(ErrorCode::kInvalidArgument,
                      "the calibration is for pictures of another size than the camera's");
  }

  void set_camera_error(std::optional<std::string> sentence) {
    const std::lock_guard lock(mutex_);
    if (sentence && sentence != camera_error_) log::warn("{}", *sentence);
    camera_error_ = std::move(sentence);
  }

  /// The camera's next frame; none at the end of the recording or of the session.
  FramePtr next_frame(std::stop_token stop) {
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

  void capture(std::stop_token stop) {
    while (auto frame = next_frame(stop)) captured_.put(std::move(frame));
  }

  void track(std::stop_token stop) {
    const auto next = [&] {
      return in_step_ ? next_frame(stop) : captured_.take(stop).value_or(nullptr);
    };
    while (auto frame = next()) {
      // In step, a frame comes when it is asked for: its own time is the recording's.
      const auto came_at = in_step_ ? Clock::now() : frame->captured_at;
      const double wait_ms = ms_between(came_at, Clock::now());
      auto tracked = follow(std::move(frame));
      if (!tracked) {
        set_camera_error("a picture of the camera cannot be used: " + tracked.error().message);
        continue;
      }
      {
        const std::lock_guard lock(mutex_);
        last_ = *tracked;
        wait_ms_.add(wait_ms);
        depth_ms_.add(tracked->depth_ms);
        judgement_ms_.add(tracked->judgement_ms);
        if (tracked->registration) registration_ms_.add(tracked->registration_ms);
      }
      tell_observers(*tracked);
      tracked_.put({*std::move(tracked), came_at});
    }
  }

  void tell_observers(const TrackedFrame& tracked) {
    const std::lock_guard lock(observers_mutex_);
    for (const Observe& observe : observers_) observe(tracked);
  }

  /// Tracks a frame, and searches for the body where the tracking needs a start. A pose that the
  /// search found is only offered: the tracker judges it on a frame of now before it is shown.
  Result<TrackedFrame> follow(FramePtr frame) {
    const std::lock_guard lock(tracker_mutex_);
    // Here alone a frame gets another calibration than its camera's, so none is tracked half under
    // one and half under another.
    if (calibration_) frame = with_calibration(*frame, calibration_);
    if (auto ended = search_.take()) offer(*ended);
    MOR_TRY(auto tracked, tracker_.process(frame));
    if (!tracked.needs_start) {
      if (search_.is_searching()) search_.cancel();
      if (tracked.state == TrackingState::kTracking) forget_search();
    } else if (!last_searched_at_ || frame->captured_at - *last_searched_at_ >= kSearchPause ||
               frame->captured_at < *last_searched_at_) {
      if (!search_.is_searching()) last_searched_at_ = frame->captured_at;
      if (in_step_) {
        offer(search_.search(tracked.frame));
      } else {
        search_.begin(tracked.frame);
      }
    }
    const std::lock_guard status_lock(mutex_);
    search_status_.is_searching = search_.is_searching();
    return tracked;
  }

  void offer(const Result<SearchedFrame>& ended) {
    if (!ended) {
      log::warn("the search for the body failed: {}", ended.error().message);
      return;
    }
    const auto& [frame, result] = *ended;
    if (result.status == AutomaticStartStatus::kFound) {
      tracker_.offer_start(*frame, result.ct_from_depth);
    }
    const std::lock_guard lock(mutex_);
    search_status_.last = result.status;
    search_status_.reason = result.reason;
  }

  void forget_search() {
    const std::lock_guard lock(mutex_);
    search_status_ = {};
  }

  static std::optional<TouchedPoint> touched_point(const TrackedFrame& shown,
                                                   const Eigen::Vector2d& color_pixel) {
    const auto point = depth_point_at(*shown.frame, color_pixel);
    if (!point) return std::nullopt;
    TouchedPoint touched{
        .ct_mm = *shown.ct_from_depth * *point, .bound_mm = std::nullopt, .state = shown.state};
    if (shown.covariance) touched.bound_mm = error_bound_mm(*shown.covariance, touched.ct_mm);
    return touched;
  }

  std::optional<double> bound_in_hole(const TrackedFrame& shown) const {
    if (!shown.ct_from_depth || !shown.covariance) return std::nullopt;
    const auto& color = shown.frame->calibration->color;
    const Eigen::Vector2d share = view().hole.center.cast<double>();
    const auto touched =
        touched_point(shown, {share.x() * color.width_px - 0.5, share.y() * color.height_px - 0.5});
    return touched ? touched->bound_mm : std::nullopt;
  }

  void render(std::stop_token stop, const Show& show, std::promise<Result<void>>& ready) {
    auto renderers = make_renderers();
    if (!renderers) {
      ready.set_value(tl::unexpected<Error>(renderers.error()));
      return;
    }
    log::info("pictures are drawn by {}", renderers->overlay->device());
    ready.set_value({});

    Arrival newest;
    std::uint64_t drawn_version = 0;
    auto next_still_at = Clock::now();
    while (!stop.stop_requested()) {
      auto arrived = tracked_.take(stop, kLookPeriod);
      const bool is_new = arrived.has_value();
      if (is_new) newest = *std::move(arrived);
      Choice choice = choose(newest.tracked);
      const bool is_due = (is_new && !choice.is_still) || choice.view_version != drawn_version ||
                          Clock::now() >= next_still_at;
      if (!choice.shown.frame || !is_due) continue;
      next_still_at = Clock::now() + kStillPeriod;
      drawn_version = choice.view_version;
      choice.came_at = in_step_ ? newest.came_at : choice.shown.frame->captured_at;
      draw(*renderers, choice, show);
    }
  }

  struct Arrival {
    TrackedFrame tracked;
    Clock::time_point came_at;  ///< From when on the frame's age counts.
  };

  struct Renderers {
    std::unique_ptr<OverlayRenderer> overlay;
    std::unique_ptr<FreeViewRenderer> free;
  };

  Result<Renderers> make_renderers() const {
    const RenderScene scene = scene_of(*body_);
    Renderers renderers;
    MOR_TRY(renderers.overlay, OverlayRenderer::create(scene));
    MOR_TRY(renderers.free, FreeViewRenderer::create(scene));
    return renderers;
  }

  struct Choice {
    TrackedFrame shown;
    Clock::time_point came_at = {};
    ViewSettings view;
    std::uint64_t view_version = 0;
    bool is_still = false;
    bool is_free = false;
  };

  Choice choose(const TrackedFrame& newest) const {
    const std::lock_guard lock(mutex_);
    return {.shown = still_ ? *still_ : newest,
            .came_at = {},
            .view = view_,
            .view_version = view_version_,
            .is_still = still_.has_value(),
            .is_free = view_.free.is_shown && !picking_landmarks_};
  }

  void draw(const Renderers& renderers, const Choice& choice, const Show& show) {
    const auto started = Clock::now();
    ShownPicture what = shown_picture(choice.shown, choice.view, choice.is_still);
    const auto picture = choice.is_free ? free_pictures_.draw(*renderers.free, what)
                                        : draw_overlay(*renderers.overlay, what);
    if (!picture) {
      log::error("the picture cannot be drawn: {}", picture.error().message);
      return;
    }
    const std::string marks = mark_ ? mark_(what) : std::string();
    show(*picture, {choice.came_at, picture_json(what, marks)});
    keep_snapshot(*picture, what, marks);
    const std::lock_guard lock(mutex_);
    render_ms_.add(ms_between(started, Clock::now()));
    if (!choice.is_still) shown_rate_.count(Clock::now());
  }

  Result<ImageView<const Rgba8>> draw_overlay(OverlayRenderer& renderer, const ShownPicture& what) {
    const TrackedFrame& shown = what.tracked;
    free_pictures_.pass_by(shown);
    return renderer.render(
        shown.frame->color.view(),
        overlay_view(
            *shown.frame, shown.ct_from_depth, shown.ct_from_ghost, what.view, what.is_still));
  }

  ShownPicture shown_picture(const TrackedFrame& shown,
                             const ViewSettings& view,
                             bool is_still) const {
    const auto& calibration = *shown.frame->calibration;
    ShownPicture what{.tracked = shown,
                      .view = view,
                      .is_still = is_still,
                      .is_free = false,
                      .camera = calibration.color,
                      .camera_from_ct = std::nullopt,
                      .bound_mm = bound_in_hole(shown)};
    if (shown.ct_from_depth)
      what.camera_from_ct = calibration.color_from_depth * shown.ct_from_depth->inverse();
    return what;
  }

  void keep_snapshot(ImageView<const Rgba8> picture,
                     const ShownPicture& what,
                     const std::string& marks) {
    const std::lock_guard lock(picture_mutex_);
    if (!snapshot_) snapshot_.emplace();
    auto& pixels = snapshot_->pixels;
    if (pixels.width() != picture.width() || pixels.height() != picture.height()) {
      pixels = Image<Rgba8>(picture.width(), picture.height());
    }
    for (int y = 0; y < picture.height(); ++y) {
      std::copy_n(picture.row(y), picture.width(), pixels.view().row(y));
    }
    snapshot_->shown = what;
    snapshot_->marks = marks;
  }

  const std::shared_ptr<const Case> body_;
  const std::unique_ptr<RangeCamera> camera_;

  const BodySurfaceOptions depth_options_;
  const double sensor_bias_mm_;
  const bool in_step_;
  FreePictures free_pictures_;

  std::mutex tracker_mutex_;  ///< Guards the tracker and what it is started from.
  Tracker tracker_;
  /// Written under both mutexes, so either one reads it. None: the camera's own.
  std::shared_ptr<const RgbdCalibration> calibration_;
  std::atomic<std::shared_ptr<const StartSearch::Find>> find_;
  std::optional<Clock::time_point> last_searched_at_;  ///< When that frame was captured.
  StartSearch search_;

  LatestSlot<FramePtr> captured_;
  LatestSlot<Arrival> tracked_;

  mutable std::mutex mutex_;  ///< Guards everything down to the next blank line.
  ViewSettings view_;
  std::uint64_t view_version_ = 0;
  TrackedFrame last_;
  std::optional<TrackedFrame> still_;  ///< Shown instead of the newest.
  bool picking_landmarks_ = false;
  SearchStatus search_status_;
  std::optional<std::string> camera_error_;
  FrameRate shown_rate_;
  RollingWindow wait_ms_{kTimedFrames};
  RollingWindow depth_ms_{kTimedFrames};
  RollingWindow registration_ms_{kTimedFrames};
  RollingWindow judgement_ms_{kTimedFrames};
  RollingWindow render_ms_{kTimedFrames};

  mutable std::mutex picture_mutex_;
  std::optional<Snapshot> snapshot_;

  std::mutex observers_mutex_;
  std::vector<Observe> observers_;
  Mark mark_;

  std::mutex retry_mutex_;
  std::jthread render_thread_;  ///< The threads end first: they are destroyed before what they use.
  std::jthread tracking_thread_;
  std::jthread capture_thread_;
};

}  // namespace

Result<std::unique_ptr<LiveLoop>> LiveLoop::create(std::shared_ptr<const Case> body,
                                                   std::unique_ptr<RangeCamera> camera,
                                                   const LiveLoopOptions& options) {
  MOR_TRY(auto extractor, BodySurfaceExtractor::create(camera->calibration().depth, options.depth));
  MOR_TRY(auto registration, make_fine_registration(body->skin, options.registration));
  MOR_TRY(
      auto tracker,
      Tracker::create(options.tracking, body->skin, std::move(extractor), std::move(registration)));
  MOR_TRY(auto automatic, AutomaticStart::create(body->skin, camera->calibration().depth, {}));
  auto loop = std::make_unique<Loop>(std::move(body),
                                     std::move(camera),
                                     std::move(tracker),
                                     std::make_shared<const AutomaticStart>(std::move(automatic)),
                                     options);
  if (options.start == StartMethod::kPlacement) {
    MOR_CHECK(loop->start_by_placement(options.placement));
  }
  return loop;
}

}  // namespace mor
