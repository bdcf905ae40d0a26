// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "morgagni/camera/internal/push/messages.h"
#include "morgagni/core/result.h"

namespace mor::internal::push {

enum class StatusLevel : std::uint8_t { kInfo = 0, kWarning = 1, kError = 2 };

/// A `status` of the protocol.
struct Status {
  StatusLevel level = StatusLevel::kInfo;
  std::string message;
};

/// A message with the topic it came on.
struct Arrival {
  std::string topic;
  Message message;
};

/// What one client has advertised, by the Foxglove WebSocket protocol v1 (clientPublish). Without a
/// socket: it takes messages and says what is to be answered.
class ClientChannels {
 public:
  /// `serverInfo` and an empty `advertise`, which a server sends first.
  [[nodiscard]] static std::vector<std::string> greeting();
  [[nodiscard]] static std::string status_json(const Status& status);

  /// `advertise` and `unadvertise`. An `advertise` may have a member `device`, an id by which its
  /// sender is known again. @return What was refused, or is not used.
  [[nodiscard]] std::vector<Status> on_text(std::string_view text);

  /// What the sender calls itself. Empty: it has not said.
  [[nodiscard]] const std::string& device() const { return device_; }
  /// The same, said in another way. @return What is wrong with it.
  [[nodiscard]] std::optional<Status> set_device(const std::string& name);

  /// MessageData. None: of a channel that is not used.
  /// @errors kInvalidArgument: another opcode, a channel that was not advertised, a bad message.
  [[nodiscard]] Result<std::optional<Arrival>> on_binary(std::span<const std::byte> bytes) const;

 private:
  struct Channel {
    std::string topic;
    std::optional<MessageKind> kind;  ///< None: not used.
    Encoding encoding = Encoding::kCdr;
  };

  // Of one item of a list. None: there is nothing to answer.
  template <class Json>
  std::optional<Status> advertise(const Json& json);
  template <class Json>
  std::optional<Status> unadvertise(const Json& json);

  std::map<std::uint32_t, Channel> channels_;
  std::string device_;
};

}  // namespace mor::internal::push
