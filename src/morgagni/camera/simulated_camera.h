// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include <Eigen/Geometry>

#include "morgagni/camera/range_camera.h"

namespace mor {

enum class SimulatedPath : std::uint8_t {
  kOrbit,  ///< A hand that looks at the body from several sides.
  kSway,   ///< A hand that tries to hold still.
  kStill,  ///< A tripod.
  kViews,  ///< No path: each frame from a random place of its own (internal/view_places.h).
  kPass,   ///< A hand that documents: around the body from one side to the other, in 100 s or so.
  kSweep,  ///< A hand that calibrates: near and far, rolled, the body all over the picture.
};

/// What the camera sees and the CT does not have, in depth and colour. Made anew for every frame of
/// `path=views`; on a path it is one arrangement, in which the hand moves slowly.
enum class SimulatedClutter : std::uint8_t {
  kNone,
  kHand,   ///< A gloved hand with its forearm rests on the body or hovers over it.
  kTowel,  ///< A draped towel covers part of the body.
  kParts,  ///< The body goes on where the CT ends; a tray, a bottle and blocks lie beside it.
  kAll,
};

/// How the skin is painted.
enum class SimulatedSkin : std::uint8_t {
  kPlain,   ///< Soft patches and grain: nothing that a picture could be found out of place by.
  kMarked,  ///< With freckles, fine lines and bruises, which hold still as a body's do.
};

/// What `simulated:key=value,...` sets; the keys stand in brackets.
struct SimulatedCameraOptions {
  std::uint64_t seed = 1;      ///< [seed] Path, noise and looks. The same seed, the same frames.
  int width_px = 640;          ///< [width] 64..1920.
  int height_px = 480;         ///< [height] 48..1080.
  double frames_per_s = 30.0;  ///< [fps] 1..120.
  std::optional<double> distance_mm =
      std::nullopt;  ///< [distance] To the body's foremost point at the start,
                     ///< 400..1500; by default far enough for the body to fit. With path=views
                     ///< to the skin looked at, by default 500..1200 at random.
  SimulatedPath path = SimulatedPath::kOrbit;  ///< [path] orbit | sway | still | views | pass |
                                               ///< sweep.
  /// [hold] 1..1000: with path=views a hand holds the camera at each place for so many frames and
  /// drifts slowly, while the clutter stays as it is.
  std::uint64_t frames_a_view = 1;
  /// [walk] 10..1000: in place of the drift, the hand goes so far to one side, level, at 100 mm/s
  /// on average, and looks on at the same place: what somebody does who is told to show more.
  std::optional<double> walk_mm = std::nullopt;
  SimulatedClutter clutter =
      SimulatedClutter::kNone;  ///< [clutter] none | hand | towel | parts | all.
  double bias_mm = 0.0;  ///< [bias] 0..20: systematic depth error, root mean square at 800 mm, of a
                         ///< smooth seeded shape (internal/depth_bias.h). 0: none.
  double focal_error_percent = 0.0;  ///< [focal] -5..5: the calibration says so much too long.
  /// [exposure] 0..0.6: automatic exposure and white balance at work: brightness and colours swing
  /// by up to this share, jump now and then and flicker with the lamps.
  double exposure_swing = 0.0;
  SimulatedSkin skin = SimulatedSkin::kPlain;  ///< [skin] plain | marked.
  /// [table] 0..5: the table is uneven by so much, root mean square, in long waves.
  double table_uneven_mm = 0.0;
  bool has_noise = true;         ///< [noise] 0 | 1: Kinect v1 depth noise and grain in colour.
  std::uint64_t num_frames = 0;  ///< [frames] The camera ends after so many; 0: never.
  bool is_real_time = true;      ///< [speed] real | full: paced by the clock, or as fast as asked.

  [[nodiscard]] static Result<SimulatedCameraOptions> parse(std::string_view text);
  /// @errors kInvalidArgument: a value outside its limits.
  [[nodiscard]] Result<void> check() const;
};

/// A range camera in a careful hand over the CT's skin, which lies supine on a table. The rest of
/// the program gets it as a RangeCamera and cannot ask for the truth.
class SimulatedCamera : public RangeCamera {
 public:
  /// @param skin  Frame ct, LPS, mm. @errors kInvalidArgument: no skin, or bad options.
  [[nodiscard]] static Result<std::unique_ptr<SimulatedCamera>> create(
      std::shared_ptr<const TriangleMesh> skin, const SimulatedCameraOptions& options);
  ~SimulatedCamera() override;

  /// In real time a slow caller misses frames: their ids follow the clock.
  [[nodiscard]] Result<std::shared_ptr<const RgbdFrame>> next_frame(std::stop_token stop) override;
  [[nodiscard]] const RgbdCalibration& calibration() const override;

  /// Frame `frame_id`, whoever asks and in whatever order; `captured_at` is frame_id / fps.
  /// @threads Safe to call from many at once. @cost About 12 ms at 640x480.
  [[nodiscard]] std::shared_ptr<const RgbdFrame> frame_at(std::uint64_t frame_id) const;

  /// The truth, for recorders and tests only.
  [[nodiscard]] Eigen::Isometry3d ct_from_camera(std::uint64_t frame_id) const;

 private:
  struct Impl;
  explicit SimulatedCamera(std::unique_ptr<Impl> impl);
  [[nodiscard]] std::shared_ptr<RgbdFrame> draw(std::uint64_t frame_id) const;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mor
