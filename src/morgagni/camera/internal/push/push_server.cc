// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/push/push_server.h"

#include <cstring>

#include <libsoup/soup.h>
#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/internal/push/device_link.h"
#include "morgagni/core/glib_handles.h"
#include "morgagni/core/log.h"
#include "morgagni/core/main_loop.h"

namespace mor::internal::push {
namespace {

using Clock = std::chrono::steady_clock;

constexpr guint kUpgradeRequired = 426;
constexpr int kMaxConnections = 16;
/// A connection on which nothing comes for so long, not even the answer to a ping, is closed.
constexpr guint kSilenceS = 10;
constexpr std::chrono::seconds kYieldsAfter{1};
constexpr std::chrono::milliseconds kWatchPeriod{20};
constexpr std::uint64_t kMaxAfterRefusal = 1U << 16U;
/// The first is current, the second came before; a client says which it speaks.
const char* const kProtocols[] = {"foxglove.sdk.v1", "foxglove.websocket.v1", nullptr};

bool is_loopback(std::string_view host) {
  return host == "localhost" || host == "127.0.0.1" || host == "[::1]" || host == "::1";
}

/// The host of "https://host:port".
bool is_local_page(const char* origin) {
  const std::unique_ptr<GUri, FreeWith<g_uri_unref>> uri(
      g_uri_parse(origin, G_URI_FLAGS_NONE, nullptr));
  const char* host = uri ? g_uri_get_host(uri.get()) : nullptr;
  return host != nullptr && is_loopback(host);
}

/// As long for a wrong token as for the right one.
bool is_same(std::string_view a, std::string_view b) {
  unsigned difference = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference |=
        static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(i < b.size() ? b[i] : ~a[i]);
  }
  return difference == 0;
}

/// In the address as `?token=`, which pages can, or as `Authorization: Bearer`.
std::string token_of(SoupServerMessage* message, GHashTable* query) {
  const char* header = soup_message_headers_get_one(
      soup_server_message_get_request_headers(message), "Authorization");
  constexpr std::string_view kBearer = "Bearer ";
  if (header != nullptr && std::string_view(header).starts_with(kBearer)) {
    return header + kBearer.size();
  }
  const auto* value =
      query != nullptr ? static_cast<const char*>(g_hash_table_lookup(query, "token")) : nullptr;
  return value != nullptr ? value : "";
}

/// What the device calls itself in the address, `?device=`. Empty: nothing.
std::string name_of(SoupWebsocketConnection* connection) {
  const char* query = g_uri_get_query(soup_websocket_connection_get_uri(connection));
  if (query == nullptr) return {};
  const std::unique_ptr<GHashTable, FreeWith<g_hash_table_unref>> values(
      g_uri_parse_params(query, -1, "&", G_URI_PARAMS_NONE, nullptr));
  const auto* name =
      values ? static_cast<const char*>(g_hash_table_lookup(values.get(), "device")) : nullptr;
  return name != nullptr ? name : "";
}

/// The accepted connection, which libsoup wraps in a stream of its own.
GObjectHandle<GSocketConnection> carrier_of(SoupWebsocketConnection* connection) {
  auto* stream = soup_websocket_connection_get_io_stream(connection);
  GObject* base = nullptr;
  if (g_object_class_find_property(G_OBJECT_GET_CLASS(stream), "base-iostream") != nullptr) {
    g_object_get(stream, "base-iostream", &base, nullptr);
  }
  if (base == nullptr || G_IS_SOCKET_CONNECTION(base)) {
    return GObjectHandle<GSocketConnection>(reinterpret_cast<GSocketConnection*>(base));
  }
  g_object_unref(base);
  return nullptr;
}

void refuse(SoupServerMessage* message, guint status, const std::string& sentence) {
  soup_server_message_set_status(message, status, nullptr);
  soup_server_message_set_response(
      message, "text/plain", SOUP_MEMORY_COPY, sentence.c_str(), sentence.size());
}

Error listen_error(const GError* error, const std::string& place) {
  const bool is_taken = g_error_matches(error, G_IO_ERROR, G_IO_ERROR_ADDRESS_IN_USE) != FALSE;
  return {ErrorCode::kDevice,
          is_taken ? fmt::format("{} is in use: choose another port", place)
                   : fmt::format("{} cannot be listened at: {}", place, error->message)};
}

}  // namespace

