// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string_view>

#include <gst/sdp/sdp.h>

#include "morgagni/core/result.h"
#include "morgagni/stream/internal/gst_handles.h"

namespace mor::internal {

using SdpHandle = std::unique_ptr<GstSDPMessage, FreeWith<gst_sdp_message_free>>;

/// A browser's WHEP offer, checked before webrtcbin sees it.
struct SessionOffer {
  SdpHandle sdp;             ///< Without candidates: the browser comes to us.
  int vp8_payload_type = 0;  ///< The browser chooses it.
};

/// @errors kInvalidArgument: not SDP, no VP8 video to be received, or sections we do not serve.
[[nodiscard]] Result<SessionOffer> parse_offer(std::string_view text);

}  // namespace mor::internal
