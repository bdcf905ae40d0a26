// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <libsoup/soup.h>

#include "morgagni/core/glib_handles.h"
#include "morgagni/stream/live_server.h"

namespace mor::internal {

struct HttpReply {
  HttpResponse response;
  std::map<std::string, std::string> headers;
};

/// `{"error": sentence}`
[[nodiscard]] HttpResponse json_error(int status, std::string_view sentence);

/// Fills in the answer and the headers that every answer has.
void set_reply(SoupServerMessage* message, const HttpReply& reply);

/// The request as a route sees it. None where the path is not properly percent-encoded.
[[nodiscard]] std::optional<HttpRequest> read_request(SoupServerMessage* message,
                                                      GHashTable* query);

/// Why a request is refused before its body is read: a page of another site (which the browser
/// would let talk to 127.0.0.1), or a body without end. None: it is welcome.
[[nodiscard]] std::optional<HttpResponse> refuse_early(SoupServerMessage* message);

/// A request that is answered later, in the main loop. The client may be gone by then.
class PendingReply {
 public:
  explicit PendingReply(SoupServerMessage* message);
  ~PendingReply();
  PendingReply(const PendingReply&) = delete;
  PendingReply& operator=(const PendingReply&) = delete;

  void finish(const HttpReply& reply);
  [[nodiscard]] bool is_gone() const { return is_gone_; }

 private:
  GObjectHandle<SoupServerMessage> message_;
  gulong finished_signal_ = 0;
  bool is_gone_ = false;
};

}  // namespace mor::internal
