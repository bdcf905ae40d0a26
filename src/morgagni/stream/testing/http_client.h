// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace mor::testing {

/// A TCP connection to 127.0.0.1 that sends exactly the bytes it is given: what a test needs to be
/// a client that is wrong, slow or gone.
class RawClient {
 public:
  explicit RawClient(std::uint16_t port);
  ~RawClient();
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  void send(const std::string& bytes) const;

  /// What arrives until `text` is in it, the peer closes, or the time is over.
  [[nodiscard]] std::string read_until(const std::string& text,
                                       std::chrono::milliseconds limit) const;

 private:
  int socket_;
};

struct ClientResponse {
  int status = 0;  ///< 0: no answer.
  std::string head;
  std::string body;
};

/// One request on a connection of its own. `head_lines` end with CRLF each.
[[nodiscard]] ClientResponse request(std::uint16_t port,
                                     const std::string& method,
                                     const std::string& path,
                                     const std::string& body = {},
                                     const std::string& head_lines = "Host: 127.0.0.1\r\n");

}  // namespace mor::testing
