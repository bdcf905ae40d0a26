// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/ct/volume_import.h"

namespace mor::internal {

/// The series of `options.series` and `options.join` as one volume. Series of one frame of
/// reference are put together by their coordinates; others only with `options.align`.
/// @errors As import_volume(), align_volumes() and join_volumes(); kInvalidArgument: frames of
///         reference differ and `align` is not set; the HU of both differ too much.
[[nodiscard]] Result<Volume> import_joined(const std::filesystem::path& path,
                                           const ImportOptions& options,
                                           const Progress& progress);

}  // namespace mor::internal