struct PushServer::Impl {
  explicit Impl(PushServerOptions given) : options(std::move(given)) {}

  Result<std::uint16_t> listen();
  void close();
  void accept(GSocketConnection* connection);
  void judge(SoupServerMessage* message, GHashTable* query) const;
  void meet(SoupWebsocketConnection* connection);
  void watch();

  PushServerOptions options;
  std::shared_ptr<Inbox> inbox;
  std::string address;

  // The loop's alone.
  GObjectHandle<SoupServer> server;
  GObjectHandle<GSocketService> service;
  std::shared_ptr<void> places = std::make_shared<int>();  ///< Each connection holds it too.
  std::unique_ptr<DeviceLink> link;
  std::vector<MessageGuard> turned_away;

  MainLoop loop;  ///< Ends first.
};

Result<std::uint16_t> PushServer::Impl::listen() {
  const auto place = fmt::format("{}:{}", options.host, options.port);
  const GObjectHandle<GSocketAddress> wanted(
      g_inet_socket_address_new_from_string(options.host.c_str(), options.port));
  if (!wanted) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("'{}' is no IP address: push:PORT listens for this machine, "
                                  "push:0.0.0.0:PORT for all",
                                  options.host));
  }
  service.reset(g_socket_service_new());
  GSocketAddress* raw_found = nullptr;
  GError* raw_error = nullptr;
  if (g_socket_listener_add_address(G_SOCKET_LISTENER(service.get()),
                                    wanted.get(),
                                    G_SOCKET_TYPE_STREAM,
                                    G_SOCKET_PROTOCOL_TCP,
                                    nullptr,
                                    &raw_found,
                                    &raw_error) == FALSE) {
    const GErrorHandle error(raw_error);
    return tl::unexpected(listen_error(error.get(), place));
  }
  const GObjectHandle<GSocketAddress> found(raw_found);
  server.reset(soup_server_new("server-header", "Morgagni", nullptr));
  // A packed message of a few bytes could become any size.
  soup_server_remove_websocket_extension(server.get(), SOUP_TYPE_WEBSOCKET_EXTENSION_DEFLATE);
  soup_server_add_early_handler(
      server.get(),
      nullptr,
      [](SoupServer*, SoupServerMessage* message, const char*, GHashTable* query, gpointer self) {
        static_cast<const Impl*>(self)->judge(message, query);
      },
      this,
      nullptr);
  soup_server_add_websocket_handler(
      server.get(),
      "/",
      nullptr,
      const_cast<char**>(kProtocols),
      [](SoupServer*,
         SoupServerMessage*,
         const char*,
         SoupWebsocketConnection* connection,
         gpointer self) { static_cast<Impl*>(self)->meet(connection); },
      this,
      nullptr);
  g_signal_connect(
      service.get(),
      "incoming",
      G_CALLBACK(
          +[](GSocketService*, GSocketConnection* connection, GObject*, gpointer self) -> gboolean {
            static_cast<Impl*>(self)->accept(connection);
            return TRUE;
          }),
      this);
  return g_inet_socket_address_get_port(G_INET_SOCKET_ADDRESS(found.get()));
}

void PushServer::Impl::close() {
  link.reset();
  if (service) {
    g_socket_service_stop(service.get());
    g_socket_listener_close(G_SOCKET_LISTENER(service.get()));
  }
  if (server) soup_server_disconnect(server.get());
}

void PushServer::Impl::accept(GSocketConnection* connection) {
  if (places.use_count() > kMaxConnections) {
    g_io_stream_close(G_IO_STREAM(connection), nullptr, nullptr);
    return;
  }
  // A token that the connection carries to its end.
  g_object_set_data_full(G_OBJECT(connection),
                         "morgagni-place",
                         new std::shared_ptr<void>(places),
                         [](gpointer place) { delete static_cast<std::shared_ptr<void>*>(place); });
  g_socket_set_timeout(g_socket_connection_get_socket(connection), kSilenceS);
  const GObjectHandle<GSocketAddress> here(
      g_socket_connection_get_local_address(connection, nullptr));
  const GObjectHandle<GSocketAddress> there(
      g_socket_connection_get_remote_address(connection, nullptr));
  soup_server_accept_iostream(
      server.get(), G_IO_STREAM(connection), here.get(), there.get(), nullptr);
}

