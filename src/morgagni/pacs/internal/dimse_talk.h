// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "morgagni/core/result.h"
#include "morgagni/pacs/internal/tag_values.h"

namespace mor::internal {

/// What a child tells while it works (morgagni/pacs/dimse_protocol.h). Each may be empty.
struct DimseEvents {
  std::function<void(TagValues)> match = {};
  std::function<void(const std::filesystem::path& file, TagValues)> stored = {};
  std::function<void(std::string)> caller = {};
  std::function<void(std::string)> refused = {};
};

/// Hears what a child says, line by line. A child that has read a hostile peer's bytes is believed
/// as little as the peer.
class DimseTalk {
 public:
  /// `events` must outlive it.
  explicit DimseTalk(const DimseEvents& events) : events_(events) {}

  /// More of it, in pieces of any size.
  void hear(std::string_view bytes);

  /// It said what it should not; nothing more is heard.
  [[nodiscard]] bool is_broken() const { return is_broken_; }
  /// How it says that it ended; empty before.
  [[nodiscard]] const std::optional<Result<int>>& outcome() const { return outcome_; }

 private:
  void hear_line(std::string_view line);

  const DimseEvents& events_;
  std::string pending_;
  std::optional<Result<int>> outcome_;
  bool is_broken_ = false;
};

}  // namespace mor::internal
