// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <gio/gio.h>

#include "morgagni/core/glib_handles.h"

namespace mor::internal::push {

/// Breaks a connection off on which more comes than a message may have, without its end. libsoup
/// 3.2 limits the parts of a message and gathers as many of them as are sent.
class MessageGuard {
 public:
  MessageGuard(GSocket* socket, std::uint64_t max_bytes);

  /// A message has come to its end.
  void on_message();
  /// To be called again and again. @return false: it is broken off, or gone.
  bool check();

 private:
  /// What the kernel has received. 0: the connection is gone.
  [[nodiscard]] std::uint64_t received() const;

  GObjectHandle<GSocket> socket_;
  std::uint64_t max_bytes_;
  std::uint64_t at_last_message_;
};

}  // namespace mor::internal::push
