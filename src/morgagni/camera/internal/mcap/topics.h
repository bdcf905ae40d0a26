// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

/// What a recording calls its parts; the recorder writes them and the reader looks for them.
namespace mor::internal::mcap {

inline constexpr std::string_view kDepthTopic = "/camera/depth/image_raw";
inline constexpr std::string_view kDepthInfoTopic = "/camera/depth/camera_info";
inline constexpr std::string_view kColorTopic = "/camera/color/image_raw/compressed";
inline constexpr std::string_view kColorInfoTopic = "/camera/color/camera_info";
inline constexpr std::string_view kClockTopic = "/camera/clock";
inline constexpr std::string_view kTransformTopic = "/tf";
inline constexpr std::string_view kStaticTransformTopic = "/tf_static";
inline constexpr std::string_view kDiagnosticsTopic = "/diagnostics";

inline constexpr std::string_view kCtFrame = "ct";
inline constexpr std::string_view kDepthFrame = "depth";
inline constexpr std::string_view kColorFrame = "color";

inline constexpr std::string_view kCalibrationAttachment = "calibration.json";

// Values of the tracking's diagnostic.
inline constexpr std::string_view kPoseValue = "ct_from_depth";  ///< Three rows of four, mm.
inline constexpr std::string_view kHeldValue = "held";
inline constexpr std::string_view kBoundValue = "bound_mm";
inline constexpr std::string_view kDoubtsValue = "doubts";

}  // namespace mor::internal::mcap
