// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "morgagni/stream/internal/gst_parts.h"
#include "morgagni/stream/internal/session_offer.h"
#include "morgagni/stream/internal/viewer_hub.h"
#include "morgagni/stream/testing/browser_offer.h"

namespace mor::internal {
namespace {

using ::testing::HasSubstr;

TEST(GstParts, NamesTheDebianPackageOfAMissingPlugIn) {
  ASSERT_TRUE(check_gstreamer());
  EXPECT_EQ(missing_part("vp8enc", "gstreamer1.0-plugins-good"), "");
  EXPECT_EQ(missing_part("no_such_part", "gstreamer1.0-nice"),
            "GStreamer has no no_such_part: install the Debian package gstreamer1.0-nice");
}

TEST(SessionOffer, TakesTheBrowsersPayloadTypeAndDropsItsCandidates) {
  const auto offer = parse_offer(testing::browser_offer(120));
  ASSERT_TRUE(offer) << offer.error().message;
  EXPECT_EQ(offer->vp8_payload_type, 120);
  const GCharHandle text(gst_sdp_message_as_text(offer->sdp.get()));
  EXPECT_THAT(text.get(), ::testing::Not(HasSubstr("candidate")));
}

TEST(PictureMessage, HasTheStampAndThePicturesOwnMembers) {
  const auto message = [](const std::string& own) {
    return nlohmann::json::parse(
        picture_message({.rtp_stamp = 4294967295U, .captured_at = {}, .info_json = own}));
  };
  const auto full = message(R"( {"frame_id": 3, "state": "tracking"} )");
  EXPECT_EQ(full.at("rtp"), 4294967295U);
  EXPECT_EQ(full.at("captured_ms"), 0.0);
  EXPECT_EQ(full.at("frame_id"), 3);
  EXPECT_EQ(full.at("state"), "tracking");
  EXPECT_EQ(message("{ }").size(), 2U);
  EXPECT_EQ(message("").size(), 2U);
}

TEST(RtpStamp, Wraps) {
  EXPECT_EQ(rtp_stamp_of(0), 0U);
  EXPECT_EQ(rtp_stamp_of(GST_SECOND), 90000U);
  // After 13.3 hours.
  EXPECT_EQ(rtp_stamp_of(GST_SECOND * 47722), static_cast<std::uint32_t>(47722ULL * 90000ULL));
}

}  // namespace
}  // namespace mor::internal
