// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/core/result.h"
#include "morgagni/ct/import_protocol.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// The volume that a header announces, without its voxels. `ct_from_grid` may still be left-handed:
/// make_right_handed() mends that once the voxels are there.
/// @errors kInvalidArgument: a side, spacing or axis out of its limits; kIo: no header at all.
[[nodiscard]] Result<Volume> volume_from_header(const ImportHeader& header);

/// Turns a left-handed grid into a right-handed one by reversing the order of its slices, so that
/// `ct_from_grid` is a rigid motion and every voxel stays where it is in space.
void make_right_handed(Volume& volume);

}  // namespace mor::internal
