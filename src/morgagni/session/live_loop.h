// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/camera/range_camera.h"
#include "morgagni/casefile/case.h"
#include "morgagni/core/result.h"
#include "morgagni/registration/automatic_start.h"
#include "morgagni/registration/start.h"
#include "morgagni/session/free_pictures.h"
#include "morgagni/session/shown_picture.h"
#include "morgagni/session/touched_point.h"
#include "morgagni/session/view_settings.h"
#include "morgagni/stream/live_server.h"
#include "morgagni/tracking/tracker.h"

namespace mor {

/// How the tracking begins, and begins again after a loss.
enum class StartMethod : std::uint8_t {
  kAutomatic,  ///< Searched for in the depth picture.
  kPlacement,  ///< The body hangs before the camera; the user moves the camera to it.
};

struct LiveLoopOptions {
  BodySurfaceOptions depth;
  RegistrationOptions registration;
  TrackingOptions tracking;
  StartMethod start = StartMethod::kAutomatic;
  PlacementOptions placement;
  /// Every frame is processed, and a search is waited for: a recording gives the same poses each
  /// time. Else the newest frame counts, and the search goes on beside the tracking.
  bool in_step = false;
};

/// What the search for a start says, for the page.
struct SearchStatus {
  bool is_searching = false;
  std::optional<AutomaticStartStatus> last;  ///< Of the last search that ended. None: none yet.
  std::string reason;                        ///< Why it found no start, in words.
};

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
  std::uint64_t num_dropped = 0;  ///< Frames that a slower stage passed over.
  double wait_ms = 0.0;           ///< Medians of the last 60 frames: capture to tracking,
  double depth_ms = 0.0;          ///< depth image to body surface,
  double registration_ms = 0.0;   ///< registration,
  double judgement_ms = 0.0;      ///< judging the pose,
  double render_ms = 0.0;         ///< and drawing.
  std::optional<std::string> camera_error;
};

/// One live case: camera -> tracking -> picture, each in a thread of its own with a latest-value
/// slot between (docs/architecture.md, "Live path"). The functions may be called from any thread.
class LiveLoop {
 public:
  /// Takes a finished picture and what belongs to it. Called on the render thread.
  using Show = std::function<void(ImageView<const Rgba8>, const PictureInfo&)>;

  /// Looks at a tracked frame, in the order of the frames. Called on the tracking thread, which
  /// waits for it: it hands the frame on and returns at once.
  using Observe = std::function<void(const TrackedFrame&)>;

  /// Says what is marked on the body of a picture that is about to be shown: JSON that goes with
  /// the picture as its member `marks`. Called on the render thread, which waits for it.
  using Mark = std::function<std::string(const ShownPicture&)>;

  /// Makes the stages; nothing runs yet. @errors As the stages' own.
  [[nodiscard]] static Result<std::unique_ptr<LiveLoop>> create(std::shared_ptr<const Case> body,
                                                                std::unique_ptr<RangeCamera> camera,
                                                                const LiveLoopOptions& options);
  virtual ~LiveLoop() = default;

  /// From now on `observe` gets each frame that is tracked, whatever becomes of it. What it looks
  /// at must live until stop() has returned.
  virtual void observe(Observe observe) = 0;

  /// The same for the marks. Before run().
  virtual void mark(Mark mark) = 0;

  /// Where the free view takes the fused texture from. Before run().
  virtual void take_fused_from(FreePictures::Fused fused) = 0;

  /// Starts the threads. Returns once the renderer stands. @errors kDevice: no OpenGL.
  [[nodiscard]] virtual Result<void> run(Show show) = 0;

  /// Ends the threads; `show` is not called after this returns.
  virtual void stop() = 0;

  /// Under which the frames are tracked: the camera's own, until use_calibration().
  [[nodiscard]] virtual std::shared_ptr<const RgbdCalibration> calibration() const = 0;

  /// From the next frame on, frames are tracked under this calibration, whatever the camera says;
  /// the sensor's depth stays as it is (`as_sensed`). The tracking goes on.
  /// @param sensor_bias_mm  What is not known of its depth, for the error bound: 0..50; on top of
  /// the options'.
  /// @errors kInvalidArgument: pictures of another size, a camera or correction that is none.
  [[nodiscard]] virtual Result<void> use_calibration(
      std::shared_ptr<const RgbdCalibration> calibration, double sensor_bias_mm) = 0;

  /// Searches for the body in the depth picture, from now on and after each loss.
  virtual void start_automatically() = 0;

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

  /// What lies under a pixel of the picture shown, and how sure that is. In the free view it is
  /// what is seen there: the skin, or where that is cut away the inside.
  /// @errors kInvalidArgument: there is no pose, or no depth or body there.
  [[nodiscard]] virtual Result<TouchedPoint> touch(const Eigen::Vector2d& pixel) = 0;

  virtual void set_frozen(bool frozen) = 0;
  [[nodiscard]] virtual ViewSettings view() const = 0;
  virtual void set_view(const ViewSettings& view) = 0;

  /// The picture last shown. None before the first.
  [[nodiscard]] virtual std::optional<Snapshot> snapshot() const = 0;
  [[nodiscard]] virtual LiveStatus status() const = 0;
};

}  // namespace mor
