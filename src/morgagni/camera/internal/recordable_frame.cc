// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/recordable_frame.h"

#include <string>
#include <utility>

#include <spdlog/fmt/fmt.h>

namespace mor::internal {
namespace {

template <class T>
bool has_size(const Image<T>& image, const PinholeCamera& camera) {
  return image.width() == camera.width_px && image.height() == camera.height_px;
}

}  // namespace

Result<void> check_recordable(const RgbdFrame& frame,
                              const RgbdCalibration* calibration,
                              std::chrono::steady_clock::time_point last_captured_at) {
  const auto invalid = [](std::string message) {
    return make_error(ErrorCode::kInvalidArgument, std::move(message));
  };
  if (!frame.calibration) return invalid("a frame without calibration cannot be recorded");
  if (calibration != nullptr && calibration != frame.calibration.get() &&
      *calibration != *frame.calibration) {
    return invalid("the camera's calibration changed during the recording");
  }
  if (!has_size(frame.depth_mm, frame.calibration->depth) ||
      !has_size(frame.color, frame.calibration->color)) {
    return invalid(
        fmt::format("frame {} has not the size that its calibration says", frame.frame_id));
  }
  if (calibration != nullptr && frame.captured_at <= last_captured_at) {
    return invalid(fmt::format("frame {} was captured before the last one", frame.frame_id));
  }
  return {};
}

}  // namespace mor::internal
