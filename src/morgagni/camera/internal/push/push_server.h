// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "morgagni/camera/internal/push/inbox.h"
#include "morgagni/core/result.h"

namespace mor::internal::push {

struct PushServerOptions {
  std::string host = "127.0.0.1";  ///< An IP address of this machine.
  std::uint16_t port = 0;          ///< 0: a free one.
  std::string token = {};          ///< What a device must say. Empty: nothing.
};

/// A WebSocket server, in a thread of its own, that one device at a time pushes to: what comes is
/// put in the inbox. A further client takes over from one that has been silent for a second, and
/// is refused before. A page of another site is refused unless it says the token.
class PushServer {
 public:
  using MakeInbox = std::function<std::shared_ptr<Inbox>(const std::string& address)>;

  /// @errors kInvalidArgument (no such address), kDevice (the port is in use).
  [[nodiscard]] static Result<std::unique_ptr<PushServer>> start(const PushServerOptions& options,
                                                                 const MakeInbox& make_inbox);
  ~PushServer();
  PushServer(const PushServer&) = delete;
  PushServer& operator=(const PushServer&) = delete;

  [[nodiscard]] Inbox& inbox() const;
  [[nodiscard]] const std::string& address() const;  ///< "ws://127.0.0.1:8765".

  /// Tells the device, and whoever waits for frames, what cannot be used. Any thread.
  void complain(const std::string& sentence);

 private:
  struct Impl;
  explicit PushServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace mor::internal::push
