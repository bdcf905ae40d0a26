// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "morgagni/casefile/case.h"
#include "morgagni/core/latest_slot.h"
#include "morgagni/core/result.h"
#include "morgagni/core/statistics.h"
#include "morgagni/render/free_view.h"
#include "morgagni/render/overlay_renderer.h"
#include "morgagni/session/frame_rate.h"
#include "morgagni/session/free_pictures.h"
#include "morgagni/session/shown_picture.h"
#include "morgagni/session/touched_point.h"
#include "morgagni/session/view_settings.h"
#include "morgagni/stream/live_server.h"
#include "morgagni/tracking/tracker.h"

namespace mor {

/// What the live case shows: the newest tracked frame, or one that is held still, drawn as the
/// view says by a thread of its own. The functions may be called from any thread.
class LivePictures {
 public:
  using Clock = std::chrono::steady_clock;
  /// As LiveLoop's.
  using Show = std::function<void(ImageView<const Rgba8>, const PictureInfo&)>;
  using Mark = std::function<std::string(const ShownPicture&)>;

  struct State {
    TrackedFrame last;  ///< Newest tracked frame; its `frame` is null before the first.
    bool frozen = false;
    bool picking_landmarks = false;
    double frame_rate = 0.0;        ///< Pictures of new frames a second.
    double render_ms = 0.0;         ///< Median of the last pictures.
    std::uint64_t num_dropped = 0;  ///< Tracked frames that were not drawn.
  };

  explicit LivePictures(std::shared_ptr<const Case> body);

  void mark(Mark mark) { mark_ = std::move(mark); }
  void take_fused_from(FreePictures::Fused fused) {
    free_pictures_.take_fused_from(std::move(fused));
  }

  /// Starts the thread. Returns once the renderer stands. @errors kDevice: no OpenGL.
  [[nodiscard]] Result<void> run(Show show);
  void stop() { thread_ = {}; }

  /// The newest frame. @param came_at  From when on its age counts.
  void put(TrackedFrame tracked, Clock::time_point came_at);

  [[nodiscard]] ViewSettings view() const;
  void set_view(const ViewSettings& view);
  void set_frozen(bool frozen);

  /// Holds the newest frame still, without overlay, for landmarks to be tapped on.
  /// @errors kInvalidArgument: no frame has arrived yet.
  [[nodiscard]] Result<void> begin_landmarks();
  /// The frame held for it. @errors kInvalidArgument: not begun.
  [[nodiscard]] Result<std::shared_ptr<const RgbdFrame>> landmark_frame() const;
  void end_landmarks();

  /// As LiveLoop::touch.
  [[nodiscard]] Result<TouchedPoint> touch(const Eigen::Vector2d& pixel) const;

  /// The picture last shown. None before the first.
  [[nodiscard]] std::optional<Snapshot> snapshot() const;
  [[nodiscard]] State state() const;
  /// As FreePictures'.
  [[nodiscard]] std::optional<double> colors_age_ms() const {
    return free_pictures_.colors_age_ms();
  }

 private:
  struct Arrival {
    TrackedFrame tracked;
    Clock::time_point came_at = {};  ///< From when on the frame's age counts.
  };

  struct Renderers {
    std::unique_ptr<OverlayRenderer> overlay;
    std::unique_ptr<FreeViewRenderer> free;
  };

  struct Choice {
    Arrival shown;
    ViewSettings view;
    std::uint64_t view_version = 0;
    bool is_still = false;
    bool is_free = false;
  };

  void render(std::stop_token stop, const Show& show, std::promise<Result<void>>& ready);
  [[nodiscard]] Result<Renderers> make_renderers() const;
  [[nodiscard]] Choice choose(const Arrival& newest) const;
  void draw(const Renderers& renderers, const Choice& choice, const Show& show);
  [[nodiscard]] Result<ImageView<const Rgba8>> draw_overlay(OverlayRenderer& renderer,
                                                            const ShownPicture& what);
  void keep_snapshot(ImageView<const Rgba8> picture,
                     const ShownPicture& what,
                     const std::string& marks);

  const std::shared_ptr<const Case> body_;
  FreePictures free_pictures_;
  Mark mark_;
  LatestSlot<Arrival> arrived_;

  mutable std::mutex mutex_;  ///< Guards everything down to the next blank line.
  ViewSettings view_;
  std::uint64_t view_version_ = 0;
  Arrival last_;
  std::optional<Arrival> still_;  ///< Shown instead of the newest.
  bool picking_landmarks_ = false;
  FrameRate shown_rate_;
  RollingWindow render_ms_;

  mutable std::mutex picture_mutex_;
  std::optional<Snapshot> snapshot_;

  std::jthread thread_;  ///< Ends first: it is destroyed before what it uses.
};

}  // namespace mor
