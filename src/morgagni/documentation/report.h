// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "morgagni/core/result.h"
#include "morgagni/documentation/documents.h"
#include "morgagni/documentation/export_formats.h"

namespace mor {

/// What the report tells. Refers to what the caller keeps.
struct Report {
  const DocumentSource& source;
  const ExportModel& model;
  const ExportTitle& title;
  std::string author;                       ///< Who takes it away; empty: not said.
  const std::vector<HashedFile>& files;     ///< What was exported with it.
  const std::vector<std::string>& remarks;  ///< What is not as one might expect.
};

/// A report for people, as PDF 1.5 on A4: cover with the facts, the body from four sides with scale
/// bars and the findings' numbers, the findings with photos, coordinates and measurements, the kept
/// pictures, the hashes of all files. Any script for which a font is installed prints; all text
/// can be searched.
///
/// cairo and pango set it: pango finds fonts for every script and lays out lines right to left
/// where they are, which libharu cannot.
/// @errors kInternal: cairo failed. A photo or picture that cannot be read is named in its place.
[[nodiscard]] Result<std::string> encode_report_pdf(const Report& report);

}  // namespace mor
