// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Geometry>

#include "morgagni/camera/range_camera.h"
#include "morgagni/core/result.h"

namespace mor {

/// Writes a folder that TumRecording reads, with groundtruth.txt where the truth is known (camera
/// in the CT's world, RAS+ and metres, as TUM has it). Frames gather in `FOLDER.part-PID`, which
/// becomes FOLDER in finish(): half a recording is never taken for a whole one.
class TumRecorder {
 public:
  /// @errors kInvalidArgument (the folder exists and is not empty), kIo.
  [[nodiscard]] static Result<TumRecorder> create(const std::filesystem::path& folder);
  TumRecorder(TumRecorder&&) noexcept;
  TumRecorder& operator=(TumRecorder&&) noexcept;
  /// Removes what was written unless finish() succeeded.
  ~TumRecorder();

  /// @param timestamp_s  After the last frame's.
  /// @param ct_from_camera  The truth, in mm and LPS, for every frame or for none.
  /// @errors kUnsupported (depth and colour do not share one pinhole), kInvalidArgument (stamp,
  ///         calibration unlike the first frame's, picture size), kIo.
  [[nodiscard]] Result<void> add(const RgbdFrame& frame,
                                 double timestamp_s,
                                 const std::optional<Eigen::Isometry3d>& ct_from_camera);

  /// Another file of the recording, as targets.csv. @param name  Without a folder.
  /// @errors kInvalidArgument (the recording is finished, or has that file), kIo.
  [[nodiscard]] Result<void> add_file(std::string_view name, std::string_view text);

  /// Nothing may be added after. @errors kInvalidArgument (no frames), kIo.
  [[nodiscard]] Result<void> finish();

 private:
  struct Impl;
  explicit TumRecorder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace mor
