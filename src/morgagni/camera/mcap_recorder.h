// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/camera/range_camera.h"
#include "morgagni/core/result.h"

namespace mor {

/// What the tracking made of a frame, kept beside it.
struct FoundPose {
  std::string state;  ///< "tracking", "uncertain", "lost", "waiting".
  std::optional<Eigen::Isometry3d> ct_from_depth = {};
  bool is_held = false;  ///< An earlier frame's pose.
  std::optional<double> bound_mm = {};
  std::string doubts = {};  ///< In words, empty where there are none.
};

enum class ColorCoding : std::uint8_t {
  kJpeg,      ///< Small; the pictures are not quite as they were.
  kLossless,  ///< PNG.
};

struct McapRecorderOptions {
  ColorCoding color = ColorCoding::kJpeg;
  int jpeg_quality = 92;                       ///< 1..100.
  std::uint64_t min_free_bytes = 256U << 20U;  ///< The disk is never filled further.
  std::vector<std::pair<std::string, std::string>> about =
      {};  ///< Case, camera, ...: kept as metadata.

  [[nodiscard]] Result<void> check() const;
};

/// Records frames into an MCAP file as ROS 2 messages, which Foxglove and ROS 2 open: depth as
/// `sensor_msgs/Image` (16UC1, every bit), colour as `CompressedImage`, `CameraInfo`, the device's
/// clock as `TimeReference`, poses in `/tf`, the tracking's state and bound in `/diagnostics`, and
/// the calibration once more, every bit of it, as attachment `calibration.json`.
///
/// The file is written under its own name, by whole chunks of half a second: it can be read at any
/// moment, and after a power cut or `kill -9` up to the last chunk.
/// Stamps are wall time: the first frame's is read from the clock, the others follow by
/// `captured_at`, to the nanosecond.
/// @threads None of its own; one call at a time. @cost CPU 2.5 ms a 640x480 frame, 20 ms lossless.
class McapRecorder {
 public:
  /// @errors kInvalidArgument (bad options, the file exists), kIo.
  [[nodiscard]] static Result<McapRecorder> create(const std::filesystem::path& path,
                                                   const McapRecorderOptions& options);
  McapRecorder(McapRecorder&&) noexcept;
  McapRecorder& operator=(McapRecorder&&) noexcept;
  /// Unless finish() was called, the file stays without its summary; it can be read all the same.
  ~McapRecorder();

  /// @errors kInvalidArgument (no calibration or one unlike the first frame's, a picture of another
  ///         size, captured before the last frame), kIo (disk full: says how much is kept).
  [[nodiscard]] Result<void> add(const RgbdFrame& frame, const std::optional<FoundPose>& pose = {});

  /// Puts on disk what is still in memory, as a chunk of its own. @errors kIo, as add().
  [[nodiscard]] Result<void> flush();

  /// Writes the summary, without which tools must look through the file. @errors kIo.
  [[nodiscard]] Result<void> finish();

  [[nodiscard]] std::uint64_t num_frames() const;  ///< After kIo: those that are kept.
  [[nodiscard]] std::uint64_t num_bytes() const;   ///< On disk.

 private:
  struct Impl;
  explicit McapRecorder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace mor
