// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>

#include "morgagni/casefile/case.h"
#include "morgagni/documentation/documents.h"

namespace mor {

/// What the documents tell of a case: the case itself, what case.json says of the CT and of the
/// preparation, and of what people made in it the texture, the findings and the kept pictures.
/// @errors As read_skin_texture and read_findings; kIo.
[[nodiscard]] Result<DocumentSource> document_source(const Case& body);

/// A new folder below CASE/documents, named by the time (UTC).
[[nodiscard]] std::filesystem::path new_documents_folder(const std::filesystem::path& case_folder);

/// document_source() and make_documents(), while nobody prepares the case anew.
/// @param output  Empty: new_documents_folder().
[[nodiscard]] Result<DocumentSummary> document_case(const Case& body,
                                                    const std::filesystem::path& output,
                                                    const DocumentOptions& options,
                                                    const Progress& progress,
                                                    std::stop_token stop);

}  // namespace mor
