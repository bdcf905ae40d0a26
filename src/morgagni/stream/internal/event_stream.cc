// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/stream/internal/event_stream.h"

#include <algorithm>
#include <utility>

namespace mor::internal {

EventStream::~EventStream() {
  for (Listener& listener : listeners_) {
    g_signal_handlers_disconnect_by_data(listener.message.get(), &listener);
  }
}

void EventStream::add(SoupServerMessage* message) {
  SoupMessageHeaders* headers = soup_server_message_get_response_headers(message);
  soup_message_headers_set_encoding(headers, SOUP_ENCODING_CHUNKED);
  soup_message_headers_set_content_type(headers, "text/event-stream", nullptr);
  soup_message_headers_replace(headers, "Cache-Control", "no-store");
  soup_message_headers_replace(headers, "X-Content-Type-Options", "nosniff");
  soup_server_message_set_status(message, SOUP_STATUS_OK, nullptr);
  soup_message_body_set_accumulate(soup_server_message_get_response_body(message), FALSE);

  Listener& listener = listeners_.emplace_back(Listener{
      *this, GObjectHandle<SoupServerMessage>(SOUP_SERVER_MESSAGE(g_object_ref(message)))});
  g_signal_connect(message,
                   "finished",
                   G_CALLBACK(+[](SoupServerMessage*, gpointer data) {
                     auto* gone = static_cast<Listener*>(data);
                     gone->stream.remove(gone);
                   }),
                   &listener);
  g_signal_connect(message,
                   "wrote-chunk",
                   G_CALLBACK(+[](SoupServerMessage*, gpointer data) {
                     auto* written = static_cast<Listener*>(data);
                     written->stream.on_written(*written);
                   }),
                   &listener);
  write(listener, last_event_.empty() ? ":\n\n" : last_event_);
}

void EventStream::publish(const std::string& json) {
  // A line break would end the event early; JSON needs none outside of its strings.
  last_event_ = "event: status\ndata: " + json + "\n\n";
  const auto data = last_event_.begin() + static_cast<std::ptrdiff_t>(last_event_.find("data:"));
  std::replace_if(
      data, last_event_.end() - 2, [](char c) { return c == '\n' || c == '\r'; }, ' ');
  for (Listener& listener : listeners_) {
    if (listener.is_writing) {
      listener.missed_one = true;
    } else {
      write(listener, last_event_);
    }
  }
}

void EventStream::send_heartbeat() {
  for (Listener& listener : listeners_) {
    if (!listener.is_writing) write(listener, ":\n\n");
  }
}

void EventStream::write(Listener& listener, const std::string& text) {
  listener.is_writing = true;
  soup_message_body_append(soup_server_message_get_response_body(listener.message.get()),
                           SOUP_MEMORY_COPY,
                           text.data(),
                           text.size());
  soup_server_message_unpause(listener.message.get());
}

void EventStream::on_written(Listener& listener) {
  listener.is_writing = false;
  if (!std::exchange(listener.missed_one, false)) return;
  write(listener, last_event_);
}

void EventStream::remove(const Listener* listener) {
  listeners_.remove_if([&](const Listener& each) { return &each == listener; });
}

}  // namespace mor::internal
