// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/latest_slot.h"

#include <thread>

#include <gtest/gtest.h>

namespace mor {
namespace {

TEST(LatestSlot, GivesTheNewestValueAndCountsTheDropped) {
  LatestSlot<int> slot;
  slot.put(1);
  slot.put(2);
  slot.put(3);
  EXPECT_EQ(slot.take({}), 3);
  EXPECT_EQ(slot.num_dropped(), 2U);
}

TEST(LatestSlot, StopsWaitingWhenAsked) {
  LatestSlot<int> slot;
  std::optional<int> taken = 7;
  {
    std::jthread waiter([&](std::stop_token stop) { taken = slot.take(stop); });
    waiter.request_stop();
  }
  EXPECT_EQ(taken, std::nullopt);
}

TEST(LatestSlot, WakesAWaitingThread) {
  LatestSlot<int> slot;
  std::optional<int> taken;
  {
    std::jthread waiter([&] { taken = slot.take({}); });
    slot.put(42);
  }
  EXPECT_EQ(taken, 42);
}

}  // namespace
}  // namespace mor
