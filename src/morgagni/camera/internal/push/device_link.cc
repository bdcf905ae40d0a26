// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/push/device_link.h"

#include "morgagni/core/log.h"

namespace mor::internal::push {
namespace {

using Clock = std::chrono::steady_clock;

constexpr guint64 kMaxMessageBytes = 32U << 20U;
constexpr guint64 kMaxHeadBytes = 1U << 20U;  ///< Of a message's parts, and of pongs.
constexpr guint kPingS = 3;
constexpr int kMaxSaid = 200;
constexpr std::chrono::seconds kSameAgainAfter{1};

}  // namespace

DeviceLink::DeviceLink(SoupWebsocketConnection* connection,
                       GSocket* socket,
                       const std::string& name,
                       Inbox& inbox)
    : connection_(SOUP_WEBSOCKET_CONNECTION(g_object_ref(connection))),
      guard_(socket, kMaxMessageBytes + kMaxHeadBytes),
      inbox_(inbox) {
  soup_websocket_connection_set_max_incoming_payload_size(connection, kMaxMessageBytes);
  soup_websocket_connection_set_keepalive_interval(connection, kPingS);
  g_signal_connect(
      connection,
      "message",
      G_CALLBACK(
          +[](SoupWebsocketConnection*, SoupWebsocketDataType type, GBytes* bytes, gpointer self) {
            static_cast<DeviceLink*>(self)->on_message(type, bytes);
          }),
      this);
  g_signal_connect(connection,
                   "closed",
                   G_CALLBACK(+[](SoupWebsocketConnection*, gpointer self) {
                     log::info("push: the device has gone");
                     static_cast<DeviceLink*>(self)->inbox_.device_went();
                   }),
                   this);
  log::info("push: a device is connected");
  inbox_.device_came();
  for (const auto& text : ClientChannels::greeting()) {
    soup_websocket_connection_send_text(connection, text.c_str());
  }
  if (name.empty()) return;
  if (const auto wrong = channels_.set_device(name)) {
    refuse(*wrong);
  } else {
    inbox_.device_is(channels_.device());
  }
}

DeviceLink::~DeviceLink() {
  g_signal_handlers_disconnect_by_data(connection_.get(), this);
  if (is_open()) {
    soup_websocket_connection_close(connection_.get(), SOUP_WEBSOCKET_CLOSE_GOING_AWAY, nullptr);
  }
  inbox_.device_went();
}

void DeviceLink::turn_away(SoupWebsocketConnection* connection, const std::string& why) {
  const auto text = ClientChannels::status_json({StatusLevel::kError, why});
  soup_websocket_connection_send_text(connection, ClientChannels::greeting().front().c_str());
  soup_websocket_connection_send_text(connection, text.c_str());
  soup_websocket_connection_close(connection, SOUP_WEBSOCKET_CLOSE_POLICY_VIOLATION, why.c_str());
}

bool DeviceLink::is_open() const {
  return soup_websocket_connection_get_state(connection_.get()) == SOUP_WEBSOCKET_STATE_OPEN;
}

void DeviceLink::say(const Status& status) {
  const auto now = Clock::now();
  if (!is_open() || (status.message == last_said_ && now - last_said_at_ < kSameAgainAfter)) return;
  last_said_ = status.message;
  last_said_at_ = now;
  soup_websocket_connection_send_text(connection_.get(),
                                      ClientChannels::status_json(status).c_str());
  if (++num_said_ > kMaxSaid) close("too much of what was sent cannot be used");
}

void DeviceLink::close(const std::string& why) {
  if (!is_open()) return;
  log::warn("push: the device is hung up on: {}", why);
  soup_websocket_connection_close(
      connection_.get(), SOUP_WEBSOCKET_CLOSE_POLICY_VIOLATION, why.c_str());
}

void DeviceLink::watch() {
  if (is_open() && !guard_.check()) close("a message that has no end");
}

void DeviceLink::on_message(SoupWebsocketDataType type, GBytes* bytes) {
  last_heard_ = Clock::now();
  guard_.on_message();
  gsize size = 0;
  const auto* data = static_cast<const std::byte*>(g_bytes_get_data(bytes, &size));
  if (type == SOUP_WEBSOCKET_DATA_BINARY) return take({data, size});
  for (const auto& status : channels_.on_text({reinterpret_cast<const char*>(data), size})) {
    refuse(status);
  }
  if (!channels_.device().empty()) inbox_.device_is(channels_.device());
}

void DeviceLink::refuse(const Status& status) {
  if (status.level == StatusLevel::kError) inbox_.refuse(status.message);
  say(status);
}

void DeviceLink::take(std::span<const std::byte> bytes) {
  auto arrival = channels_.on_binary(bytes);
  Result<void> taken;
  if (!arrival) {
    taken = tl::unexpected<Error>(arrival.error());
  } else if (*arrival) {
    taken = inbox_.put(**std::move(arrival), last_heard_);
  }
  if (taken) return;
  inbox_.refuse(taken.error().message);
  say({StatusLevel::kError, taken.error().message});
}

}  // namespace mor::internal::push
