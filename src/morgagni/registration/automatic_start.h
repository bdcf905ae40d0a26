// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"
#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/registration/fixed_surface.h"
#include "morgagni/registration/start.h"

namespace mor {

struct AutomaticStartOptions {
  /// Which way is down, frame depth, any length, where a device knows it: planes that are not
  /// level are then no tables, and no table need be seen.
  std::optional<Eigen::Vector3d> gravity = std::nullopt;
  /// The sides of the body that may lie on the table. Not empty.
  std::vector<BodySide> lying_on = {BodySide::kPosterior, BodySide::kAnterior};
  double max_distance_mm = 2000.0;  ///< Readings farther away are no body. 200..5000.
  int num_threads = 2;              ///< 1..64. The result is the same for any.

  [[nodiscard]] Result<void> check() const;
};

enum class AutomaticStartStatus : std::uint8_t {
  kFound,      ///< One pose explains the picture, and no other comes near.
  kAmbiguous,  ///< Several poses explain it about equally well.
  kNotFound,   ///< No pose explains it.
};

/// "found", "ambiguous", "not found".
[[nodiscard]] std::string_view to_string(AutomaticStartStatus status);

struct AutomaticStartResult {
  AutomaticStartStatus status = AutomaticStartStatus::kNotFound;
  /// To be used where the status is kFound; else the best of the poses that were refused.
  Eigen::Isometry3d ct_from_depth = Eigen::Isometry3d::Identity();
  double score = 0.0;  ///< Of that pose, up to 1: the CT's skin is seen all where it should.
  double runner_up_score = 0.0;  ///< Of the best pose elsewhere.
  std::string reason;            ///< Why there is no start, in a sentence for people; else empty.
};

namespace internal {
struct StartRecall;
}

/// What a search over several pictures keeps from one to the next: the last pictures, how the
/// camera moved between them, and poses that are not yet believed.
class StartMemory {
 public:
  StartMemory();
  StartMemory(StartMemory&&) noexcept;
  StartMemory& operator=(StartMemory&&) noexcept;
  ~StartMemory();

  /// Where the pictures that follow have nothing to do with those before.
  void forget();

 private:
  friend class AutomaticStart;
  std::unique_ptr<internal::StartRecall> recall_;
};

/// Finds the body in one depth picture: no landmarks, no placement, whatever the camera's place and
/// roll. The body lies on a table: it is searched for on the picture's planes, or where gravity is
/// known at all heights; the best poses are refined and verified by what the camera should and
/// should not see there.
///
/// No start is better than a wrong start: where the picture does not settle the pose it says so. A
/// search may go on in the next picture, from another place, and then judges by all of them.
class AutomaticStart {
 public:
  /// @param fixed  The CT's skin with its field. Shared, never changed.
  /// @errors kInvalidArgument: no skin or field, a bad camera, bad options.
  /// @cost About 50 ms.
  [[nodiscard]] static Result<AutomaticStart> create(std::shared_ptr<const FixedSurface> fixed,
                                                     const PinholeCamera& depth_camera,
                                                     const AutomaticStartOptions& options);
  AutomaticStart(AutomaticStart&&) noexcept;
  AutomaticStart& operator=(AutomaticStart&&) noexcept;
  ~AutomaticStart();

  /// @param depth_mm  Size of the camera's pictures; 0 = no reading.
  /// @errors kInvalidArgument: a size unlike the camera's; kCancelled: `stop` was asked to.
  /// @threads Reentrant. Uses `options.num_threads` workers; the result does not depend on them.
  /// @cost See docs/automatic-start.md.
  [[nodiscard]] Result<AutomaticStartResult> find(ImageView<const std::uint16_t> depth_mm,
                                                  std::stop_token stop = {}) const;

  /// The same in the next picture of a camera that moves on slowly, by some 50 mm and 6 degrees
  /// from picture to picture at the most, while the body and what lies on it stay. A pose must
  /// explain this picture and up to four of those before it, together; where the camera's motion is
  /// not clear, this picture alone counts, as in find().
  /// @param memory  Of the pictures before; takes this one in. Empty for the first.
  /// @threads One call at a time for a memory.
  [[nodiscard]] Result<AutomaticStartResult> find_next(ImageView<const std::uint16_t> depth_mm,
                                                       StartMemory& memory,
                                                       std::stop_token stop = {}) const;

 private:
  struct Impl;
  explicit AutomaticStart(std::unique_ptr<const Impl> impl);
  std::unique_ptr<const Impl> impl_;
};

}  // namespace mor
