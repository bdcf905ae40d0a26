// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "morgagni/core/result.h"

namespace mor {

/// Keeps other Morgagni processes from a folder while it lives. It leaves no file behind and ends
/// with the process, however that ends.
class FolderLock {
 public:
  enum class Kind : std::uint8_t {
    kShared,     ///< With others who share.
    kExclusive,  ///< Alone.
  };

  /// Never waits.
  /// @param busy  The sentence for when somebody else holds it.
  /// @errors kInvalidArgument: `busy`; kIo: the folder cannot be opened.
  [[nodiscard]] static Result<FolderLock> take(const std::filesystem::path& folder,
                                               Kind kind,
                                               std::string_view busy);
  /// The same of a folder that is made where it is not there yet. @errors kIo: it cannot be.
  [[nodiscard]] static Result<FolderLock> make_and_take(const std::filesystem::path& folder,
                                                        Kind kind,
                                                        std::string_view busy);
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&& other) noexcept;
  ~FolderLock();

 private:
  explicit FolderLock(int fd) : fd_(fd) {}

  int fd_;
};

}  // namespace mor
