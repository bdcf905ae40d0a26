// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/calibration/self_calibration.h"
#include "morgagni/camera/range_camera.h"

namespace mor {

/// One correction after another as a single one: `second` was found on what `first` gave. Right to
/// a hundredth of a millimetre where both are; beyond either one's distances, that of the end.
/// @errors kInvalidArgument: they share no distances, or `second` has a curve.
[[nodiscard]] Result<DepthCorrection> corrected_after(const DepthCorrection& first,
                                                      const DepthCorrection& second);

/// What the camera's calibration is once the error that was found with `in_use` is removed.
/// @errors As corrected_after().
[[nodiscard]] Result<RgbdCalibration> without_error(const RgbdCalibration& in_use,
                                                    const SelfCalibration& found);

}  // namespace mor
