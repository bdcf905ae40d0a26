// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "morgagni/core/result.h"

#include "task.h"

namespace mor::dimse {

/// A DICOM UID by its alphabet and length, which make it a harmless name of a file.
[[nodiscard]] bool is_uid(const std::string& text);

/// Where received objects go: written as they came, named when they are whole.
class ObjectStore {
 public:
  explicit ObjectStore(const Task& task);

  /// Whether another object may come. @errors kIo: the disk is nearly full.
  [[nodiscard]] Result<void> check_room() const;

  /// Where the next object is written until it is whole.
  [[nodiscard]] std::string part_file();

  /// Names what was written FOLDER/SOP.dcm, or FOLDER/STUDY/SERIES/SOP.dcm by what the object
  /// itself says, and tells the parent. @errors kInvalidArgument: it says no proper UIDs; kIo.
  [[nodiscard]] Result<void> keep(const std::string& part, const std::string& sop_instance_uid);

  void discard(const std::string& part) const;

 private:
  std::string folder_;
  std::string parts_;
  std::uint64_t min_free_bytes_;
  bool sorts_;
  int num_parts_ = 0;
};

}  // namespace mor::dimse
