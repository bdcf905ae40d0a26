// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "morgagni/calibration/board.h"
#include "morgagni/calibration/coverage.h"
#include "morgagni/calibration/rig_calibration.h"
#include "morgagni/camera/range_camera.h"

namespace mor {

struct CollectorOptions {
  WantedViews wanted = {.in_hand = 24, .on_wall = 10};  ///< Until the coverage is called enough.
  int still_frames = 4;   ///< The board must lie still for so many frames before it is taken.
  double still_px = 1.2;  ///< Corners that move less, from frame to frame, lie still.
  double max_edge_width_px = 3.5;  ///< A more blurred board is not taken.
  double new_pose_px = 25.0;  ///< Corners must lie so far, in the mean, from those of every view
                              ///< taken; a tilt or a step nearer counts as well.
};

/// Which of the poses seen are taken.
enum class Taking : std::uint8_t {
  kNothing,   ///< It only looks.
  kNewPoses,  ///< Each that is unlike those taken before.
  kThisPose,  ///< The one held now, even if it is like another.
};

/// What a live picture is worth for the calibration.
struct LiveLook {
  std::optional<BoardSighting> sighting;
  bool is_still = false;
  bool is_new = false;  ///< No view taken is like it.
  bool was_taken = false;
  std::string say;  ///< To the person who holds the board, in plain words.
};

/// Gathers views of a board from a live camera: looks at each frame, and takes those in which the
/// board is sharp, still and held in a new way. The depth of the still frames is averaged.
class ViewCollector {
 public:
  /// The infrared picture that belongs to the pose held now; none: the device has none to give.
  using Infrared = std::function<std::optional<Image<Rgb8>>()>;

  ViewCollector(const CalibrationBoard& board,
                const RgbdCalibration& by_design,
                const CollectorOptions& options = {});

  /// @param infrared  Asked when a view is about to be taken.
  LiveLook look(const RgbdFrame& frame,
                Taking taking = Taking::kNewPoses,
                const Infrared& infrared = {});

  /// Adds a view whose pictures are known to belong together. @return Why it is not used; empty:
  /// it is.
  std::string add(const std::string& name,
                  const Image<Rgb8>* color,
                  const Image<Rgb8>* infrared,
                  const Image<std::uint16_t>* depth_mm);

  /// Takes the last view back.
  void drop_last();

  [[nodiscard]] const std::vector<RigView>& views() const { return views_; }
  [[nodiscard]] Coverage coverage() const;
  [[nodiscard]] const CalibrationBoard& board() const { return board_; }
  [[nodiscard]] const RgbdCalibration& by_design() const { return by_design_; }
  [[nodiscard]] Result<RigCalibration> solve(const RigOptions& options = {}) const;

 private:
  [[nodiscard]] bool is_on_wall(const RigView& view) const;
  void keep(RigView view);
  [[nodiscard]] bool is_like_one_taken(const BoardSighting& sighting) const;
  void take(const Infrared& infrared);

  CalibrationBoard board_;
  RgbdCalibration by_design_;
  CollectorOptions options_;
  DepthReader reader_;  ///< Of the design.
  std::vector<RigView> views_;
  std::vector<bool> on_wall_;  ///< In the same order: the board lies on a wide flat thing.
  std::optional<BoardSighting> last_;
  int num_still_ = 0;
  Image<float> depth_sum_mm_;
  Image<std::uint8_t> depth_count_;
};

}  // namespace mor
