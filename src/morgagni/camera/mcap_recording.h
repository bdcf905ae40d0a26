// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "morgagni/camera/mcap_recorder.h"
#include "morgagni/camera/recording.h"

namespace mor {

/// What McapRecorder wrote, also where it was interrupted. Hostile until read: each length is
/// checked against the file, each chunk against its sum.
class McapRecording final : public Recording {
 public:
  /// Finds the frames; reads no picture.
  /// @errors kNotFound, kIo, kInvalidArgument (no MCAP, damaged, none of Morgagni's).
  [[nodiscard]] static Result<McapRecording> open(const std::filesystem::path& path);
  McapRecording(McapRecording&&) noexcept;
  McapRecording& operator=(McapRecording&&) noexcept;
  ~McapRecording() override;

  [[nodiscard]] std::size_t size() const override;
  [[nodiscard]] std::chrono::nanoseconds since_start(std::size_t i) const override;
  [[nodiscard]] const std::shared_ptr<const RgbdCalibration>& calibration() const override;
  /// One call at a time; in order it is quick (1.5 ms), else a chunk is unpacked first.
  [[nodiscard]] Result<std::shared_ptr<const RgbdFrame>> read(std::size_t i) const override;

  /// When frame `i` was captured, wall time since 1970.
  [[nodiscard]] std::chrono::nanoseconds wall_time(std::size_t i) const;
  /// What the tracking had made of frame `i`, every bit of the pose. None: it was not tracked.
  [[nodiscard]] Result<std::optional<FoundPose>> pose(std::size_t i) const;
  /// False: the recording was interrupted.
  [[nodiscard]] bool is_complete() const;

 private:
  struct Impl;
  explicit McapRecording(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace mor
