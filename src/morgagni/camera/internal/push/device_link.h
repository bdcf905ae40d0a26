// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <string>

#include <libsoup/soup.h>

#include "morgagni/camera/internal/push/inbox.h"
#include "morgagni/camera/internal/push/message_guard.h"
#include "morgagni/core/glib_handles.h"

namespace mor::internal::push {

/// The device that pushes: its WebSocket, its channels, and what it is answered. The loop's alone.
class DeviceLink {
 public:
  /// @param name  What it calls itself in the address. Empty: nothing.
  DeviceLink(SoupWebsocketConnection* connection,
             GSocket* socket,
             const std::string& name,
             Inbox& inbox);
  ~DeviceLink();
  DeviceLink(const DeviceLink&) = delete;
  DeviceLink& operator=(const DeviceLink&) = delete;

  /// Says why, and closes.
  static void turn_away(SoupWebsocketConnection* connection, const std::string& why);

  [[nodiscard]] bool is_open() const;
  [[nodiscard]] std::chrono::steady_clock::time_point last_heard() const { return last_heard_; }

  /// The same sentence once a second at most. A device that is told too much is hung up on.
  void say(const Status& status);
  void close(const std::string& why);
  /// To be called again and again: breaks off what is too long to be a message.
  void watch();

 private:
  void on_message(SoupWebsocketDataType type, GBytes* bytes);
  void refuse(const Status& status);
  void take(std::span<const std::byte> bytes);

  GObjectHandle<SoupWebsocketConnection> connection_;
  MessageGuard guard_;
  Inbox& inbox_;
  ClientChannels channels_;
  std::chrono::steady_clock::time_point last_heard_ = std::chrono::steady_clock::now();
  std::string last_said_;
  std::chrono::steady_clock::time_point last_said_at_;
  int num_said_ = 0;
};

}  // namespace mor::internal::push
