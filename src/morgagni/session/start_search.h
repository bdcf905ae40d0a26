// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include "morgagni/camera/range_camera.h"
#include "morgagni/core/latest_slot.h"
#include "morgagni/registration/automatic_start.h"

namespace mor {

/// A search that has ended: in which frame, and what it found.
struct SearchedFrame {
  std::shared_ptr<const RgbdFrame> frame;
  AutomaticStartResult result;
};

/// Searches for the body beside the tracking, one frame at a time: the live picture goes on.
class StartSearch {
 public:
  using Find = std::function<Result<AutomaticStartResult>(const RgbdFrame&, std::stop_token)>;

  explicit StartSearch(Find find);

  /// Runs a search at once, on the calling thread.
  [[nodiscard]] Result<SearchedFrame> search(std::shared_ptr<const RgbdFrame> frame) const;

  /// Begins a search in this frame, unless one goes on or has ended that nobody has taken.
  /// @return Whether it has begun.
  bool begin(std::shared_ptr<const RgbdFrame> frame);
  /// What has ended since the last call.
  [[nodiscard]] std::optional<Result<SearchedFrame>> take();
  /// Gives up the search that goes on; its result is never handed out.
  void cancel();
  [[nodiscard]] bool is_searching() const;

 private:
  struct Job {
    std::shared_ptr<const RgbdFrame> frame;
    std::stop_source stop;
  };

  void work(std::stop_token stop);

  const Find find_;
  mutable std::mutex mutex_;
  std::optional<std::stop_source> going_on_;
  std::optional<Result<SearchedFrame>> ended_;
  LatestSlot<Job> jobs_;
  std::jthread worker_;  ///< Ends first.
};

/// A search that goes on from frame to frame while they follow one another closely: what one did
/// not settle, several may (AutomaticStart::find_next).
[[nodiscard]] StartSearch::Find search_on(std::shared_ptr<const AutomaticStart> automatic);

}  // namespace mor
