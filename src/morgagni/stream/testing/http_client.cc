// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/stream/testing/http_client.h"

#include <array>
#include <cstdlib>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace mor::testing {

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds kAnswerLimit{10};

}  // namespace

RawClient::RawClient(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  // A refused connection shows as an empty answer.
  (void)!::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
}

RawClient::~RawClient() {
  ::close(socket_);
}

void RawClient::send(const std::string& bytes) const {
  for (std::size_t sent = 0; sent < bytes.size();) {
    const auto count = ::send(socket_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (count <= 0) return;
    sent += static_cast<std::size_t>(count);
  }
}

std::string RawClient::read_until(const std::string& text, std::chrono::milliseconds limit) const {
  std::string all;
  const auto end = Clock::now() + limit;
  while (all.find(text) == std::string::npos) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    pollfd ready{socket_, POLLIN, 0};
    if (left.count() <= 0 || ::poll(&ready, 1, static_cast<int>(left.count())) <= 0) break;
    std::array<char, 65536> buffer;
    const auto count = ::recv(socket_, buffer.data(), buffer.size(), 0);
    if (count <= 0) break;
    all.append(buffer.data(), static_cast<std::size_t>(count));
  }
  return all;
}

ClientResponse request(std::uint16_t port,
                       const std::string& method,
                       const std::string& path,
                       const std::string& body,
                       const std::string& head_lines) {
  const RawClient client(port);
  client.send(method + " " + path + " HTTP/1.1\r\n" + head_lines +
              "Connection: close\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" +
              body);
  // With "Connection: close" the answer ends where the connection does.
  const std::string all = client.read_until("\x01never\x01", kAnswerLimit);
  ClientResponse response;
  const auto end_of_head = all.find("\r\n\r\n");
  if (end_of_head == std::string::npos || !all.starts_with("HTTP/1.1 ")) return response;
  response.status = std::atoi(all.c_str() + 9);
  response.head = all.substr(0, end_of_head + 2);
  response.body = all.substr(end_of_head + 4);
  return response;
}

}  // namespace mor::testing
