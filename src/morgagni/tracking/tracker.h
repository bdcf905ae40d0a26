// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include <Eigen/Geometry>

#include "morgagni/camera/range_camera.h"
#include "morgagni/core/result.h"
#include "morgagni/depth/body_surface.h"
#include "morgagni/registration/fine_registration.h"

namespace mor {

enum class TrackingState : std::uint8_t {
  kWaiting,   ///< No start yet, or one that does not fit so far. There is no pose.
  kTracking,  ///< This frame was registered and passed the gate.
  kSkipped,   ///< This frame did not pass; the last valid pose is kept.
  kLost,      ///< No frame has passed for `lost_after`; the pose is no longer shown.
};

/// "waiting", "tracking", "skipped", "lost".
[[nodiscard]] std::string_view to_string(TrackingState state);

struct TrackingOptions {
  double residual_ratio = 1.5;  ///< alpha: e(t) must stay below alpha * e_valid (paper). > 1.
  std::chrono::milliseconds lost_after{2000};  ///< Without a valid frame. > 0.
  double start_max_rms_mm = 6.0;               ///< A start with a larger residual is no start. > 0.
  double start_min_explained = 0.6;  ///< Share of the points that a start must explain. (0, 1].

  [[nodiscard]] Result<void> check() const;
};

struct TrackingCounts {
  std::uint64_t tracked = 0;
  std::uint64_t skipped = 0;
  std::uint64_t lost = 0;
};

/// A frame and what tracking made of it.
struct TrackedFrame {
  std::shared_ptr<const RgbdFrame> frame;
  TrackingState state = TrackingState::kWaiting;
  std::optional<Eigen::Isometry3d>
      ct_from_depth;  ///< To be shown with this frame. None: show nothing.
  std::optional<Eigen::Isometry3d>
      ct_from_ghost;  ///< Where the start looks for the body, while it waits.
  std::optional<RegistrationResult> registration;  ///< Of this frame, passed or not.
  std::optional<double> valid_rms_mm;              ///< e_valid.
  TrackingCounts counts;
  double depth_ms = 0.0;
  double registration_ms = 0.0;
};

/// Follows the camera from frame to frame (paper, section 2, "Continuous fine registration").
///
/// Each frame is registered from the last valid pose, equation (1). The residual of the start is
/// kept as e_valid; a frame with e(t) >= alpha * e_valid is skipped. After `lost_after` without a
/// valid frame the tracking is lost; it resumes by itself as soon as the constraint holds again.
/// @threads None of its own; one call at a time.
class Tracker {
 public:
  /// @errors kInvalidArgument: bad options.
  [[nodiscard]] static Result<Tracker> create(const TrackingOptions& options,
                                              BodySurfaceExtractor extractor,
                                              std::unique_ptr<FineRegistration> registration);

  /// Looks for the body at this pose in every frame to come, until it fits (Glocker et al.).
  void start_by_placement(const Eigen::Isometry3d& ct_from_depth);

  /// Starts from a pose that belongs to `frame`, as landmarks give it.
  /// @errors kInvalidArgument: the surface does not fit there; says by how much. The state stays as
  /// it was.
  [[nodiscard]] Result<void> start_at(const RgbdFrame& frame,
                                      const Eigen::Isometry3d& ct_from_depth);

  /// @errors kInvalidArgument: a frame of another size than the camera's.
  [[nodiscard]] Result<TrackedFrame> process(std::shared_ptr<const RgbdFrame> frame);

 private:
  Tracker(const TrackingOptions& options,
          BodySurfaceExtractor extractor,
          std::unique_ptr<FineRegistration> registration);

  [[nodiscard]] bool is_a_start(const RegistrationResult& result) const;
  void begin(const RegistrationResult& result, std::chrono::steady_clock::time_point when);
  void judge(const RegistrationResult& result, std::chrono::steady_clock::time_point when);

  TrackingOptions options_;
  BodySurfaceExtractor extractor_;
  std::unique_ptr<FineRegistration> registration_;
  TrackingState state_ = TrackingState::kWaiting;
  std::optional<Eigen::Isometry3d> ct_from_ghost_;
  std::optional<Eigen::Isometry3d> last_valid_ct_from_depth_;
  double valid_rms_mm_ = 0.0;
  std::chrono::steady_clock::time_point last_valid_at_;
  TrackingCounts counts_;
};

}  // namespace mor
