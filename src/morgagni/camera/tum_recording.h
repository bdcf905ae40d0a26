// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "morgagni/camera/recording.h"

namespace mor {

/// A folder in the TUM RGB-D layout: rgb.txt, depth.txt (time stamp, file), intrinsics.json (one
/// pinhole for both: fx fy cx cy width height depth_scale distortion), 16-bit depth PNG, 8-bit
/// colour PNG. Depth and colour are paired by nearest time stamp, at most 20 ms apart.
class TumRecording final : public Recording {
 public:
  /// Reads the lists and the intrinsics, not the pictures.
  /// @errors kNotFound (folder or list), kInvalidArgument (no or bad intrinsics, lists that do not
  /// match,
  ///         a path that leaves the folder).
  [[nodiscard]] static Result<TumRecording> open(const std::filesystem::path& folder);

  [[nodiscard]] std::size_t size() const override { return pairs_.size(); }
  [[nodiscard]] double timestamp_s(std::size_t i) const { return pairs_[i].timestamp_s; }
  [[nodiscard]] std::chrono::nanoseconds since_start(std::size_t i) const override;
  [[nodiscard]] const std::shared_ptr<const RgbdCalibration>& calibration() const override {
    return calibration_;
  }

  /// Reads frame `i`; `frame_id` is `i`. @errors kNotFound, kIo, kInvalidArgument (size unlike the
  /// intrinsics).
  [[nodiscard]] Result<std::shared_ptr<const RgbdFrame>> read(std::size_t i) const override;

 private:
  struct Pair {
    double timestamp_s = 0.0;
    std::filesystem::path depth;
    std::filesystem::path color;
  };

  std::vector<Pair> pairs_;
  double depth_units_per_mm_ = 1.0;
  std::shared_ptr<const RgbdCalibration> calibration_;
};

}  // namespace mor
