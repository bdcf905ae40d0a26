// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <list>
#include <memory>
#include <string>

#include <libsoup/soup.h>

#include "morgagni/core/glib_handles.h"

namespace mor::internal {

/// Server-sent events: the newest status to every page that listens. A page that does not read gets
/// the newest one when it reads again, not those between. All in the main loop.
class EventStream {
 public:
  EventStream() = default;
  ~EventStream();
  EventStream(const EventStream&) = delete;
  EventStream& operator=(const EventStream&) = delete;

  [[nodiscard]] bool is_full() const { return listeners_.size() >= kMaxListeners; }

  /// Begins the answer, with the last status at once.
  void add(SoupServerMessage* message);

  void publish(const std::string& json);

  /// A comment line, so that both sides notice when the other is gone.
  void send_heartbeat();

 private:
  struct Listener {
    EventStream& stream;
    GObjectHandle<SoupServerMessage> message;
    bool is_writing = false;
    bool missed_one = false;
  };

  static constexpr std::size_t kMaxListeners = 32;

  static void write(Listener& listener, const std::string& text);
  void on_written(Listener& listener);
  void remove(const Listener* listener);

  std::list<Listener> listeners_;
  std::string last_event_;
};

}  // namespace mor::internal
