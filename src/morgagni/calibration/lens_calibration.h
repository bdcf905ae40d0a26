// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/calibration/board.h"
#include "morgagni/calibration/board_finder.h"
#include "morgagni/core/result.h"
#include "morgagni/geometry/pinhole_camera.h"

namespace mor {

/// A board as one camera saw it.
struct LensView {
  std::string name;  ///< For people: "view 3", a file's name.
  BoardSighting sighting;
};

struct LensOptions {
  int min_views = 8;                  ///< >= 3.
  double max_edge_width_px = 4.5;     ///< Views more blurred than this are left out.
  double max_rms_px = 1.0;            ///< A set that fits worse is refused.
  double max_focal_sd_share = 0.004;  ///< A focal length less certain than this is refused.
  double min_tilt_deg = 12.0;  ///< The two views most tilted to each other must differ by so much.
};

/// A view's part in a calibration.
struct LensViewQuality {
  std::string name;
  double rms_px = 0.0;
  bool is_used = false;
  std::string reason;  ///< Why it was left out.
};

struct LensCalibration {
  PinholeCamera camera;
  PinholeCamera sd;              ///< Standard deviations, in the members of the same name.
  double rms_px = 0.0;           ///< Over all corners of the views used.
  double held_out_rms_px = 0.0;  ///< Of views that a calibration from the others did not see: the
                                 ///< pose from every other corner, the error at those between.
  std::vector<LensViewQuality> views;                               ///< In the order given.
  std::vector<std::optional<Eigen::Isometry3d>> camera_from_board;  ///< The same; none: left out.

  /// The held-out error at a metre.
  [[nodiscard]] double held_out_mm_at_1m() const {
    return 1000.0 * held_out_rms_px / camera.focal_x_px;
  }
};

/// A camera's focal lengths, centre and distortion (k1, k2, p1, p2) from views of a board (Zhang
/// 2000, by OpenCV).
/// @errors kInvalidArgument: the views do not determine them; says why, and what to do: too few,
///         all alike, all parallel, blurred, of several boards, a bent board.
/// @cost About 0.5 s for 20 views of 70 corners.
[[nodiscard]] Result<LensCalibration> calibrate_lens(const CalibrationBoard& board,
                                                     const std::vector<LensView>& views,
                                                     int width_px,
                                                     int height_px,
                                                     const LensOptions& options = {});

/// Where the board lies before a camera whose lens is known. None: the corners fit no pose.
[[nodiscard]] std::optional<Eigen::Isometry3d> camera_from_board(const CalibrationBoard& board,
                                                                 const BoardSighting& sighting,
                                                                 const PinholeCamera& camera);

/// Root mean square distance between the corners seen and those of the board at a pose.
[[nodiscard]] double reprojection_rms_px(const CalibrationBoard& board,
                                         const BoardSighting& sighting,
                                         const PinholeCamera& camera,
                                         const Eigen::Isometry3d& camera_from_board);

}  // namespace mor
