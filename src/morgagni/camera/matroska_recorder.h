// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>

#include "morgagni/camera/mcap_recorder.h"
#include "morgagni/camera/range_camera.h"

namespace mor {

/// Exports frames to a Matroska file that ffmpeg, VLC and their like open: depth as FFV1 in 16-bit
/// grey, every bit of its millimetres; colour as MJPEG, or FFV1 too; the calibration attached as
/// `calibration.json`; and a track of text with what Matroska's clock of 1 ms does not keep: for
/// each frame `{"frame":0,"time_ns":0,"device_ns":0}`, the time since the first frame and that of
/// the device's own clock, where it has one.
///
/// It is written beside its place and put there by finish(): it is no recording to be cut short.
/// @threads None of its own; one call at a time.
class MatroskaRecorder {
 public:
  /// @errors kInvalidArgument (the file exists, JPEG quality), kIo.
  [[nodiscard]] static Result<MatroskaRecorder> create(const std::filesystem::path& path,
                                                       ColorCoding color,
                                                       int jpeg_quality = 92);
  MatroskaRecorder(MatroskaRecorder&&) noexcept;
  MatroskaRecorder& operator=(MatroskaRecorder&&) noexcept;
  /// Removes what was written unless finish() succeeded.
  ~MatroskaRecorder();

  /// @errors kInvalidArgument (no calibration or one unlike the first frame's, a picture of another
  ///         size, captured before the last frame), kIo.
  [[nodiscard]] Result<void> add(const RgbdFrame& frame);

  /// Nothing may be added after. @errors kInvalidArgument (no frames), kIo.
  [[nodiscard]] Result<void> finish();

 private:
  struct Impl;
  explicit MatroskaRecorder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace mor
