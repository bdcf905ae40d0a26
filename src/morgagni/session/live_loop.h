// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/camera/range_camera.h"
#include "morgagni/casefile/case.h"
#include "morgagni/core/result.h"
#include "morgagni/registration/start.h"
#include "morgagni/session/view_settings.h"
#include "morgagni/stream/live_server.h"
#include "morgagni/tracking/tracker.h"

namespace mor {

struct LiveLoopOptions {
  BodySurfaceOptions depth;
  RegistrationOptions registration;
  TrackingOptions tracking;
  PlacementOptions placement;  ///< Of the start that is tried from the first frame on.
};

/// What goes on, for the page.
struct LiveStatus {
  TrackedFrame last;  ///< Newest tracked frame; its `frame` is null before the first.
  bool frozen = false;
  bool picking_landmarks = false;
  double frame_rate = 0.0;
  std::uint64_t num_dropped = 0;  ///< Frames that a slower stage passed over.
  double wait_ms = 0.0;           ///< Medians of the last 60 frames: capture to tracking,
  double depth_ms = 0.0;          ///< depth image to body surface,
  double registration_ms = 0.0;   ///< registration,
  double render_ms = 0.0;         ///< and drawing.
  std::optional<std::string> camera_error;
};

/// One live case: camera -> tracking -> picture, each in a thread of its own with a latest-value
/// slot between (docs/architecture.md, "Live path"). The functions may be called from any thread.
class LiveLoop {
 public:
  /// Takes a finished picture and what belongs to it. Called on the render thread.
  using Show = std::function<void(ImageView<const Rgba8>, const PictureInfo&)>;

  /// Makes the stages; nothing runs yet. @errors As the stages' own.
  [[nodiscard]] static Result<std::unique_ptr<LiveLoop>> create(std::shared_ptr<const Case> body,
                                                                std::unique_ptr<RangeCamera> camera,
                                                                const LiveLoopOptions& options);
  virtual ~LiveLoop() = default;

  /// Starts the threads. Returns once the renderer stands. @errors kDevice: no OpenGL.
  [[nodiscard]] virtual Result<void> run(Show show) = 0;

  /// Ends the threads; `show` is not called after this returns.
  virtual void stop() = 0;

  /// Looks for the body where it is placed. @errors kInvalidArgument: bad options.
  [[nodiscard]] virtual Result<void> start_by_placement(const PlacementOptions& options) = 0;

  /// Freezes the picture, without overlay, so that landmarks can be tapped on it.
  /// @errors kInvalidArgument: no frame has arrived yet.
  [[nodiscard]] virtual Result<void> begin_landmarks() = 0;
  /// The surface point at a pixel of the frozen colour picture, frame depth. @errors
  /// kInvalidArgument: no reading there.
  [[nodiscard]] virtual Result<Eigen::Vector3d> pick_landmark(
      const Eigen::Vector2d& color_pixel) = 0;
  /// Starts from the pairs on the frozen frame. @errors As start_from_landmarks and
  /// Tracker::start_at.
  [[nodiscard]] virtual Result<void> accept_landmarks(const std::vector<LandmarkPair>& pairs) = 0;
  virtual void cancel_landmarks() = 0;

  virtual void set_frozen(bool frozen) = 0;
  [[nodiscard]] virtual ViewSettings view() const = 0;
  virtual void set_view(const ViewSettings& view) = 0;

  /// The picture last shown. Empty before the first.
  [[nodiscard]] virtual Image<Rgba8> snapshot() const = 0;
  [[nodiscard]] virtual LiveStatus status() const = 0;
};

}  // namespace mor
