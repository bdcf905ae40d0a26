// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>

#include "morgagni/core/result.h"

namespace mor {

/// A folder written beside its final place and put there by one atomic step. Removed unless
/// committed.
class PendingFolder {
 public:
  /// When this process is killed before the end, by whatever: kRemove has a shell wait for that and
  /// remove the folder. Where none can be started, and else, the next run on this target does.
  enum class WhenKilled : std::uint8_t { kLeave, kRemove };

  /// Makes `target`.part-PID and removes what killed runs left there. @errors kIo.
  [[nodiscard]] static Result<PendingFolder> create(const std::filesystem::path& target,
                                                    WhenKilled when_killed = WhenKilled::kLeave);
  PendingFolder(PendingFolder&& other) noexcept;
  PendingFolder& operator=(PendingFolder&&) = delete;
  ~PendingFolder();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  /// Puts the folder in its place; an older one there is exchanged in the same step, then deleted.
  /// @errors kIo.
  [[nodiscard]] Result<void> commit();

 private:
  PendingFolder(std::filesystem::path target, std::filesystem::path path);

  void start_watcher();
  void dismiss_watcher();

  std::filesystem::path target_;
  std::filesystem::path path_;
  int watcher_fd_ = -1;  ///< The watcher hears its end.
  int watcher_pid_ = -1;
};

}  // namespace mor
