// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/push/message_guard.h"

#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/socket.h>

namespace mor::internal::push {

MessageGuard::MessageGuard(GSocket* socket, std::uint64_t max_bytes)
    : socket_(G_SOCKET(g_object_ref(socket))),
      max_bytes_(max_bytes),
      at_last_message_(received()) {}

void MessageGuard::on_message() {
  at_last_message_ = received();
}

bool MessageGuard::check() {
  const auto now = received();
  if (now == 0) return false;
  if (now - at_last_message_ <= max_bytes_) return true;
  g_socket_shutdown(socket_.get(), TRUE, TRUE, nullptr);
  return false;
}

std::uint64_t MessageGuard::received() const {
  if (g_socket_is_closed(socket_.get()) != FALSE) return 0;
  tcp_info info{};
  socklen_t size = sizeof(info);
  const int file = g_socket_get_fd(socket_.get());
  return getsockopt(file, IPPROTO_TCP, TCP_INFO, &info, &size) == 0 ? info.tcpi_bytes_received : 0;
}

}  // namespace mor::internal::push
