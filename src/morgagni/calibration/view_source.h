// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "morgagni/calibration/board.h"
#include "morgagni/camera/open_camera.h"
#include "morgagni/camera/range_camera.h"
#include "morgagni/core/result.h"

namespace mor {

/// Pictures of one pose of the board, from files. Each may be missing.
struct StillPictures {
  std::string name;
  std::optional<Image<Rgb8>> color;
  std::optional<Image<Rgb8>> infrared;
  std::optional<Image<std::uint16_t>> depth_mm;
};

/// The PNG pictures of a folder, by name: `color_NAME.png`, `infrared_NAME.png` and
/// `depth_NAME.png` (16-bit grey, mm) of one NAME belong together; a file of any other name is a
/// colour picture.
/// @errors kNotFound (no folder), kInvalidArgument: no picture, or of several sizes; kIo: which
/// file.
[[nodiscard]] Result<std::vector<StillPictures>> read_still_pictures(
    const std::filesystem::path& folder);

/// What stands where no calibration is known: lenses without distortion and of 60 degrees, one in
/// the place of the other, of the sizes of the first pictures of each kind.
[[nodiscard]] RgbdCalibration unknown_calibration(const std::vector<StillPictures>& pictures);

/// Opens a camera to calibrate, as its design has it: what is kept of it is not applied. Besides
/// all that open_camera() knows there is `simulated-board:key=value,...` (SimulatedBoardOptions).
/// @errors As open_camera(); kInvalidArgument for the simulated body, which holds no board.
[[nodiscard]] Result<std::unique_ptr<RangeCamera>> open_camera_before_board(
    const std::string& name,
    const CalibrationBoard& board,
    std::stop_token stop = {},
    const SayWaiting& say = {});

}  // namespace mor
