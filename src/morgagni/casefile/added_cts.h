// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "morgagni/core/result.h"

namespace mor {

/// A case may have further CTs of the same body: its head, or the body before an intervention. Each
/// is a case folder of its own, with findings and all, in this folder of the case.
inline constexpr const char* kAddedCtsFolder = "cts";

/// The folder of one of a case's CTs. @param name  Empty: the case's first CT.
/// @errors kInvalidArgument: no name for a CT: 1 to 60 letters, digits, blanks, '-', '_', '.', the
///         first one a letter or a digit.
[[nodiscard]] Result<std::filesystem::path> ct_folder(const std::filesystem::path& case_folder,
                                                      const std::string& name);

/// The same, of a CT that is there. @errors kNotFound: with those that are.
[[nodiscard]] Result<std::filesystem::path> find_ct(const std::filesystem::path& case_folder,
                                                    const std::string& name);

/// Names of the CTs that were added, in order.
[[nodiscard]] std::vector<std::string> added_cts(const std::filesystem::path& case_folder);

/// The case that a folder is an added CT of; empty: it is none.
[[nodiscard]] std::filesystem::path case_of_added_ct(const std::filesystem::path& folder);

/// "0815" of a case's folder, "0815, before" of a CT that was added to it.
[[nodiscard]] std::string case_title(const std::filesystem::path& folder);

}  // namespace mor
