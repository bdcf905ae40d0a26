// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/ct/ct_series.h"
#include "morgagni/geometry/volume.h"

namespace mor {

struct ImportOptions {
  /// Of a study with several: a series' number in list_ct_series() (from 1), its UID or its
  /// description. Empty: the only one.
  std::string series;
  /// Further series of the same body, named alike, that are joined with it into one volume.
  std::vector<std::string> join = {};
  /// Series are put together by what both show; without it only by coordinates that they share.
  bool align = false;
};

/// Reads a CT: a DICOM series (a folder with sub-folders, a DICOMDIR, a .zip or a multi-frame
/// file), or a NIfTI (.nii, .nii.gz), NRRD (.nrrd, .nhdr) or MetaImage (.mha, .mhd) file.
///
/// The parsing happens in a child process, `morgagni-import` beside the running program, with
/// limits on memory, time and rights: a hostile file can kill that process and nothing else.
///
/// @return Voxels in HU, axes brought to LPS; a grid whose axes are left-handed is flipped in
///         memory, never mirrored in space. What was left out or resampled is logged.
/// @errors kNotFound; kUnsupported (colour, 4-D, not CT, several series); kInvalidArgument (no
///         such series, spacing 0 or NaN, too large); kIo (truncated, the import process died).
[[nodiscard]] Result<Volume> import_volume(const std::filesystem::path& path,
                                           const ImportOptions& options,
                                           const Progress& progress);

/// The CT series of a study, in the order of their numbers. @errors As import_volume().
[[nodiscard]] Result<std::vector<CtSeries>> list_ct_series(const std::filesystem::path& path,
                                                           const Progress& progress);

/// Which limit of the import process does not hold on this machine, a sentence; empty: all hold.
/// @errors kUnsupported: too few hold, nothing is read here. kNotFound: there is no such program.
[[nodiscard]] Result<std::string> weakness_of_import();

}  // namespace mor
