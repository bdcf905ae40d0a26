// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/camera/range_camera.h"
#include "morgagni/casefile/case.h"
#include "morgagni/core/latest_slot.h"
#include "morgagni/core/result.h"
#include "morgagni/core/statistics.h"
#include "morgagni/registration/start.h"
#include "morgagni/session/live_pictures.h"
#include "morgagni/session/live_tracking.h"
#include "morgagni/session/touched_point.h"
#include "morgagni/session/view_settings.h"
#include "morgagni/tracking/tracker.h"

namespace mor {

/// In step (`in_step`) also every frame is processed; else the newest counts.
using LiveLoopOptions = LiveTrackingOptions;

/// What goes on, for the page.
struct LiveStatus {
  TrackedFrame last;  ///< Newest tracked frame; its `frame` is null before the first.
  bool frozen = false;
  bool picking_landmarks = false;
  SearchStatus search;
  /// Error bound on the skin in the middle of the hole, of the newest frame.
  std::optional<double> bound_mm;
  /// Age of the picture whose colours the free view shows. None: it has had no good one yet.
  std::optional<double> colors_age_ms;
  double frame_rate = 0.0;
  std::uint64_t num_dropped;     ///< Frames that a slower stage passed over.
  double wait_ms = 0.0;          ///< Medians of the last 60 frames: capture to tracking,
  double depth_ms = 0.0;         ///< depth image to body surface,
  double registration_ms = 0.0;  ///< registration,
  double judgement_ms = 0.0;     ///< judging the pose,
  double render_ms = 0.0;        ///< and drawing.
  std::optional<std::string> camera_error;
};

/// One live case: camera -> tracking -> picture, each in a thread of its own with a latest-value
/// slot between (docs/architecture.md, "Live path"). The functions may be called from any thread.
class LiveLoop {
 public:
  /// Takes a finished picture and what belongs to it. Called on the render thread.
  using Show = LivePictures::Show;

  /// Looks at a tracked frame, in the order of the frames. Called on the tracking thread, which
  /// waits for it: it hands the frame on and returns at once.
  using Observe = std::function<void(const TrackedFrame&)>;

  /// Says what is marked on the body of a picture that is about to be shown: JSON that goes with
  /// the picture as its member `marks`. Called on the render thread, which waits for it.
  using Mark = LivePictures::Mark;

  /// Makes the stages; nothing runs yet. @errors As the stages' own.
  [[nodiscard]] static Result<std::unique_ptr<LiveLoop>> create(std::shared_ptr<const Case> body,
                                                                std::unique_ptr<RangeCamera> camera,
                                                                const LiveLoopOptions& options);
  ~LiveLoop();

  /// From now on `observe` gets each frame that is tracked, whatever becomes of it. What it looks
  /// at must live until stop() has returned.
  void observe(Observe observe);

  /// The same for the marks. Before run().
  void mark(Mark mark);

  /// Where the free view takes the fused texture from. Before run().
  void take_fused_from(FreePictures::Fused fused);

  /// Starts the threads. Returns once the renderer stands. @errors kDevice: no OpenGL.
  [[nodiscard]] Result<void> run(Show show);

  /// Ends the threads; `show` is not called after this returns.
  void stop();

  /// Under which the frames are tracked: the camera's own, until use_calibration().
  [[nodiscard]] std::shared_ptr<const RgbdCalibration> calibration() const;

  /// To which the frames are registered: the CT's, until use_calibration().
  [[nodiscard]] std::shared_ptr<const FixedSurface> skin() const;

  /// From the next frame on, frames are tracked under this calibration, whatever the camera says;
  /// the sensor's depth stays as it is (`as_sensed`). The tracking goes on.
  /// @param skin  The case's, or as it was found to be now. What is drawn, saved and exported of
  /// the body stays the CT's.
  /// @param sensor_bias_mm  What is not known of its depth, for the error bound: 0..50; on top of
  /// the options'.
  /// @errors kInvalidArgument: pictures of another size, a camera or correction that is none.
  [[nodiscard]] Result<void> use_calibration(std::shared_ptr<const RgbdCalibration> calibration,
                                             std::shared_ptr<const FixedSurface> skin,
                                             double sensor_bias_mm);

  /// From the next frame on, so much is not known of the depth, for the error bound: 0..50, on top
  /// of the options'. Takes the place of what use_calibration() was told. Never waits.
  void expect_bias(double sensor_bias_mm);

  /// Searches for the body in the depth picture, from now on and after each loss.
  void start_automatically();

  /// Looks for the body where it is placed. @errors kInvalidArgument: bad options.
  [[nodiscard]] Result<void> start_by_placement(const PlacementOptions& options);

  /// Freezes the picture, without overlay, so that landmarks can be tapped on it.
  /// @errors kInvalidArgument: no frame has arrived yet.
  [[nodiscard]] Result<void> begin_landmarks();
  /// The surface point at a pixel of the frozen colour picture, frame depth. @errors
  /// kInvalidArgument: no reading there.
  [[nodiscard]] Result<Eigen::Vector3d> pick_landmark(const Eigen::Vector2d& color_pixel);
  /// Starts from the pairs on the frozen frame. @errors As start_from_landmarks and
  /// Tracker::start_at.
  [[nodiscard]] Result<void> accept_landmarks(const std::vector<LandmarkPair>& pairs);
  void cancel_landmarks();

  /// What lies under a pixel of the picture shown, and how sure that is. In the free view it is
  /// what is seen there: the skin, or where that is cut away the inside.
  /// @errors kInvalidArgument: there is no pose, or no depth or body there.
  [[nodiscard]] Result<TouchedPoint> touch(const Eigen::Vector2d& pixel);

  void set_frozen(bool frozen);
  [[nodiscard]] ViewSettings view() const;
  void set_view(const ViewSettings& view);

  /// The picture last shown. None before the first.
  [[nodiscard]] std::optional<Snapshot> snapshot() const;
  [[nodiscard]] LiveStatus status() const;

 private:
  using Clock = std::chrono::steady_clock;
  using FramePtr = std::shared_ptr<const RgbdFrame>;

  LiveLoop(std::shared_ptr<const Case> body,
           std::unique_ptr<RangeCamera> camera,
           std::unique_ptr<LiveTracking> tracking,
           bool in_step);

  void set_camera_error(std::optional<std::string> sentence);
  [[nodiscard]] FramePtr next_frame(std::stop_token stop);
  void capture(std::stop_token stop);
  void track(std::stop_token stop);
  void count_times(const TrackedFrame& tracked, double wait_ms);
  void tell_observers(const TrackedFrame& tracked);

  const std::unique_ptr<RangeCamera> camera_;
  const bool in_step_;
  const std::unique_ptr<LiveTracking> tracking_;
  LivePictures pictures_;
  LatestSlot<FramePtr> captured_;

  mutable std::mutex mutex_;  ///< Guards everything down to the next blank line.
  std::optional<std::string> camera_error_;
  RollingWindow wait_ms_;
  RollingWindow depth_ms_;
  RollingWindow registration_ms_;
  RollingWindow judgement_ms_;

  std::mutex observers_mutex_;
  std::vector<Observe> observers_;

  std::mutex retry_mutex_;
  std::jthread
      tracking_thread_;  ///< The threads end first: they are destroyed before what they use.
  std::jthread capture_thread_;
};

}  // namespace mor
