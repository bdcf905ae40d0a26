// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/live_pictures.h"

#include <algorithm>
#include <utility>

#include "morgagni/core/log.h"
#include "morgagni/session/scene_view.h"

namespace mor {
namespace {

constexpr std::size_t kTimedPictures = 60;
/// A still picture (frozen, or the camera silent) is drawn anew this often, so that changes of the
/// view show and viewers who join see something.
constexpr std::chrono::milliseconds kStillPeriod{100};
/// While nothing arrives, a change of the view is looked for this often: a finger is on it.
constexpr std::chrono::milliseconds kLookPeriod{33};

ShownPicture shown_picture(const TrackedFrame& shown, const ViewSettings& view, bool is_still) {
  const auto& calibration = *shown.frame->calibration;
  ShownPicture what{.tracked = shown,
                    .view = view,
                    .is_still = is_still,
                    .is_free = false,
                    .camera = calibration.color,
                    .camera_from_ct = std::nullopt,
                    .bound_mm = bound_at_mm(shown, view.hole.center.cast<double>())};
  if (shown.ct_from_depth)
    what.camera_from_ct = calibration.color_from_depth * shown.ct_from_depth->inverse();
  return what;
}

}  // namespace

LivePictures::LivePictures(std::shared_ptr<const Case> body)
    : body_(std::move(body)),
      free_pictures_(bounding_sphere(body_->skin->mesh)),
      view_(first_view(*body_)),
      render_ms_(kTimedPictures) {}

Result<void> LivePictures::run(Show show) {
  std::promise<Result<void>> renderer_ready;
  auto ready = renderer_ready.get_future();
  thread_ = std::jthread([this, show = std::move(show), &renderer_ready](std::stop_token stop) {
    render(stop, show, renderer_ready);
  });
  return ready.get();
}

void LivePictures::put(TrackedFrame tracked, Clock::time_point came_at) {
  Arrival arrival{std::move(tracked), came_at};
  {
    const std::lock_guard lock(mutex_);
    last_ = arrival;
  }
  arrived_.put(std::move(arrival));
}

ViewSettings LivePictures::view() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

void LivePictures::set_view(const ViewSettings& view) {
  const std::lock_guard lock(mutex_);
  view_ = view;
  ++view_version_;
}

void LivePictures::set_frozen(bool frozen) {
  const std::lock_guard lock(mutex_);
  if (picking_landmarks_ || frozen == still_.has_value()) return;
  still_ = frozen && last_.tracked.frame ? std::optional(last_) : std::nullopt;
}

Result<void> LivePictures::begin_landmarks() {
  const std::lock_guard lock(mutex_);
  if (!last_.tracked.frame) {
    return make_error(ErrorCode::kInvalidArgument,
                      "the camera has not sent a picture yet: wait for one");
  }
  still_ = last_;
  still_->tracked.ct_from_depth.reset();
  still_->tracked.ct_from_ghost.reset();
  picking_landmarks_ = true;
  return {};
}

Result<std::shared_ptr<const RgbdFrame>> LivePictures::landmark_frame() const {
  const std::lock_guard lock(mutex_);
  if (!picking_landmarks_) {
    return make_error(ErrorCode::kInvalidArgument, "begin with the landmarks first");
  }
  return still_->tracked.frame;
}

void LivePictures::end_landmarks() {
  const std::lock_guard lock(mutex_);
  if (!std::exchange(picking_landmarks_, false)) return;
  still_.reset();
}

Result<TouchedPoint> LivePictures::touch(const Eigen::Vector2d& pixel) const {
  if (free_pictures_.is_shown()) return free_pictures_.touch(pixel);
  const TrackedFrame shown = [this] {
    const std::lock_guard lock(mutex_);
    return still_ ? still_->tracked : last_.tracked;
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

std::optional<Snapshot> LivePictures::snapshot() const {
  const std::lock_guard lock(picture_mutex_);
  return snapshot_;
}

LivePictures::State LivePictures::state() const {
  const std::lock_guard lock(mutex_);
  return {.last = last_.tracked,
          .frozen = still_.has_value() && !picking_landmarks_,
          .picking_landmarks = picking_landmarks_,
          .frame_rate = shown_rate_.per_second(Clock::now()),
          .render_ms = render_ms_.median(),
          .num_dropped = arrived_.num_dropped()};
}

void LivePictures::render(std::stop_token stop,
                          const Show& show,
                          std::promise<Result<void>>& ready) {
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
    auto arrived = arrived_.take(stop, kLookPeriod);
    const bool is_new = arrived.has_value();
    if (is_new) newest = *std::move(arrived);
    const Choice choice = choose(newest);
    const bool is_due = (is_new && !choice.is_still) || choice.view_version != drawn_version ||
                        Clock::now() >= next_still_at;
    if (!choice.shown.tracked.frame || !is_due) continue;
    next_still_at = Clock::now() + kStillPeriod;
    drawn_version = choice.view_version;
    draw(*renderers, choice, show);
  }
}

Result<LivePictures::Renderers> LivePictures::make_renderers() const {
  const RenderScene scene = scene_of(*body_);
  Renderers renderers;
  MOR_TRY(renderers.overlay, OverlayRenderer::create(scene));
  MOR_TRY(renderers.free, FreeViewRenderer::create(scene));
  return renderers;
}

LivePictures::Choice LivePictures::choose(const Arrival& newest) const {
  const std::lock_guard lock(mutex_);
  return {.shown = still_ ? *still_ : newest,
          .view = view_,
          .view_version = view_version_,
          .is_still = still_.has_value(),
          .is_free = view_.free.is_shown && !picking_landmarks_};
}

void LivePictures::draw(const Renderers& renderers, const Choice& choice, const Show& show) {
  const auto started = Clock::now();
  ShownPicture what = shown_picture(choice.shown.tracked, choice.view, choice.is_still);
  const auto picture = choice.is_free ? free_pictures_.draw(*renderers.free, what)
                                      : draw_overlay(*renderers.overlay, what);
  if (!picture) {
    log::error("the picture cannot be drawn: {}", picture.error().message);
    return;
  }
  const std::string marks = mark_ ? mark_(what) : std::string();
  show(*picture, {choice.shown.came_at, picture_json(what, marks)});
  keep_snapshot(*picture, what, marks);
  const std::chrono::duration<double, std::milli> took = Clock::now() - started;
  const std::lock_guard lock(mutex_);
  render_ms_.add(took.count());
  if (!choice.is_still) shown_rate_.count(Clock::now());
}

Result<ImageView<const Rgba8>> LivePictures::draw_overlay(OverlayRenderer& renderer,
                                                          const ShownPicture& what) {
  const TrackedFrame& shown = what.tracked;
  free_pictures_.pass_by(shown);
  return renderer.render(
      shown.frame->color.view(),
      overlay_view(
          *shown.frame, shown.ct_from_depth, shown.ct_from_ghost, what.view, what.is_still));
}

void LivePictures::keep_snapshot(ImageView<const Rgba8> picture,
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

}  // namespace mor
