// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/ct/volume.h"

namespace mor {

/// Reads a CT: a DICOM folder (one series), a NIfTI (.nii, .nii.gz), NRRD (.nrrd, .nhdr) or
/// MetaImage
/// (.mha, .mhd) file.
///
/// The parsing happens in a child process, `morgagni-import` beside the running program, with
/// limits on memory and time: a hostile file can kill that process and nothing else.
///
/// @return Voxels in HU, axes brought to LPS; a grid whose axes are left-handed is flipped in
/// memory,
///         never mirrored in space.
/// @errors kNotFound; kUnsupported (colour, 4-D, not CT, tilted or irregular slices);
/// kInvalidArgument
///         (spacing 0 or NaN, too large); kIo (truncated, the import process died).
[[nodiscard]] Result<Volume> import_volume(const std::filesystem::path& path,
                                           const Progress& progress);

}  // namespace mor
