// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include <Eigen/Geometry>

#include "morgagni/camera/infrared_source.h"
#include "morgagni/camera/range_camera.h"

namespace mor {

/// What is printed on a flat board: how bright it is where.
struct BoardPicture {
  Image<std::uint8_t> brightness;  ///< 0..255.
  double mm_per_px = 0.25;
  Eigen::Vector2d first_px_mm = Eigen::Vector2d::Zero();  ///< Centre of pixel (0, 0), frame board.
};

/// What is behind a simulated board.
enum class BoardBacking : std::uint8_t {
  kAir,    ///< It is held in the air.
  kWall,   ///< It hangs on a flat wall, its face 3 mm before it.
  kTurns,  ///< In the air for 36 poses, on the wall for 14, and so on, as a session goes.
};

/// What `simulated-board:key=value,...` sets; the keys stand in brackets.
struct SimulatedBoardOptions {
  std::uint64_t seed = 1;  ///< [seed] Of the cameras' truth, the poses and the noise.
  /// [sensor] kinect: structured light with the Kinect v1's noise (internal/kinect_noise.h) and an
  /// error that is linear in disparity; tof: time of flight, an offset and a wiggle.
  bool is_time_of_flight = false;
  /// [bias] 0..20: systematic depth error, root mean square over the picture at 800 mm.
  double bias_mm = 3.0;
  double blur_px = 0.6;  ///< [blur] 0..5: the lenses' blur, standard deviation.
  double grain = 2.0;    ///< [grain] 0..30: both pictures' noise, in brightness of 255.
  BoardBacking backing = BoardBacking::kTurns;  ///< [wall] 0: air | 1: wall | turns.
  double near_mm = 450.0;                       ///< [near] 250..3000: distance of the nearest and
  double far_mm = 1200.0;                       ///< [far] of the farthest poses.
  double tilt_deg = 35.0;                       ///< [tilt] 0..60: of the most tilted ones.
  double hold_s = 2.5;                          ///< [hold] 0.2..60: each pose is held so long.
  bool shows_infrared = false;  ///< [infrared] 0 | 1: the infrared picture in place of the colours.
  bool is_real_time = true;     ///< [speed] real | full.

  [[nodiscard]] static Result<SimulatedBoardOptions> parse(std::string_view text);
  /// @errors kInvalidArgument: a value outside its limits.
  [[nodiscard]] Result<void> check() const;
};

/// A range camera before which a calibration board is held in one pose after another. Its lenses
/// distort, it is not built as designed, and its depth is wrong in a smooth way: calibration() is
/// the design, truth() what it is. Whoever calibrates gets it as a RangeCamera.
class SimulatedBoardCamera : public RangeCamera, public InfraredSource {
 public:
  /// @errors kInvalidArgument: bad options, no picture.
  [[nodiscard]] static Result<std::unique_ptr<SimulatedBoardCamera>> create(
      BoardPicture board, const SimulatedBoardOptions& options);
  ~SimulatedBoardCamera() override;

  [[nodiscard]] Result<std::shared_ptr<const RgbdFrame>> next_frame(std::stop_token stop) override;
  [[nodiscard]] const RgbdCalibration& calibration() const override;
  [[nodiscard]] Result<Image<Rgb8>> infrared_picture(std::stop_token stop) override;

  /// Frame `repeat` of a pose, whoever asks and in whatever order. With `shows_infrared` its colour
  /// picture is the depth camera's infrared one.
  /// @threads Safe to call from many at once. @cost About 0.1 s.
  [[nodiscard]] std::shared_ptr<const RgbdFrame> frame_at(std::uint64_t pose,
                                                          std::uint64_t repeat) const;

  /// The depth camera's infrared picture of a pose, grey.
  [[nodiscard]] Image<Rgb8> infrared_at(std::uint64_t pose) const;

  /// The truth, for evaluations only.
  [[nodiscard]] const RgbdCalibration& truth() const;
  [[nodiscard]] Eigen::Isometry3d depth_from_board(std::uint64_t pose) const;
  /// What the sensor adds at a pixel to a true depth, mm.
  [[nodiscard]] double bias_mm(int x_px, int y_px, double z_mm) const;

 private:
  struct Impl;
  explicit SimulatedBoardCamera(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace mor
