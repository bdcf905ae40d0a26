// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "morgagni/core/result.h"

namespace mor {

/// A folder written beside its final place and put there by one atomic step. Removed unless
/// committed.
class PendingFolder {
 public:
  /// Makes `target`.part-PID and removes what killed runs left there. @errors kIo.
  [[nodiscard]] static Result<PendingFolder> create(const std::filesystem::path& target);
  PendingFolder(PendingFolder&& other) noexcept;
  PendingFolder& operator=(PendingFolder&&) = delete;
  ~PendingFolder();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  /// Puts the folder in its place; an older one there is exchanged in the same step, then deleted.
  /// @errors kIo.
  [[nodiscard]] Result<void> commit();

 private:
  PendingFolder(std::filesystem::path target, std::filesystem::path path);

  std::filesystem::path target_;
  std::filesystem::path path_;
};

}  // namespace mor
