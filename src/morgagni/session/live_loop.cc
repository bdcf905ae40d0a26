// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/live_loop.h"

#include <algorithm>
#include <chrono>
#include <future>
#include <mutex>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>

#include "morgagni/core/latest_slot.h"
#include "morgagni/core/log.h"
#include "morgagni/core/statistics.h"
#include "morgagni/session/depth_pick.h"
#include "morgagni/session/frame_rate.h"

namespace mor {
namespace {

using Clock = std::chrono::steady_clock;
using FramePtr = std::shared_ptr<const RgbdFrame>;

constexpr std::size_t kTimedFrames = 60;
/// A still picture (frozen, or the camera silent) is drawn anew this often, so that changes of the
/// view show and viewers who join see something.
constexpr std::chrono::milliseconds kStillPeriod{100};
constexpr std::chrono::milliseconds kCameraRetry{500};

double ms_between(Clock::time_point start, Clock::time_point end) {
  return std::chrono::duration<double, std::milli>(end - start).count();
}

std::vector<RenderedStructure> rendered(const Case& body) {
  std::vector<RenderedStructure> structures;
  for (const auto& [name, color, mesh] : body.structures) structures.push_back({name, mesh, color});
  return structures;
}

class Loop final : public LiveLoop {
 public:
  Loop(std::shared_ptr<const Case> body, std::unique_ptr<RangeCamera> camera, Tracker tracker)
      : body_(std::move(body)), camera_(std::move(camera)), tracker_(std::move(tracker)) {
    for (const auto& structure : body_->structures) view_.structures[structure.name] = true;
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
    capture_thread_ = std::jthread([this](std::stop_token stop) { capture(stop); });
    return {};
  }

  void stop() override {
    capture_thread_ = {};
    tracking_thread_ = {};
    render_thread_ = {};
  }

  Result<void> start_by_placement(const PlacementOptions& options) override {
    MOR_TRY(const auto ct_from_depth,
            place_in_front_of_camera(body_->skin->mesh.bounds(), options));
    {
      const std::lock_guard lock(tracker_mutex_);
      tracker_.start_by_placement(ct_from_depth);
    }
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
      MOR_CHECK(tracker_.start_at(*frame, start.ct_from_depth));
    }
    cancel_landmarks();
    return {};
  }

  void cancel_landmarks() override {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(picking_landmarks_, false)) return;
    still_.reset();
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
  }

  Image<Rgba8> snapshot() const override {
    const std::lock_guard lock(picture_mutex_);
    return picture_;
  }

  LiveStatus status() const override {
    const std::lock_guard lock(mutex_);
    return {.last = last_,
            .frozen = still_.has_value() && !picking_landmarks_,
            .picking_landmarks = picking_landmarks_,
            .frame_rate = shown_rate_.per_second(Clock::now()),
            .num_dropped = captured_.num_dropped() + tracked_.num_dropped(),
            .wait_ms = wait_ms_.median(),
            .depth_ms = depth_ms_.median(),
            .registration_ms = registration_ms_.median(),
            .render_ms = render_ms_.median(),
            .camera_error = camera_error_};
  }

 private:
  Result<FramePtr> landmark_frame() const {
    const std::lock_guard lock(mutex_);
    if (!picking_landmarks_) {
      return make_error(ErrorCode::kInvalidArgument, "begin with the landmarks first");
    }
    return still_->frame;
  }

  void set_camera_error(std::optional<std::string> sentence) {
    const std::lock_guard lock(mutex_);
    if (sentence && sentence != camera_error_) log::warn("{}", *sentence);
    camera_error_ = std::move(sentence);
  }

  void capture(std::stop_token stop) {
    while (!stop.stop_requested()) {
      auto frame = camera_->next_frame(stop);
      if (!frame) {
        set_camera_error("the camera gives no picture: " + frame.error().message);
        std::unique_lock lock(retry_mutex_);
        std::condition_variable_any().wait_for(lock, stop, kCameraRetry, [] { return false; });
        continue;
      }
      if (!*frame) {
        if (!stop.stop_requested()) set_camera_error("the recording has ended");
        return;
      }
      set_camera_error(std::nullopt);
      captured_.put(*std::move(frame));
    }
  }

  void track(std::stop_token stop) {
    while (auto frame = captured_.take(stop)) {
      const double wait_ms = ms_between((*frame)->captured_at, Clock::now());
      auto tracked = [&] {
        const std::lock_guard lock(tracker_mutex_);
        return tracker_.process(*std::move(frame));
      }();
      if (!tracked) {
        set_camera_error("a picture of the camera cannot be used: " + tracked.error().message);
        continue;
      }
      {
        const std::lock_guard lock(mutex_);
        last_ = *tracked;
        wait_ms_.add(wait_ms);
        depth_ms_.add(tracked->depth_ms);
        if (tracked->registration) registration_ms_.add(tracked->registration_ms);
      }
      tracked_.put(*std::move(tracked));
    }
  }

