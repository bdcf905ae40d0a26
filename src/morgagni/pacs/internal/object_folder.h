// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "morgagni/core/result.h"
#include "morgagni/pacs/pacs_peer.h"

namespace mor::internal {

/// The parts of WADO-RS answers become files of a folder: written as they come, named by their SOP
/// Instance UID when they are whole, and only those that were asked for.
class ObjectFolder {
 public:
  ObjectFolder(std::filesystem::path folder,
               const std::vector<std::string>& wanted,
               const PacsOptions& options,
               OnObject on_object);
  ~ObjectFolder();
  ObjectFolder(const ObjectFolder&) = delete;
  ObjectFolder& operator=(const ObjectFolder&) = delete;

  /// @errors kIo: the disk; kInvalidArgument: a limit of the options.
  [[nodiscard]] Result<void> begin();
  [[nodiscard]] Result<void> append(std::string_view bytes);
  /// @errors kIo also: what came is no DICOM file or not among those wanted.
  [[nodiscard]] Result<void> end();

 private:
  [[nodiscard]] Result<void> check_room() const;
  void close();

  std::filesystem::path folder_;
  std::filesystem::path part_;
  std::set<std::string, std::less<>> wanted_;
  std::uint64_t max_object_bytes_;
  std::uint64_t min_free_bytes_;
  OnObject on_object_;
  int fd_ = -1;
  std::uint64_t num_bytes_ = 0;
  std::uint64_t checked_at_ = 0;
  std::string head_;
};

}  // namespace mor::internal
