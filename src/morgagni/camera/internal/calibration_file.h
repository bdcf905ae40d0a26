// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "morgagni/camera/range_camera.h"

namespace mor::internal {

/// A device's calibration from a file (calibration_json.h).
/// @param like  Whose picture sizes it must have.
/// @errors kNotFound, kIo, kInvalidArgument: names the file.
[[nodiscard]] Result<RgbdCalibration> read_calibration_file(const std::filesystem::path& path,
                                                            const RgbdCalibration& like);

}  // namespace mor::internal
