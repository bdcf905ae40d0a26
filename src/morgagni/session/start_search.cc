// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/start_search.h"

#include <utility>

namespace mor {

StartSearch::StartSearch(Find find)
    : find_(std::move(find)), worker_([this](std::stop_token stop) { work(stop); }) {}

Result<SearchedFrame> StartSearch::search(std::shared_ptr<const RgbdFrame> frame) const {
  MOR_TRY(auto result, find_(*frame, {}));
  return SearchedFrame{std::move(frame), std::move(result)};
}

void StartSearch::begin(std::shared_ptr<const RgbdFrame> frame) {
  Job job{std::move(frame), {}};
  {
    const std::lock_guard lock(mutex_);
    if (going_on_) return;
    going_on_ = job.stop;
    ended_.reset();
  }
  jobs_.put(std::move(job));
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
