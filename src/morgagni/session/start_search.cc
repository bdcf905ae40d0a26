// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/start_search.h"

#include <chrono>
#include <utility>

namespace mor {
namespace {

/// From one frame to the next at the most, either way; else the camera may be anywhere.
constexpr std::chrono::seconds kLongestGap{2};

struct GoingOn {
  std::mutex mutex;
  StartMemory memory;
  std::chrono::steady_clock::time_point last_at;
};

}  // namespace

StartSearch::Find search_on(std::shared_ptr<const AutomaticStart> automatic) {
  return [automatic = std::move(automatic), search = std::make_shared<GoingOn>()](
             const RgbdFrame& frame, std::stop_token stop) {
    const std::lock_guard lock(search->mutex);
    const auto gap = frame.captured_at - search->last_at;
    if (gap > kLongestGap || gap < -kLongestGap) search->memory.forget();
    search->last_at = frame.captured_at;
    return automatic->find_next(frame.depth_mm.view(), search->memory, std::move(stop));
  };
}

StartSearch::StartSearch(Find find)
    : find_(std::move(find)), worker_([this](std::stop_token stop) { work(stop); }) {}

Result<SearchedFrame> StartSearch::search(std::shared_ptr<const RgbdFrame> frame) const {
  MOR_TRY(auto result, find_(*frame, {}));
  return SearchedFrame{std::move(frame), std::move(result)};
}

bool StartSearch::begin(std::shared_ptr<const RgbdFrame> frame) {
  Job job{std::move(frame), {}};
  {
    const std::lock_guard lock(mutex_);
    if (going_on_ || ended_) return false;
    going_on_ = job.stop;
  }
  jobs_.put(std::move(job));
  return true;
}

std::optional<Result<SearchedFrame>> StartSearch::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(ended_, std::nullopt);
}

void StartSearch::cancel() {
  const std::lock_guard lock(mutex_);
  if (going_on_) going_on_->request_stop();
  going_on_.reset();
  ended_.reset();
}

bool StartSearch::is_searching() const {
  const std::lock_guard lock(mutex_);
  return going_on_.has_value();
}

void StartSearch::work(std::stop_token stop) {
  while (auto job = jobs_.take(stop)) {
    // The end of the thread gives up the search too.
    const std::stop_callback on_end(stop, [&job] { job->stop.request_stop(); });
    auto result = find_(*job->frame, job->stop.get_token());
    const std::lock_guard lock(mutex_);
    if (job->stop.stop_requested()) continue;
    going_on_.reset();
    if (result) {
      ended_ = SearchedFrame{std::move(job->frame), *std::move(result)};
    } else {
      ended_ = tl::unexpected<Error>(result.error());
    }
  }
}

}  // namespace mor
