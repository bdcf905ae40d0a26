// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstring>
#include <string>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace mor::fork_server {

inline sockaddr_un address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof(address.sun_path) - 1);
  return address;
}

/// A connection that keeps packets apart; -1 where nobody listens.
inline int connect_to(const std::string& path) {
  const int fd = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  const sockaddr_un address = address_of(path);
  if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0) return fd;
  ::close(fd);
  return -1;
}

/// Room for two files beside a packet.
struct Packet {
  static constexpr std::size_t kFilesBytes = 2 * sizeof(int);
  alignas(cmsghdr) std::array<char, CMSG_SPACE(kFilesBytes)> control{};
  iovec text{};
  msghdr head{};

  Packet(char* bytes, std::size_t num_bytes) {
    text = {bytes, num_bytes};
    head.msg_iov = &text;
    head.msg_iovlen = 1;
    head.msg_control = control.data();
    head.msg_controllen = control.size();
  }
  void attach(const std::array<int, 2>& files) {
    cmsghdr* part = CMSG_FIRSTHDR(&head);
    part->cmsg_level = SOL_SOCKET;
    part->cmsg_type = SCM_RIGHTS;
    part->cmsg_len = CMSG_LEN(kFilesBytes);
    std::memcpy(CMSG_DATA(part), files.data(), kFilesBytes);
  }
  /// After recvmsg(): whether there are files, and which.
  bool detach(std::array<int, 2>& files) {
    cmsghdr* part = CMSG_FIRSTHDR(&head);
    if (part == nullptr || part->cmsg_type != SCM_RIGHTS || part->cmsg_len != CMSG_LEN(kFilesBytes))
      return false;
    std::memcpy(files.data(), CMSG_DATA(part), kFilesBytes);
    return true;
  }
};

}  // namespace mor::fork_server
