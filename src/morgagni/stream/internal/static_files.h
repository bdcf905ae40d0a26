// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace mor::internal {

struct StaticFile {
  std::string content_type;
  std::string bytes;
  bool never_changes = false;  ///< Its name holds a hash of its content.
};

/// The file of the built page that a URL path names; "/" is index.html. None where there is no such
/// file, or where the path leads out of `root` (by "..", hidden files or a symbolic link).
[[nodiscard]] std::optional<StaticFile> read_static_file(const std::filesystem::path& root,
                                                         std::string_view url_path);

}  // namespace mor::internal
