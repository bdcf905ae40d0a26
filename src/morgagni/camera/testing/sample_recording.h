// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "morgagni/camera/mcap_recorder.h"

/// Small frames with numbers that a test can tell apart, and recordings of them.
namespace mor::internal {

inline std::shared_ptr<const RgbdCalibration> sample_calibration() {
  static const auto kCalibration = [] {
    RgbdCalibration calibration{{32, 24, 29.3, 29.1, 15.7, 11.9, {0.1, -0.2, 0.001, 0.002, 0.05}},
                                {40, 30, 38.6, 38.5, 19.1, 14.2, {0.01, 0.02, 0.0, -0.001, 0.3}},
                                Eigen::Isometry3d::Identity()};
    calibration.color_from_depth.translate(Eigen::Vector3d(-25.1, 0.3, 1.0 / 3.0));
    calibration.color_from_depth.rotate(
        Eigen::AngleAxisd(0.1, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()));
    return std::make_shared<const RgbdCalibration>(calibration);
  }();
  return kCalibration;
}

/// Captured 33.333 ms after the one before.
inline RgbdFrame sample_frame(std::uint64_t id) {
  RgbdFrame frame;
  frame.frame_id = id;
  frame.captured_at = std::chrono::steady_clock::time_point(
      std::chrono::hours(1) + id * std::chrono::nanoseconds(33'333'333));
  frame.device_time = std::chrono::nanoseconds(7'000'000'123 + id * 33'333'000);
  frame.calibration = sample_calibration();
  frame.depth_mm = Image<std::uint16_t>(32, 24);
  for (std::size_t i = 0; i < frame.depth_mm.size(); ++i) {
    frame.depth_mm.data()[i] = static_cast<std::uint16_t>(i % 7 == 0 ? 0 : 600 + 97 * i + id);
  }
  frame.color = Image<Rgb8>(40, 30);
  for (std::size_t i = 0; i < frame.color.size(); ++i) {
    frame.color.data()[i] = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i / 7), 40};
  }
  return frame;
}

inline FoundPose sample_pose(std::uint64_t id) {
  FoundPose pose;
  pose.state = id % 3 == 2 ? "uncertain" : "tracking";
  pose.is_held = id % 3 == 2;
  pose.doubts = id % 3 == 2 ? "jump, residual" : "";
  if (id % 3 != 2) pose.bound_mm = 0.1 + static_cast<double>(id) / 7.0;
  pose.ct_from_depth.emplace(Eigen::AngleAxisd(0.1 * static_cast<double>(id + 1),
                                               Eigen::Vector3d(3.0, -1.0, 2.0).normalized()));
  pose.ct_from_depth->translation() << 1.0 / 3.0, -200.7, 900.1 + static_cast<double>(id);
  return pose;
}

/// Frames 0..count-1 with their poses.
inline Result<void> record_samples(const std::filesystem::path& path,
                                   std::uint64_t count,
                                   const McapRecorderOptions& options) {
  MOR_TRY(auto recorder, McapRecorder::create(path, options));
  for (std::uint64_t i = 0; i < count; ++i) {
    MOR_CHECK(recorder.add(sample_frame(i), sample_pose(i)));
  }
  return recorder.finish();
}

}  // namespace mor::internal
