// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/stream/internal/session_offer.h"

#include <charconv>
#include <optional>
#include <string>

namespace mor::internal {

namespace {

constexpr std::size_t kMaxOfferBytes = 64 * 1024;

std::optional<int> vp8_payload_type(const GstSDPMedia* media) {
  for (guint idx = 0; idx < gst_sdp_media_attributes_len(media); ++idx) {
    const GstSDPAttribute* attribute = gst_sdp_media_get_attribute(media, idx);
    if (std::string_view(attribute->key) != "rtpmap" || attribute->value == nullptr) continue;
    const std::string_view value(attribute->value);
    const auto space = value.find(' ');
    if (space == std::string_view::npos || value.substr(space + 1) != "VP8/90000") continue;
    int payload_type = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + space, payload_type);
    const bool is_number = error == std::errc() && end == value.data() + space;
    if (is_number && payload_type >= 0 && payload_type < 128) return payload_type;
  }
  return std::nullopt;
}

/// The browser's addresses are names that only it can resolve, or none of our business: it
/// contacts us at the address in the answer, and ICE learns its own from that.
void remove_candidates(GstSDPMedia* media) {
  for (guint idx = gst_sdp_media_attributes_len(media); idx-- > 0;) {
    const std::string_view key = gst_sdp_media_get_attribute(media, idx)->key;
    if (key == "candidate" || key == "end-of-candidates") {
      gst_sdp_media_remove_attribute(media, idx);
    }
  }
}

tl::unexpected<Error> refuse(std::string sentence) {
  return make_error(ErrorCode::kInvalidArgument, std::move(sentence));
}

}  // namespace

Result<SessionOffer> parse_offer(std::string_view text) {
  if (text.size() > kMaxOfferBytes) {
    return refuse("the offer has " + std::to_string(text.size()) + " bytes, at most " +
                  std::to_string(kMaxOfferBytes) + " are read");
  }
  GstSDPMessage* raw = nullptr;
  gst_sdp_message_new(&raw);
  SessionOffer offer{SdpHandle(raw), 0};
  // GStreamer's parser takes almost any bytes, so the first line is looked at by hand.
  if (!text.starts_with("v=0") || text.find('\0') != std::string_view::npos ||
      gst_sdp_message_parse_buffer(reinterpret_cast<const guint8*>(text.data()),
                                   static_cast<guint>(text.size()),
                                   raw) != GST_SDP_OK) {
    return refuse("the offer is not a session description (SDP)");
  }
  int num_video = 0;
  int num_data = 0;
  for (guint idx = 0; idx < gst_sdp_message_medias_len(raw); ++idx) {
    auto* media = const_cast<GstSDPMedia*>(gst_sdp_message_get_media(raw, idx));
    const std::string_view kind = gst_sdp_media_get_media(media);
    remove_candidates(media);
    if (kind == "application") {
      ++num_data;
    } else if (kind == "video") {
      ++num_video;
      const auto payload_type = vp8_payload_type(media);
      if (!payload_type) return refuse("the offer has no VP8 video, which is what is sent here");
      offer.vp8_payload_type = *payload_type;
    } else {
      return refuse("the offer may have a video and a data section, it has another one too");
    }
  }
  if (num_video != 1 || num_data > 1) {
    return refuse("the offer must have one video section and at most one data section");
  }
  return offer;
}

}  // namespace mor::internal
