// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>

#include "morgagni/core/result.h"
#include "morgagni/pacs/pacs_peer.h"

namespace mor::internal {

struct HttpAnswer {
  int status = 0;
  std::string content_type;
};

/// What to do with an answer. Either may end it by an error.
struct HttpSink {
  std::function<Result<void>(const HttpAnswer&)> head;  ///< Of status 200 or 204 only.
  std::function<Result<void>(std::string_view)> data;
};

/// GET over HTTP and HTTPS, straight to the host: no proxy, and no redirection, which could take
/// the password elsewhere. Blocks. One thread at a time.
class HttpClient {
 public:
  /// @errors kInvalidArgument: a TLS file.
  [[nodiscard]] static Result<std::unique_ptr<HttpClient>> create(const PacsOptions& options);
  virtual ~HttpClient() = default;

  /// Returns when the answer is over. @errors kIo, kTimeout: the connection; kNotFound: 404;
  /// kInvalidArgument: refused, or moved elsewhere; the sink's; kCancelled.
  [[nodiscard]] virtual Result<void> get(const std::string& url,
                                         const std::string& accept,
                                         const HttpSink& sink,
                                         std::stop_token stop) = 0;
};

}  // namespace mor::internal
