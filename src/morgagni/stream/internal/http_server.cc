// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/stream/internal/http_server.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "morgagni/core/log.h"
#include "morgagni/stream/internal/static_files.h"

namespace mor::internal {

namespace {

constexpr std::string_view kWhep = "/whep";
constexpr std::string_view kEvents = "/api/events";
// Scripts and pictures from here only: what a file or a name contains can never run as code.
constexpr const char* kContentPolicy =
    "default-src 'self'; img-src 'self' blob: data:; media-src 'self' blob:; "
    "object-src 'none'; base-uri 'none'; frame-ancestors 'none'";

HttpReply method_not_allowed(const std::string& method,
                             const std::string& path,
                             const std::string& allowed) {
  return {json_error(405, path + " does not take " + method + ", it takes " + allowed),
          {{"Allow", allowed}}};
}

HttpReply not_found(const std::string& path) {
  return {json_error(404, "there is nothing at " + path), {}};
}

int status_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidArgument:
      return 400;
    case ErrorCode::kCancelled:
    case ErrorCode::kTimeout:
      return 504;
    default:
      return 500;
  }
}

Error listen_error(const GError* error, std::uint16_t port) {
  const std::string name = "port " + std::to_string(port);
  if (g_error_matches(error, G_IO_ERROR, G_IO_ERROR_ADDRESS_IN_USE)) {
    return {ErrorCode::kDevice, name + " is in use: choose another with --port"};
  }
  return {ErrorCode::kDevice,
          name + " cannot be opened (" + error->message + "): choose another with --port"};
}

}  // namespace

HttpServer::HttpServer(ViewerHub& viewers,
                       std::filesystem::path web_root,
                       std::vector<HttpRoute> routes)
    : viewers_(viewers), web_root_(std::move(web_root)), routes_(std::move(routes)) {}

HttpServer::~HttpServer() {
  if (server_) soup_server_disconnect(server_.get());
}

Result<void> HttpServer::listen(std::uint16_t port) {
  server_.reset(soup_server_new("server-header", "Morgagni", "raw-paths", TRUE, nullptr));
  soup_server_add_early_handler(
      server_.get(),
      nullptr,
      [](SoupServer*, SoupServerMessage* message, const char*, GHashTable*, gpointer) {
        const auto refusal = refuse_early(message);
        if (!refusal) return;
        soup_message_body_set_accumulate(soup_server_message_get_request_body(message), FALSE);
        set_reply(message, {*refusal, {{"Connection", "close"}}});
      },
      nullptr,
      nullptr);
  soup_server_add_handler(
      server_.get(),
      nullptr,
      [](SoupServer*, SoupServerMessage* message, const char*, GHashTable* query, gpointer self) {
        static_cast<HttpServer*>(self)->on_request(message, query);
      },
      this,
      nullptr);
  GError* raw_error = nullptr;
  if (!soup_server_listen_local(server_.get(), port, SOUP_SERVER_LISTEN_IPV4_ONLY, &raw_error)) {
    const GErrorHandle error(raw_error);
    return tl::unexpected(listen_error(error.get(), port));
  }
  GSList* addresses = soup_server_get_uris(server_.get());
  port_ = static_cast<std::uint16_t>(g_uri_get_port(static_cast<GUri*>(addresses->data)));
  g_slist_free_full(addresses, [](gpointer uri) { g_uri_unref(static_cast<GUri*>(uri)); });
  return {};
}

void HttpServer::on_request(SoupServerMessage* message, GHashTable* query) {
  // HEAD is GET without the body, which libsoup leaves out by itself.
  std::string method = soup_server_message_get_method(message);
  if (method == "HEAD") method = "GET";
  const auto request = read_request(message, query);
  if (!request) {
    set_reply(message, {json_error(400, "the address is not valid"), {}});
  } else if (request->path == kWhep || request->path.starts_with(std::string(kWhep) + "/")) {
    serve_whep(message, method, *request);
  } else if (request->path == kEvents) {
    serve_events(message, method);
  } else if (std::any_of(routes_.begin(), routes_.end(), [&](const HttpRoute& route) {
               return route.path == request->path;
             })) {
    set_reply(message, serve_route(method, *request));
  } else {
    set_reply(message, serve_file(method, *request));
  }
}

void HttpServer::serve_whep(SoupServerMessage* message,
                            const std::string& method,
                            const HttpRequest& request) {
  if (request.path == kWhep) {
    if (method == "POST") {
      admit_viewer(message, request);
    } else {
      set_reply(message, method_not_allowed(method, request.path, "POST"));
    }
    return;
  }
  if (method != "DELETE") {
    set_reply(message, method_not_allowed(method, request.path, "DELETE"));
  } else if (viewers_.remove(request.path.substr(kWhep.size() + 1))) {
    set_reply(message, {{.status = 200, .body = "{}"}, {}});
  } else {
    set_reply(message, {json_error(404, "there is no such viewer (any more)"), {}});
  }
}

void HttpServer::admit_viewer(SoupServerMessage* message, const HttpRequest& request) {
  if (viewers_.is_full()) {
    set_reply(message,
              {json_error(503,
                          "all places for viewers are taken: close the page on "
                          "another device"),
               {}});
    return;
  }
  // Negotiation takes milliseconds in which the loop serves others.
  const auto pending = std::make_shared<PendingReply>(message);
  viewers_.add(request.body, [this, pending](Result<ViewerHub::Answer> answer) {
    if (!answer) {
      pending->finish({json_error(status_of(answer.error().code), answer.error().message), {}});
    } else if (pending->is_gone()) {
      viewers_.remove(answer->viewer_id);
    } else {
      pending->finish({{.status = 201, .content_type = "application/sdp", .body = answer->sdp},
                       {{"Location", std::string(kWhep) + "/" + answer->viewer_id}}});
    }
  });
}

void HttpServer::serve_events(SoupServerMessage* message, const std::string& method) {
  if (method != "GET") {
    set_reply(message, method_not_allowed(method, std::string(kEvents), "GET"));
  } else if (events_.is_full()) {
    set_reply(message, {json_error(503, "too many pages listen already"), {}});
  } else {
    events_.add(message);
  }
}

HttpReply HttpServer::serve_route(const std::string& method, const HttpRequest& request) const {
  std::string allowed;
  for (const HttpRoute& route : routes_) {
    if (route.path != request.path) continue;
    if (route.method == method) {
      try {
        return {route.handler(request), {}};
      } catch (const std::exception& error) {
        log::error("{} {} failed: {}", method, request.path, error.what());
        return {json_error(500, "the server failed at this request, see its log"), {}};
      }
    }
    allowed += (allowed.empty() ? "" : ", ") + route.method;
  }
  return method_not_allowed(method, request.path, allowed);
}

HttpReply HttpServer::serve_file(const std::string& method, const HttpRequest& request) const {
  auto file = read_static_file(web_root_, request.path);
  if (!file) return not_found(request.path);
  if (method != "GET") return method_not_allowed(method, request.path, "GET");
  return {{.content_type = file->content_type, .body = std::move(file->bytes)},
          {{"Content-Security-Policy", kContentPolicy},
           {"Cache-Control", file->never_changes ? "max-age=31536000, immutable" : "no-cache"}}};
}

}  // namespace mor::internal
