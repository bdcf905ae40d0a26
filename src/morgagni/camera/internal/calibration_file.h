// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "morgagni/camera/range_camera.h"

namespace mor::internal {

/// A device's calibration from a file (calibration_json.h).
/// @param like  Whose picture sizes it must have.
/// @errors kNotFound, kIo, kInvalidArgument: names the file.
[[nodiscard]] Result<RgbdCalibration> read_calibration_file(const std::filesystem::path& path,
                                                            const RgbdCalibration& like);

/// The file's, where one is named; else what is known of the device; else that of its design.
/// @errors As read_calibration_file() and `known`.
[[nodiscard]] Result<RgbdCalibration> choose_calibration(const std::string& file,
                                                         const KnownCalibration& known,
                                                         const std::string& device_id,
                                                         const RgbdCalibration& by_design);

}  // namespace mor::internal
