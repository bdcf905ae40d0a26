// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/camera/range_camera.h"
#include "morgagni/core/result.h"
#include "morgagni/depth/body_surface.h"
#include "morgagni/geometry/depth_levels.h"
#include "morgagni/registration/fine_registration.h"
#include "morgagni/tracking/judgement.h"
#include "morgagni/tracking/motion.h"
#include "morgagni/tracking/resume_starts.h"

namespace mor {

enum class TrackingState : std::uint8_t {
  kWaiting,    ///< No start yet, or one that does not fit so far. There is no pose.
  kTracking,   ///< This frame was registered and judged good.
  kUncertain,  ///< There is a pose, with doubts: this frame's own, or the last good one, held.
  kLost,       ///< No frame could be used for `lost_after`; the pose is no longer shown.
};

/// "waiting", "tracking", "uncertain", "lost".
[[nodiscard]] std::string_view to_string(TrackingState state);

struct TrackingOptions {
  TrackingGate gate = TrackingGate::kEvidence;
  JudgementLimits limits;
  static constexpr double kMostSensorBiasMm = 50.0;
  /// Systematic error of the sensor's depth where it is known, root mean square: widens the error
  /// bound. 0..kMostSensorBiasMm.
  double sensor_bias_mm = 0.0;
  double residual_ratio = 1.5;  ///< kResidual: e(t) must stay below alpha * e_valid (paper). > 1.
  std::chrono::milliseconds lost_after{500};  ///< Without a usable frame. > 0.
  double start_max_rms_mm = 6.0;              ///< A start with a larger residual is no start. > 0.
  double start_min_explained = 0.6;  ///< kResidual: share of the points that a start must explain.
                                     ///< (0, 1].

  [[nodiscard]] Result<void> check() const;
};

struct TrackingCounts {
  std::uint64_t tracked = 0;
  std::uint64_t uncertain = 0;
  std::uint64_t lost = 0;     ///< Times, not frames.
  std::uint64_t resumed = 0;  ///< Times the body was found again without a start.
};

/// A frame and what tracking made of it.
struct TrackedFrame {
  std::shared_ptr<const RgbdFrame> frame;     ///< Its depth is corrected (depth_corrected).
  std::shared_ptr<const FixedSurface> fixed;  ///< The skin that it was registered to.
  TrackingState state = TrackingState::kWaiting;
  std::optional<Eigen::Isometry3d>
      ct_from_depth;          ///< To be shown with this frame. None: show nothing.
  bool is_held = false;       ///< The pose is an earlier frame's: this one gave none.
  std::vector<Doubt> doubts;  ///< Of this frame, empty where it is good.
  std::optional<PoseCovariance> covariance;  ///< Of the pose. None: there is no error bound.
  std::optional<Eigen::Isometry3d>
      ct_from_ghost;  ///< Where the start looks for the body, while it waits.
  std::optional<RegistrationResult> registration;  ///< Of this frame, used or not.
  std::optional<SkinEvidence> skin;                ///< At that registration's pose.
  std::optional<double> valid_rms_mm;              ///< e_valid.
  /// Neither the last pose nor its surroundings explain this frame: only a new start would.
  bool needs_start = false;
  TrackingCounts counts;
  double depth_ms = 0.0;
  double registration_ms = 0.0;  ///< All that it tried.
  double judgement_ms = 0.0;
};

/// Follows the camera from frame to frame (paper, section 2, "Continuous fine registration").
///
/// Each frame is registered from where the camera's motion puts it, and judged (judgement.h). A
/// frame that is bad is tried again from other poses around the last one; where none fits, the last
/// pose is held, and after `lost_after` the tracking is lost. It resumes by itself as soon as a
/// frame fits well. With kResidual it does what the paper does: registered from the last valid
/// pose, equation (1), a frame with e(t) >= alpha * e_valid holds the pose.
/// @threads None of its own; one call at a time.
class Tracker {
 public:
  /// @param fixed  Whose skin the frames are judged by. Shared, never changed.
  /// @errors kInvalidArgument: bad options, a surface without mesh or normals.
  [[nodiscard]] static Result<Tracker> create(const TrackingOptions& options,
                                              std::shared_ptr<const FixedSurface> fixed,
                                              BodySurfaceExtractor extractor,
                                              std::unique_ptr<FineRegistration> registration);

  /// Goes on under another calibration, the pose as it was: it is off by millimetres only.
  /// @param extractor  Of the frames to come.
  void use_camera(BodySurfaceExtractor extractor) { extractor_ = std::move(extractor); }

