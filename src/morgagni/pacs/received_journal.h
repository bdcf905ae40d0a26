// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "morgagni/core/result.h"
#include "morgagni/pacs/storage_receiver.h"

namespace mor {

/// Which series came and are not cases yet, on disk: a receiver that was killed goes on with them.
class ReceivedJournal {
 public:
  /// @param folder  Of the receiver; the journal is in its sub-folder `waiting`.
  explicit ReceivedJournal(const std::filesystem::path& folder);

  /// @errors kIo.
  [[nodiscard]] Result<void> add(const ReceivedObject& object) const;
  void remove(const std::string& series_uid) const;
  /// An object of each series. What cannot be read is passed over.
  [[nodiscard]] std::vector<ReceivedObject> read() const;

 private:
  std::filesystem::path receiver_folder_;
  std::filesystem::path folder_;
};

}  // namespace mor