  void render(std::stop_token stop, const Show& show, std::promise<Result<void>>& ready) {
    auto renderer = OverlayRenderer::create(rendered(*body_), body_->skin->mesh);
    if (!renderer) {
      ready.set_value(tl::unexpected<Error>(renderer.error()));
      return;
    }
    log::info("pictures are drawn by {}", (*renderer)->device());
    ready.set_value({});

    TrackedFrame newest;
    auto next_still_at = Clock::now();
    while (!stop.stop_requested()) {
      auto arrived = tracked_.take(stop, kStillPeriod);
      const bool is_new = arrived.has_value();
      if (is_new) newest = *std::move(arrived);
      const auto [shown, view, is_still] = choose(newest);
      if (!shown.frame || ((is_still || !is_new) && Clock::now() < next_still_at)) continue;
      next_still_at = Clock::now() + kStillPeriod;
      draw(**renderer, shown, view, is_still, show);
    }
  }

  struct Choice {
    TrackedFrame shown;
    ViewSettings view;
    bool is_still = false;
  };

  Choice choose(const TrackedFrame& newest) const {
    const std::lock_guard lock(mutex_);
    return {still_ ? *still_ : newest, view_, still_.has_value()};
  }

  void draw(OverlayRenderer& renderer,
            const TrackedFrame& shown,
            const ViewSettings& view,
            bool is_still,
            const Show& show) {
    const auto started = Clock::now();
    const auto picture = renderer.render(shown.frame->color.view(), overlay_view(shown, view));
    if (!picture) {
      log::error("the picture cannot be drawn: {}", picture.error().message);
      return;
    }
    const nlohmann::json info = {{"frame_id", shown.frame->frame_id},
                                 {"state", to_string(shown.state)},
                                 {"frozen", is_still}};
    show(*picture, {shown.frame->captured_at, info.dump()});
    keep_snapshot(*picture);
    const std::lock_guard lock(mutex_);
    render_ms_.add(ms_between(started, Clock::now()));
    if (!is_still) shown_rate_.count(Clock::now());
  }

  OverlayView overlay_view(const TrackedFrame& shown, const ViewSettings& view) const {
    const auto& [depth_camera, color_camera, color_from_depth] = *shown.frame->calibration;
    OverlayView overlay;
    overlay.color_camera = color_camera;
    overlay.opacity = view.opacity;
    overlay.hole = view.hole;
    if (shown.ct_from_depth)
      overlay.color_from_ct = color_from_depth * shown.ct_from_depth->inverse();
    if (shown.ct_from_ghost)
      overlay.color_from_ghost = color_from_depth * shown.ct_from_ghost->inverse();
    for (const auto& structure : body_->structures) {
      if (!view.structures.at(structure.name)) overlay.hidden.insert(structure.name);
    }
    return overlay;
  }

  void keep_snapshot(ImageView<const Rgba8> picture) {
    const std::lock_guard lock(picture_mutex_);
    if (picture_.width() != picture.width() || picture_.height() != picture.height()) {
      picture_ = Image<Rgba8>(picture.width(), picture.height());
    }
    for (int y = 0; y < picture.height(); ++y) {
      std::copy_n(picture.row(y), picture.width(), picture_.view().row(y));
    }
  }

  const std::shared_ptr<const Case> body_;
  const std::unique_ptr<RangeCamera> camera_;

  std::mutex tracker_mutex_;
  Tracker tracker_;

  LatestSlot<FramePtr> captured_;
  LatestSlot<TrackedFrame> tracked_;

  mutable std::mutex mutex_;  ///< Guards everything down to the next blank line.
  ViewSettings view_;
  TrackedFrame last_;
  std::optional<TrackedFrame> still_;  ///< Shown instead of the newest.
  bool picking_landmarks_ = false;
  std::optional<std::string> camera_error_;
  FrameRate shown_rate_;
  RollingWindow wait_ms_{kTimedFrames};
  RollingWindow depth_ms_{kTimedFrames};
  RollingWindow registration_ms_{kTimedFrames};
  RollingWindow render_ms_{kTimedFrames};

  mutable std::mutex picture_mutex_;
  Image<Rgba8> picture_;

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
  MOR_TRY(auto tracker,
          Tracker::create(options.tracking, std::move(extractor), std::move(registration)));
  auto loop = std::make_unique<Loop>(std::move(body), std::move(camera), std::move(tracker));
  MOR_CHECK(loop->start_by_placement(options.placement));
  return loop;
}

}  // namespace mor