  /// Goes on against the skin as it is known to be now, the pose as it was.
  /// @param fixed  As create(). @param registration  To it.
  void use_skin(std::shared_ptr<const FixedSurface> fixed,
                std::unique_ptr<FineRegistration> registration);

  /// What is not known of the camera's depth, for the bounds of the frames to come.
  /// @errors kInvalidArgument: outside the options' limits.
  [[nodiscard]] Result<void> expect_bias(double sensor_bias_mm);

  /// Forgets the pose and waits for a start.
  void wait_for_start();

  /// Looks for the body at this pose in every frame to come, until it fits (Glocker et al.).
  void start_by_placement(const Eigen::Isometry3d& ct_from_depth);

  /// Starts from a pose that belongs to `frame`, as landmarks give it.
  /// @errors kInvalidArgument: the surface does not fit there; says by how much. The state stays as
  /// it was.
  [[nodiscard]] Result<void> start_at(const std::shared_ptr<const RgbdFrame>& frame,
                                      const Eigen::Isometry3d& ct_from_depth);

  /// Tries a pose that was found in a frame that process() gave, maybe a while ago, on the frames
  /// to come: it is used once it fits one of them well, and forgotten when it fits none of the next
  /// few.
  void offer_start(const RgbdFrame& frame, const Eigen::Isometry3d& ct_from_depth);

  /// @errors kInvalidArgument: a frame of another size than the camera's.
  [[nodiscard]] Result<TrackedFrame> process(std::shared_ptr<const RgbdFrame> frame);

 private:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// A surface of a frame, to try poses on.
  struct Scene {
    const RgbdFrame& frame;
    BodySurface surface;
    double relief_mm = 0.0;
  };
  /// A pose tried.
  struct Attempt : FrameEvidence {
    Judgement judgement;
  };
  struct Offer {
    LastSeen seen;
    int frames_left = 0;
  };

  Tracker(const TrackingOptions& options,
          std::shared_ptr<const FixedSurface> fixed,
          BodySurfaceExtractor extractor,
          std::unique_ptr<FineRegistration> registration);

  /// The surface where the body is expected; none: from the picture's centre.
  [[nodiscard]] Result<Scene> segment(const RgbdFrame& frame,
                                      const std::optional<Eigen::Isometry3d>& expected);
  [[nodiscard]] Result<Attempt> attempt(const Scene& scene,
                                        const Eigen::Isometry3d& start,
                                        StartQuality quality,
                                        const std::optional<ExpectedPose>& expected = {});
  [[nodiscard]] Result<Attempt> attempt_there(const RgbdFrame& frame,
                                              const Eigen::Isometry3d& ct_from_depth);
  [[nodiscard]] Result<Attempt> attempt_around(const Scene& scene, const LastSeen& last);
  [[nodiscard]] Result<Attempt> attempt_frame(const Scene& scene);
  [[nodiscard]] Judgement judged(const FrameEvidence& evidence) const;
  [[nodiscard]] bool is_a_start(const Attempt& attempt) const;
  [[nodiscard]] bool judges_by_residual(const RegistrationResult& result) const;
  /// Where to look for the body; none: anywhere.
  [[nodiscard]] std::optional<Eigen::Isometry3d> expected_pose(const RgbdFrame& frame) const;
  void begin(const Attempt& attempt, TimePoint when);
  void use(const Attempt& attempt, TimePoint when);
  void take(const Attempt& attempt, TimePoint when);
  void miss(TimePoint when);

  TrackingOptions options_;
  std::shared_ptr<const FixedSurface> fixed_;
  SkinSamples samples_;
  BodySurfaceExtractor extractor_;
  DepthLevels levels_;  ///< Of the camera, for corrections of its depth.
  std::unique_ptr<FineRegistration> registration_;
  TrackingState state_ = TrackingState::kWaiting;
  std::optional<Eigen::Isometry3d> ct_from_ghost_;
  std::optional<Offer> offer_;
  Motion motion_;
  Eigen::Vector3d seen_center_mm_ = Eigen::Vector3d::Zero();
  std::optional<PoseCovariance> covariance_;
  double valid_rms_mm_ = 0.0;
  std::size_t round_ = 0;  ///< Of the poses tried around the last one.
  int num_missed_ = 0;     ///< Frames since the last used one.
  double judgement_ms_ = 0.0;
  TrackingCounts counts_;
};

}  // namespace mor
