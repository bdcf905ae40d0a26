// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/start_search.h"

#include <atomic>
#include <chrono>
#include <condition_variable>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

using testing::HasSubstr;

std::shared_ptr<const RgbdFrame> frame(std::uint64_t id) {
  auto made = std::make_shared<RgbdFrame>();
  made->frame_id = id;
  return made;
}

AutomaticStartResult found() {
  AutomaticStartResult result;
  result.status = AutomaticStartStatus::kFound;
  return result;
}

/// Waits for the end of the search, generously.
std::optional<Result<SearchedFrame>> wait_for(StartSearch& search) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < end) {
    if (auto ended = search.take()) return ended;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return std::nullopt;
}

/// A search that goes on until it is told to stop.
StartSearch::Find endless(std::atomic<int>& begun) {
  return [&begun](const RgbdFrame&, std::stop_token stop) -> Result<AutomaticStartResult> {
    ++begun;
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any().wait(lock, stop, [] { return false; });
    return make_error(ErrorCode::kInternal, "told to stop");
  };
}

TEST(StartSearch, SaysInWhichFrameItFoundTheBody) {
  StartSearch search(
      [](const RgbdFrame&, std::stop_token) -> Result<AutomaticStartResult> { return found(); });
  EXPECT_FALSE(search.is_searching());
  search.begin(frame(7));
  const auto ended = wait_for(search);
  ASSERT_TRUE(ended && *ended);
  EXPECT_EQ((**ended).frame->frame_id, 7U);
  EXPECT_EQ((**ended).result.status, AutomaticStartStatus::kFound);
  EXPECT_FALSE(search.is_searching());
  EXPECT_FALSE(search.take()) << "told twice";
}

TEST(StartSearch, HandsOnAnError) {
  StartSearch search([](const RgbdFrame&, std::stop_token) -> Result<AutomaticStartResult> {
    return make_error(ErrorCode::kInvalidArgument, "of another size");
  });
  search.begin(frame(1));
  const auto ended = wait_for(search);
  ASSERT_TRUE(ended && !*ended);
  EXPECT_THAT(ended->error().message, HasSubstr("another size"));
}

TEST(StartSearch, OneAtATimeAndCancelled) {
  std::atomic<int> begun = 0;
  StartSearch search(endless(begun));
  search.begin(frame(1));
  search.begin(frame(2));
  EXPECT_TRUE(search.is_searching());
  search.cancel();
  EXPECT_FALSE(search.is_searching());
  EXPECT_FALSE(search.take());
  search.begin(frame(3));
  EXPECT_TRUE(search.is_searching()) << "a cancelled search does not stand in the next one's way";
}

TEST(StartSearch, WhatEndedWhileAFrameWasTrackedIsNotLostToTheNextSearch) {
  std::atomic<int> begun = 0;
  StartSearch search([&begun](const RgbdFrame&, std::stop_token) -> Result<AutomaticStartResult> {
    ++begun;
    return found();
  });
  EXPECT_TRUE(search.begin(frame(1)));
  while (search.is_searching()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_FALSE(search.begin(frame(2)));
  const auto ended = search.take();
  ASSERT_TRUE(ended && *ended);
  EXPECT_EQ((**ended).frame->frame_id, 1U);
  EXPECT_EQ(begun, 1);
  EXPECT_TRUE(search.begin(frame(3)));
}

TEST(StartSearch, TheEndOfTheSessionEndsASearch) {
  std::atomic<int> begun = 0;
  {
    StartSearch search(endless(begun));
    search.begin(frame(1));
    while (begun == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(begun, 1);
}

TEST(StartSearch, RunsAtOnceWhereTheCallerWaits) {
  StartSearch search([](const RgbdFrame& in, std::stop_token) -> Result<AutomaticStartResult> {
    auto result = found();
    result.score = static_cast<double>(in.frame_id);
    return result;
  });
  EXPECT_EQ(search.search(frame(4))->result.score, 4.0);
}

}  // namespace
}  // namespace mor
