// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <libsoup/soup.h>

#include "morgagni/core/glib_handles.h"
#include "morgagni/core/result.h"
#include "morgagni/stream/internal/event_stream.h"
#include "morgagni/stream/internal/http_message.h"
#include "morgagni/stream/internal/viewer_hub.h"
#include "morgagni/stream/live_server.h"

namespace mor::internal {

/// HTTP on 127.0.0.1: the page's files, WHEP, the status events and the caller's routes. After
/// listen() everything happens in the main loop.
class HttpServer {
 public:
  HttpServer(ViewerHub& viewers, std::filesystem::path web_root, std::vector<HttpRoute> routes);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  /// To be called where the main loop's context is the thread's default.
  /// @errors kDevice: the port is in use or not ours to open.
  [[nodiscard]] Result<void> listen(std::uint16_t port);

  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] EventStream& events() { return events_; }

 private:
  void on_request(SoupServerMessage* message, GHashTable* query);
  void serve_whep(SoupServerMessage* message,
                  const std::string& method,
                  const HttpRequest& request);
  void admit_viewer(SoupServerMessage* message, const HttpRequest& request);
  void serve_events(SoupServerMessage* message, const std::string& method);
  [[nodiscard]] HttpReply serve_route(const std::string& method, const HttpRequest& request) const;
  [[nodiscard]] HttpReply serve_file(const std::string& method, const HttpRequest& request) const;

  ViewerHub& viewers_;
  std::filesystem::path web_root_;
  std::vector<HttpRoute> routes_;
  EventStream events_;
  GObjectHandle<SoupServer> server_;
  std::uint16_t port_ = 0;
};

}  // namespace mor::internal
