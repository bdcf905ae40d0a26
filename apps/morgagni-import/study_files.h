// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "morgagni/core/result.h"

namespace mor::import {

/// A file's bytes, mapped or in memory, for as long as this lives.
struct FileBytes {
  std::shared_ptr<const void> owner;
  std::span<const std::byte> bytes;
};

/// Maps a file for reading. @errors kIo.
[[nodiscard]] Result<FileBytes> map_file(const std::filesystem::path& path);

/// The files that may hold slices, wherever they lie.
class StudyFiles {
 public:
  virtual ~StudyFiles() = default;
  [[nodiscard]] virtual std::size_t size() const = 0;
  /// As people know the file: its path, or its name within an archive.
  [[nodiscard]] virtual std::string name(std::size_t index) const = 0;
  /// @errors kIo (cannot be read), kInvalidArgument (it would swell beyond reason).
  [[nodiscard]] virtual Result<FileBytes> load(std::size_t index) const = 0;
};

/// A folder with all its sub-folders; the files that a DICOMDIR names; a zip archive; or one file.
/// @errors kInvalidArgument: too many files. kIo, kUnsupported: an archive that cannot be read.
[[nodiscard]] Result<std::unique_ptr<StudyFiles>> open_study(const std::filesystem::path& path);

/// Whether open_study() is for this file, by what it holds.
[[nodiscard]] bool is_study_file(const std::filesystem::path& path);

}  // namespace mor::import
