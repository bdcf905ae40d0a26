// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include <Eigen/Geometry>

#include "morgagni/camera/depth_correction.h"
#include "morgagni/core/image.h"
#include "morgagni/core/result.h"
#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

/// How exactly a pinhole is known: standard deviations.
struct PinholeSd {
  double focal_ratio = 0.0;  ///< Of the focal lengths. (0, 0.1].
  double center_px = 0.0;    ///< Each way. (0, 100].

  bool operator==(const PinholeSd&) const = default;
};

/// How a range camera sees: two pinholes and the way between them.
struct RgbdCalibration {
  PinholeCamera depth;
  PinholeCamera color;
  Eigen::Isometry3d color_from_depth = Eigen::Isometry3d::Identity();
  /// What the depth camera's readings are wrong by (see depth_corrected). Null: not known.
  std::shared_ptr<const DepthCorrection> depth_correction = nullptr;
  /// Where it is from and of what day, for people. Empty: the device's own word, or its design.
  std::string origin = {};
  /// How exactly `depth` is known, by the calibration that found it. None: nobody said.
  std::optional<PinholeSd> depth_sd = std::nullopt;

  bool operator==(const RgbdCalibration& other) const {
    const bool same_correction = depth_correction && other.depth_correction
                                     ? *depth_correction == *other.depth_correction
                                     : depth_correction == other.depth_correction;
    return depth == other.depth && color == other.color && same_correction &&
           origin == other.origin && depth_sd == other.depth_sd &&
           color_from_depth.matrix() == other.color_from_depth.matrix();
  }
};

/// One moment of a range camera. Depth and colour stay as the sensor gave them, except where
/// `as_sensed` says otherwise.
struct RgbdFrame {
  std::uint64_t frame_id = 0;  ///< Counts from 0; of a looped recording, the number within it.
  std::chrono::steady_clock::time_point captured_at;
  Image<std::uint16_t> depth_mm;  ///< 0 = no reading.
  Image<Rgb8> color;
  std::shared_ptr<const RgbdCalibration> calibration;
  /// By the device's own clock, whose origin is its own. None: it has none.
  std::optional<std::chrono::nanoseconds> device_time = std::nullopt;
  /// The frame whose depth was corrected to make this one. Null: this is what the sensor gave.
  std::shared_ptr<const RgbdFrame> as_sensed = nullptr;
};

/// A source of frames. Recordings and the simulation are ordinary cameras.
class RangeCamera {
 public:
  virtual ~RangeCamera() = default;

  /// Waits for the next frame. A null pointer: the recording has ended, or `stop` was requested.
  /// @errors kDevice, kIo: this frame could not be had; the caller may ask again.
  [[nodiscard]] virtual Result<std::shared_ptr<const RgbdFrame>> next_frame(
      std::stop_token stop) = 0;

  [[nodiscard]] virtual const RgbdCalibration& calibration() const = 0;

  /// What tells this device from others of its kind: "freenect-A00361D08047310A". Empty: a
  /// recording, a simulation, or a device that has no number.
  [[nodiscard]] virtual std::string device_id() const { return {}; }
};

/// What was found out about a device before, by its id: it takes the place of `by_design` unless
/// the camera's name says `calibration=FILE`. None: nothing is known.
using KnownCalibration = std::function<Result<std::optional<RgbdCalibration>>(
    const std::string& device_id, const RgbdCalibration& by_design)>;

/// Opens a camera by its name:
///   `simulated:[key=value,...]`  see SimulatedCameraOptions;
///   `tum:DIR`, `mcap:FILE`, both with `[,loop=1][,speed=real|full]`  recordings;
///   `freenect:[index=N][,calibration=FILE]`  a Kinect for Xbox 360;
///   `openni2:[FILE.oni][,calibration=FILE]`  a Carmine, Xtion or Structure, or its recording;
///   `push:[HOST:]PORT[,token=...][,calibration=FILE][,tolerance_ms=N]`  any device on the net;
///   `v4l2:/dev/videoN[,color=/dev/videoM][,calibration=FILE][,format=z16|y16]`  by the kernel.
/// @param skin  The case's skin, which only the simulated camera looks at.
/// @param known  Asked for devices that have an id; see calibration/calibration_store.h.
/// @errors kInvalidArgument (unknown kind, key or value: names what is allowed), kNotFound, kIo.
[[nodiscard]] Result<std::unique_ptr<RangeCamera>> open_camera(
    const std::string& name,
    std::shared_ptr<const TriangleMesh> skin,
    const KnownCalibration& known = {});

}  // namespace mor
