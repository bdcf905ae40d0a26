// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "morgagni/camera/range_camera.h"
#include "morgagni/core/result.h"

namespace mor {

/// {"depth": {"width", "height", "fx", "fy", "cx", "cy", "distortion": [k1, k2, p1, p2, k3]},
///  "color": the same, "color_from_depth": 3 rows of 4 numbers, mm,
///  "origin": optional text, "depth_sd": {"focal_ratio", "center_px"}, optional,
///  "depth_correction": optional, as below}. Every bit of every number.
[[nodiscard]] std::string calibration_to_json(const RgbdCalibration& calibration);

/// @errors kInvalidArgument: no JSON, a number missing, no pinhole, no rotation; names the member.
[[nodiscard]] Result<RgbdCalibration> calibration_from_json(std::string_view text);

/// {"near_mm", "far_mm", "columns", "rows", "c0_mm": columns x rows numbers row by row, "c1",
///  "c2_per_mm": the same, "curve": [[z_mm, add_mm], ...], optional}.
[[nodiscard]] std::string depth_correction_to_json(const DepthCorrection& correction);

/// @errors kInvalidArgument: no JSON, a number missing, no correction; names the member.
[[nodiscard]] Result<DepthCorrection> depth_correction_from_json(std::string_view text);

}  // namespace mor
