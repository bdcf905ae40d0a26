// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"

namespace mor {

class DepthLevels;
struct RgbdCalibration;
struct RgbdFrame;

/// What a depth camera's readings are wrong by, smooth over the picture and over the distance:
///   corrected = z + c0 + c1 z + c2 z^2 + curve(z),   z in mm as the sensor gave it.
///
/// c0, c1 and c2 stand at control points on a coarse grid and are bilinear between them. Structured
/// light (Kinect v1) is linear in disparity, so c1 and c2 serve it; time of flight has an offset c0
/// and an error that wiggles with the distance, the curve. Nearer than `near_mm` and farther than
/// `far_mm`, where nothing was measured, the amount is that of this end.
struct DepthCorrection {
  struct Coefficients {
    double c0_mm = 0.0;
    double c1 = 0.0;
    double c2_per_mm = 0.0;
    bool operator==(const Coefficients&) const = default;
  };
  /// Linear between knots, constant beyond the first and the last.
  struct Knot {
    double z_mm = 0.0;
    double add_mm = 0.0;
    bool operator==(const Knot&) const = default;
  };

  int columns = 1;  ///< Of control points, evenly from the centre of the picture's first pixel to
                    ///< that of its last; a single one holds everywhere. 1..64.
  int rows = 1;     ///< The same. 1..64.
  std::vector<Coefficients> control{1};  ///< Row by row.
  std::vector<Knot> curve = {};          ///< By rising distance, at most 1024. Empty: none.
  double near_mm = 300.0;                ///< [1, far_mm).
  double far_mm = 4000.0;                ///< At most 65535.

  bool operator==(const DepthCorrection&) const = default;

  /// @errors kInvalidArgument: a grid or curve that is none, or an amount of more than half of the
  /// distance: says where.
  [[nodiscard]] Result<void> check() const;

  /// What is added to a reading of `z_mm` at a pixel of a picture of this size.
  [[nodiscard]] double add_mm(const Eigen::Vector2d& pixel,
                              int width_px,
                              int height_px,
                              double z_mm) const;

  /// Corrects a picture; 0 stays 0. What falls between two millimetres is rounded up or down by an
  /// ordered pattern, in proportion: means over 3x3 pixels, which the depth stage takes, keep the
  /// fraction to about 0.1 mm, larger ones to 0.01 mm, where rounding to the nearest would leave
  /// plateaus half a millimetre off. The same picture gives the same one, bit for bit.
  /// @pre check().  @cost About 1 ms at 640x480.
  [[nodiscard]] Image<std::uint16_t> apply(ImageView<const std::uint16_t> depth_mm) const;
  /// The same for what the values stand for, so that the sensor's rounding does not stay in them.
  [[nodiscard]] Image<std::uint16_t> apply(ImageView<const std::uint16_t> depth_mm,
                                           const DepthLevels& levels) const;
};

/// The frame that tracking and all after it look at: `depth_mm` corrected as its calibration says,
/// `as_sensed` the frame it was made from. A frame that is corrected already, or has no correction,
/// comes back itself.
/// @param levels  Of this camera: learns from what the sensor gave, and its rounding is undone
/// before the correction, which would hide it.
[[nodiscard]] std::shared_ptr<const RgbdFrame> depth_corrected(
    std::shared_ptr<const RgbdFrame> frame, DepthLevels& levels);

/// The frame as the sensor gave it, under another calibration than its driver's. @cost A copy.
[[nodiscard]] std::shared_ptr<const RgbdFrame> with_calibration(
    const RgbdFrame& frame, std::shared_ptr<const RgbdCalibration> calibration);

/// The frame that the sensor gave: what recordings keep.
[[nodiscard]] const RgbdFrame& as_sensed(const RgbdFrame& frame);

}  // namespace mor
