// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/result.h"
#include "morgagni/registration/fine_registration.h"
#include "morgagni/tracking/error_bound.h"
#include "morgagni/tracking/skin_evidence.h"

namespace mor {

/// How a frame is judged.
enum class TrackingGate : std::uint8_t {
  kResidual,  ///< The paper's: the residual against that of the start, and nothing else.
  kEvidence,  ///< Ours: everything below. Methods without information are judged by the residual.
};

/// Why a frame's pose is not to be trusted fully, or at all.
enum class Doubt : std::uint8_t {
  kNoBody,         ///< Too little surface to register, or registration found no pose.
  kResidual,       ///< The surface does not lie on the skin as exactly as it should.
  kLittleSeen,     ///< Little of the body is seen: covered, mostly out of view, or a wrong pose.
  kUnexplained,    ///< Most of what the camera sees is not this body.
  kFloating,       ///< At this pose skin would float before what the camera sees.
  kOpenDirection,  ///< The shape in view leaves the body free to slide or turn.
  kJump,           ///< The camera would have moved faster than a hand does.
};

/// "no-body", "residual", "little-seen", "unexplained", "floating", "open-direction", "jump".
[[nodiscard]] std::string_view to_string(Doubt doubt);

enum class Verdict : std::uint8_t {
  kGood,
  kWeak,  ///< The pose may be shown, with its doubts.
  kBad,   ///< The pose must not be shown.
};

struct Judgement {
  Verdict verdict = Verdict::kGood;
  std::vector<Doubt> doubts;
};

/// Below (or above) the first value of a pair the frame is weak, beyond the second it is bad.
/// Chosen on right and wrong poses of the recordings in `synthetic_rgbd`
/// (docs/adr/0010-tracking.md).
struct JudgementLimits {
  struct Pair {
    double weak;
    double bad;
  };
  Pair seen_fraction = {0.5, 0.25};        ///< At least. Of the skin expected.
  Pair seen_share = {0.06, 0.03};          ///< At least. Of all the body's skin.
  Pair explained_fraction = {0.15, 0.06};  ///< At least. Of what the camera sees.
  Pair floating_fraction = {0.04, 0.10};   ///< At most. Of the skin that nothing covers.
  Pair behind_fraction = {0.03, 0.12};     ///< At most. Of the patches of skin seen.
  Pair residual_scale = {2.0, 4.0};        ///< At most. Residual over the sensor's noise.
  /// At most. Right poses have 1 to 2, with a sensor's bias too; a hand fitted as skin had 7.
  Pair unevenness = {3.0, 10.0};
  double open_bound_mm = 5.0;  ///< A larger error bound at the skin seen is weak.
  double flat_mm = 5.0;  ///< A surface that leaves its plane by less, root mean square, is weak.
  double speed_mm_per_s = 1500.0;  ///< Of the skin seen, against the camera. Faster is weak.
  double turn_rad_per_s = 3.0;     ///< Faster is weak.
  double free_jump_mm = 15.0;      ///< Allowed whatever the time between.
  double free_turn_rad = 0.06;

  [[nodiscard]] Result<void> check() const;
};

/// Where the pose was expected, and how long after the last one.
struct ExpectedPose {
  Eigen::Isometry3d ct_from_depth;
  std::chrono::duration<double> since_last;
};

/// All that is known of a frame's pose.
struct FrameEvidence {
  RegistrationResult result;
  SkinEvidence skin;
  std::optional<PoseCovariance> covariance;  ///< None where the data leaves a direction open.
  double surface_relief_mm = 0.0;            ///< See relief_mm().
  std::optional<ExpectedPose> expected;      ///< None where there is nothing to jump from: a start.
};

/// Judges a registered pose by all that is known of it; each item alone can make it weak or bad.
[[nodiscard]] Judgement judge_evidence(const FrameEvidence& evidence,
                                       const JudgementLimits& limits = {});

/// How far a surface leaves its own plane, root mean square: what is flat fits anything flat.
/// @cost About 20 us.
[[nodiscard]] double relief_mm(const PointCloud& surface);

}  // namespace mor
