// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/utc.h"

#include <gtest/gtest.h>

namespace mor {
namespace {

TEST(UtcText, IsIso8601ToTheSecond) {
  using std::chrono::system_clock;
  EXPECT_EQ(utc_text(system_clock::from_time_t(1795710005)), "2026-11-26T16:20:05Z");
  EXPECT_EQ(utc_text(system_clock::from_time_t(0)), "1970-01-01T00:00:00Z");
}

TEST(ParseUtc, ReadsWhatUtcTextWrites) {
  const auto time = std::chrono::system_clock::from_time_t(1795710005);
  EXPECT_EQ(parse_utc(utc_text(time)).value(), time);
  for (const char* text : {"", "2026-11-26", "2026-11-26T16:20:05", "2026-11-26T16:20:05Z ", "x"}) {
    EXPECT_FALSE(parse_utc(text)) << text;
  }
}

}  // namespace
}  // namespace mor