void PushServer::Impl::judge(SoupServerMessage* message, GHashTable* query) const {
  auto* headers = soup_server_message_get_request_headers(message);
  soup_message_body_set_accumulate(soup_server_message_get_request_body(message), FALSE);
  const char* origin = soup_message_headers_get_one(headers, "Origin");
  if (!options.token.empty()) {
    if (!is_same(options.token, token_of(message, query))) {
      refuse(message, SOUP_STATUS_UNAUTHORIZED, "the token is missing or wrong: ?token=...\n");
    }
    return;
  }
  if (origin != nullptr && !is_local_page(origin)) {
    refuse(message,
           SOUP_STATUS_FORBIDDEN,
           "a page of another site must say the token: start with push:PORT,token=...\n");
    return;
  }
  if (soup_message_headers_get_one(headers, "Sec-WebSocket-Key") == nullptr) {
    refuse(message,
           kUpgradeRequired,
           "cameras push here by WebSocket, subprotocol foxglove.websocket.v1 (docs/cameras.md)\n");
  }
}

void PushServer::Impl::meet(SoupWebsocketConnection* connection) {
  const auto carrier = carrier_of(connection);
  if (!carrier) {
    DeviceLink::turn_away(connection, "this connection is none that was accepted");
    return;
  }
  auto* socket = g_socket_connection_get_socket(carrier.get());
  if (link && link->is_open() && Clock::now() - link->last_heard() < kYieldsAfter) {
    DeviceLink::turn_away(connection, "another device is sending: one at a time");
    turned_away.emplace_back(socket, kMaxAfterRefusal);
    return;
  }
  if (link) link->close("another device has taken over");
  link.reset();  // It says that it went before the next says that it came.
  link = std::make_unique<DeviceLink>(connection, socket, name_of(connection), *inbox);
}

void PushServer::Impl::watch() {
  if (link) link->watch();
  std::erase_if(turned_away, [](MessageGuard& guard) { return !guard.check(); });
}

PushServer::PushServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

PushServer::~PushServer() {
  impl_->loop.post_and_wait([this] { impl_->close(); });
  impl_->loop.stop();
}

Result<std::unique_ptr<PushServer>> PushServer::start(const PushServerOptions& options,
                                                      const MakeInbox& make_inbox) {
  auto impl = std::make_unique<Impl>(options);
  impl->loop.run();
  auto server = std::unique_ptr<PushServer>(new PushServer(std::move(impl)));
  auto& made = *server->impl_;
  Result<std::uint16_t> port = 0;
  made.loop.post_and_wait([&] {
    port = made.listen();
    if (!port) return;
    // "::1" is written in brackets.
    const bool is_v6 = options.host.find(':') != std::string::npos;
    made.address = is_v6 ? fmt::format("ws://[{}]:{}", options.host, *port)
                         : fmt::format("ws://{}:{}", options.host, *port);
    made.inbox = make_inbox(made.address);
    made.loop.every(kWatchPeriod, [&made] { made.watch(); });
  });
  if (!port) return tl::unexpected<Error>(port.error());
  if (!is_loopback(options.host) && options.token.empty()) {
    log::warn("push: whoever reaches {} may send pictures: give token=...", made.address);
  }
  return server;
}

Inbox& PushServer::inbox() const {
  return *impl_->inbox;
}

const std::string& PushServer::address() const {
  return impl_->address;
}

void PushServer::complain(const std::string& sentence) {
  impl_->inbox->refuse(sentence);
  impl_->loop.post([impl = impl_.get(), sentence] {
    if (impl->link) impl->link->say({StatusLevel::kError, sentence});
  });
}

}  // namespace mor::internal::push
