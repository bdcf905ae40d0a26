// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace mor::testing {

/// The lines of a browser's offer that matter: VP8 to be received, and a data channel.
inline std::string browser_offer(int vp8_payload_type = 96) {
  const std::string type = std::to_string(vp8_payload_type);
  const std::string transport =
      "c=IN IP4 0.0.0.0\r\na=ice-ufrag:aB3d\r\na=ice-pwd:0123456789abcdefghijklmn\r\n"
      "a=ice-options:trickle\r\n"
      "a=fingerprint:sha-256 6B:8B:5D:EA:59:04:20:23:29:C8:87:1C:CC:87:32:BE:"
      "DD:8C:66:A5:8E:50:55:EA:8C:D3:B6:5C:09:5E:D6:BC\r\na=setup:actpass\r\n";
  return "v=0\r\no=- 4611731400430051336 2 IN IP4 127.0.0.1\r\ns=-\r\nt=0 0\r\n"
         "a=group:BUNDLE 0 1\r\na=msid-semantic: WMS\r\n"
         "m=video 9 UDP/TLS/RTP/SAVPF " +
         type + "\r\n" + transport +
         "a=mid:0\r\na=recvonly\r\na=rtcp-mux\r\na=rtcp-rsize\r\n"
         "a=candidate:1 1 udp 2113937151 f0e1d2c3.local 50000 typ host\r\n"
         "a=rtpmap:" +
         type + " VP8/90000\r\na=rtcp-fb:" + type +
         " nack pli\r\n"
         "m=application 9 UDP/DTLS/SCTP webrtc-datachannel\r\n" +
         transport + "a=mid:1\r\na=sctp-port:5000\r\na=max-message-size:262144\r\n";
}

}  // namespace mor::testing
