// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "morgagni/core/result.h"

namespace mor {

/// Whether it can be a device's id (RangeCamera::device_id()), which becomes a folder's name:
/// letters, digits, '-', '_' and '.' alone, no '.' in front, 1 to 100 of them.
/// @errors kInvalidArgument: says so.
[[nodiscard]] Result<void> check_device_id(std::string_view id);

/// What a driver calls its device, as an id: what an id cannot have becomes '-'. Empty: nothing is
/// left of it.
[[nodiscard]] std::string plain_device_id(std::string_view name);

}  // namespace mor
