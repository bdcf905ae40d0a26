// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "morgagni/core/result.h"
#include "morgagni/documentation/documents.h"
#include "morgagni/documentation/export_formats.h"

namespace mor {

/// No viewer is larger, whatever the case holds: it must open at once and go by mail.
inline constexpr std::size_t kMaxViewerBytes = 25'000'000;

/// The page's name among the built ones.
inline constexpr const char* kViewerFile = "viewer.html";

struct ViewerPage {
  std::string html;
  std::vector<std::string> remarks;  ///< What had to be made coarser to stay below the limit.
};

/// One HTML file that shows the model, the CT's slices and the findings without any network.
///
/// The page is web/viewer, built into one file (docs/documents.md); the case goes into it as data
/// blocks that no browser runs: JSON, the model as GLB, the CT as 8-bit voxels, both gzipped.
///
/// @param template_file  The built page.
/// @errors kNotFound: the page is not built. kInvalidArgument: another file than that page.
[[nodiscard]] Result<ViewerPage> fill_viewer(const DocumentSource& source,
                                             const ExportModel& model,
                                             const ExportTitle& title,
                                             const std::filesystem::path& template_file);

}  // namespace mor
