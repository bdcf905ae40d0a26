// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "morgagni/camera/range_camera.h"
#include "morgagni/casefile/case.h"

/// What the files beside pictures and videos say, so that these can be verified later.
namespace mor::evidence {

using Json = nlohmann::ordered_json;

inline constexpr const char* kNotice = "Not a medical device";

/// Case, CT, program, notice.
[[nodiscard]] Json head(const Case& body);
[[nodiscard]] Json to_json(const PinholeCamera& camera);
[[nodiscard]] Json to_json(const RgbdCalibration& calibration);
/// Which skin the frames are registered to: "the CT's", or how it differs from that. Null: the
/// CT's.
[[nodiscard]] std::string skin_words(const std::shared_ptr<const FixedSurface>& skin);
/// The upper three rows, row by row.
[[nodiscard]] Json to_json(const Eigen::Isometry3d& pose);

/// Wall clock of a moment of the monotonic one.
[[nodiscard]] std::chrono::system_clock::time_point wall_clock(
    std::chrono::steady_clock::time_point time);
/// A file name for this moment: "2026-11-26T16-20-05Z".
[[nodiscard]] std::string file_name(std::chrono::system_clock::time_point time);

}  // namespace mor::evidence
