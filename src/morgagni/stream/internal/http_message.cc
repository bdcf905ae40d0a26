// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/stream/internal/http_message.h"

#include <nlohmann/json.hpp>

namespace mor::internal {

namespace {

constexpr goffset kMaxBodyBytes = 1024 * 1024;

/// The name in "name:port" or "scheme://name:port".
std::string_view host_name(std::string_view address) {
  if (const auto scheme = address.find("://"); scheme != std::string_view::npos) {
    address.remove_prefix(scheme + 3);
  }
  return address.substr(0, address.rfind(':'));
}

bool is_here(std::string_view address) {
  const auto name = host_name(address);
  return name == "127.0.0.1" || name == "localhost";
}

}  // namespace

HttpResponse json_error(int status, std::string_view sentence) {
  using nlohmann::json;
  return {.status = status,
          .content_type = "application/json",
          .body = json{{"error", sentence}}.dump(-1, ' ', false, json::error_handler_t::replace)};
}

void set_reply(SoupServerMessage* message, const HttpReply& reply) {
  SoupMessageHeaders* headers = soup_server_message_get_response_headers(message);
  soup_message_headers_replace(headers, "X-Content-Type-Options", "nosniff");
  soup_message_headers_replace(headers, "Referrer-Policy", "no-referrer");
  soup_message_headers_replace(headers, "Cache-Control", "no-store");
  for (const auto& [name, value] : reply.headers) {
    soup_message_headers_replace(headers, name.c_str(), value.c_str());
  }
  const HttpResponse& response = reply.response;
  soup_server_message_set_status(message, static_cast<guint>(response.status), nullptr);
  soup_server_message_set_response(message,
                                   response.content_type.c_str(),
                                   SOUP_MEMORY_COPY,
                                   response.body.data(),
                                   response.body.size());
}

std::optional<HttpRequest> read_request(SoupServerMessage* message, GHashTable* query) {
  HttpRequest request;
  const GCharHandle path(
      g_uri_unescape_string(g_uri_get_path(soup_server_message_get_uri(message)), nullptr));
  if (!path || g_utf8_validate(path.get(), -1, nullptr) == FALSE) return std::nullopt;
  request.path = path.get();
  if (query != nullptr) {
    GHashTableIter item;
    gpointer key = nullptr;
    gpointer value = nullptr;
    g_hash_table_iter_init(&item, query);
    while (g_hash_table_iter_next(&item, &key, &value)) {
      request.query[static_cast<const char*>(key)] =
          value != nullptr ? static_cast<const char*>(value) : "";
    }
  }
  const SoupMessageBody* body = soup_server_message_get_request_body(message);
  if (body->data != nullptr)
    request.body.assign(body->data, static_cast<std::size_t>(body->length));
  return request;
}

std::optional<HttpResponse> refuse_early(SoupServerMessage* message) {
  SoupMessageHeaders* headers = soup_server_message_get_request_headers(message);
  const char* host = soup_message_headers_get_one(headers, "Host");
  const char* origin = soup_message_headers_get_one(headers, "Origin");
  if (host == nullptr || !is_here(host)) {
    return json_error(403, "this server answers to the names 127.0.0.1 and localhost only");
  }
  if (origin != nullptr && !is_here(origin)) {
    return json_error(403, "a page of another site may not use this server");
  }
  if (soup_message_headers_get_encoding(headers) == SOUP_ENCODING_CHUNKED) {
    return json_error(411, "a request must say its length (Content-Length)");
  }
  if (soup_message_headers_get_content_length(headers) > kMaxBodyBytes) {
    return json_error(413, "a request may have at most 1 MiB");
  }
  return std::nullopt;
}

PendingReply::PendingReply(SoupServerMessage* message)
    : message_(SOUP_SERVER_MESSAGE(g_object_ref(message))) {
  finished_signal_ = g_signal_connect(
      message,
      "finished",
      G_CALLBACK(+[](SoupServerMessage*, gpointer gone) { *static_cast<bool*>(gone) = true; }),
      &is_gone_);
  soup_server_message_pause(message);
}

PendingReply::~PendingReply() {
  if (!is_gone_) finish({json_error(500, "the server dropped the request"), {}});
  g_signal_handler_disconnect(message_.get(), finished_signal_);
}

void PendingReply::finish(const HttpReply& reply) {
  if (is_gone_) return;
  is_gone_ = true;
  set_reply(message_.get(), reply);
  soup_server_message_unpause(message_.get());
}

}  // namespace mor::internal
