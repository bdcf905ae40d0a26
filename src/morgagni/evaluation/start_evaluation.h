// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/camera/range_camera.h"
#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/depth/body_surface.h"
#include "morgagni/evaluation/summary.h"
#include "morgagni/registration/automatic_start.h"
#include "morgagni/registration/fixed_surface.h"

namespace mor {

struct StartEvaluationOptions {
  AutomaticStartOptions start = {};
  /// Of the fine registration after the start.
  BodySurfaceOptions depth = {.far_mm = kHandHeldFarMm};
  bool knows_gravity = false;  ///< Each picture comes with the true direction of gravity, CT +y.
  /// Pictures of a moving camera that a start may take, one after the other, until one is found;
  /// 1..100.
  std::size_t frames_a_view = 1;
  double frame_period_ms = 200.0;  ///< From one such picture to the next; > 0.
  double right_mm = 5.0;   ///< A found pose this near to the truth is right: at the skin's centre
  double right_deg = 3.0;  ///< and in rotation.
  double wrong_tre_mm = 15.0;  ///< One with a larger target registration error is wrong.

  [[nodiscard]] Result<void> check() const;
};

/// A picture and the pose it was taken from; none: of another body, where no start is right.
struct StartView {
  std::shared_ptr<const RgbdFrame> frame;
  std::optional<Eigen::Isometry3d> ct_from_depth;
};
/// Picture `frame` of view `index` of those to be evaluated.
using StartViews = std::function<Result<StartView>(std::size_t index, std::size_t frame)>;

/// One automatic start.
struct StartRun {
  std::size_t view = 0;
  std::size_t num_frames = 0;  ///< Pictures it took. The rest is of the last of them.
  AutomaticStartResult result;
  bool is_other_body = false;  ///< Then the next five mean nothing.
  double shift_mm = 0.0;       ///< Of the skin's centre from where it is, whether found or refused.
  double rotation_deg = 0.0;   ///< Likewise.
  double tre_mm = 0.0;         ///< Of the pose as found, root mean square over the targets.
  /// Of the skin that the camera would see, what nothing hides: the less, the harder the start.
  double bare_share = 0.0;
  std::optional<double> fine_tre_mm;  ///< After fine registration; none for a refused start.
  bool is_right = false;              ///< Found, and near the truth as the options say.
  double wall_ms = 0.0;               ///< Sum over its pictures.
  double cpu_ms = 0.0;                ///< Likewise, of all the process's threads.
  double until_ms = 0.0;  ///< From the first picture to the end, waiting for pictures included.
};

struct StartReport {
  int num_views = 0;
  int num_right = 0;
  int num_near = 0;   ///< Found, neither right nor wrong.
  int num_wrong = 0;  ///< Found, and wrong or of another body: what must not be.
  int num_ambiguous = 0;
  int num_not_found = 0;
  int num_threads = 0;
  Summary shift_mm;  ///< Over the found, as the next two.
  Summary rotation_deg;
  Summary fine_tre_mm;
  Summary wall_ms;  ///< Over all.
  Summary cpu_ms;
  Summary until_ms;  ///< Over the found.
  std::vector<int> num_right_by_frame =
      {};  ///< Of those right, how many within 1, 2, ... pictures.
  std::vector<StartRun> runs;
};

/// Starts on every view, each for itself, with as many of its pictures as it needs and may take,
/// and holds the poses against the truth. Targets are a hundred points spread over the skin and a
/// hundred halfway between them and its centre.
/// @errors kInvalidArgument: bad options, no view, a case without field; whatever a view reports.
[[nodiscard]] Result<StartReport> evaluate_starts(const StartViews& views,
                                                  std::size_t num_views,
                                                  const std::shared_ptr<const FixedSurface>& fixed,
                                                  const StartEvaluationOptions& options,
                                                  const Progress& progress);

/// {"views","right","near","wrong","refused":{"ambiguous","not_found"},"shift_mm",...,"runs":[...]}.
[[nodiscard]] std::string to_json(const StartReport& report);

/// The same as a table to read, with the views that are not right.
[[nodiscard]] std::string to_table(const StartReport& report);

}  // namespace mor
