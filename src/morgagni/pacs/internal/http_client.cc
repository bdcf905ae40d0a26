// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/pacs/internal/http_client.h"

#include <array>
#include <vector>

#include <libsoup/soup.h>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/glib_handles.h"
#include "morgagni/core/version.h"

namespace mor::internal {
namespace {

constexpr std::size_t kReadBytes = 1U << 18U;

Error error_of(const std::string& host, const GError& error) {
  if (g_error_matches(&error, G_IO_ERROR, G_IO_ERROR_CANCELLED) != FALSE)
    return {ErrorCode::kCancelled, "stopped"};
  if (g_error_matches(&error, G_IO_ERROR, G_IO_ERROR_TIMED_OUT) != FALSE)
    return {ErrorCode::kTimeout, fmt::format("{} does not answer (--timeout-s)", host)};
  if (error.domain == G_TLS_ERROR) {
    return {ErrorCode::kInvalidArgument,
            fmt::format("{}: TLS failed; perhaps it wants a certificate of ours "
                        "(--certificate, --key): {}",
                        host,
                        error.message)};
  }
  return {ErrorCode::kIo, fmt::format("{}: {}", host, error.message)};
}

/// Why a certificate is refused, the first reason that a user can do something about.
std::string words_of(GTlsCertificateFlags flags) {
  if ((flags & G_TLS_CERTIFICATE_UNKNOWN_CA) != 0)
    return "nobody who is trusted (--ca) vouches for it";
  if ((flags & G_TLS_CERTIFICATE_BAD_IDENTITY) != 0) return "it is made out to another host";
  if ((flags & G_TLS_CERTIFICATE_EXPIRED) != 0) return "it has expired";
  if ((flags & G_TLS_CERTIFICATE_NOT_ACTIVATED) != 0) return "it is not valid yet";
  if ((flags & G_TLS_CERTIFICATE_REVOKED) != 0) return "it was revoked";
  return "it is not safe";
}

/// What a status other than 200 means for a user.
Error refusal_of(const std::string& host, int status, const char* location) {
  const char* phrase = soup_status_get_phrase(static_cast<guint>(status));
  const auto said = fmt::format("{} answers {} {}", host, status, phrase);
  if (status == SOUP_STATUS_UNAUTHORIZED || status == SOUP_STATUS_FORBIDDEN) {
    return {ErrorCode::kInvalidArgument,
            said + ": user, password or token (--user, --password-file, --token-file)"};
  }
  if (status == SOUP_STATUS_NOT_FOUND)
    return {ErrorCode::kNotFound, said + ": not there, or the address is not DICOMweb's"};
  if (SOUP_STATUS_IS_REDIRECTION(status)) {
    return {ErrorCode::kInvalidArgument,
            fmt::format("{}: give the address it points to, {}",
                        said,
                        terminal_text(location == nullptr ? "none" : location))};
  }
  const bool may_pass = SOUP_STATUS_IS_SERVER_ERROR(status) || status == 429 || status == 408;
  return {may_pass ? ErrorCode::kIo : ErrorCode::kUnsupported, said};
}

class SoupClient : public HttpClient {
 public:
  SoupClient(const PacsOptions& options, GObjectHandle<GTlsCertificate> certificate)
      : session_(soup_session_new()), certificate_(std::move(certificate)) {
    soup_session_set_timeout(session_.get(), static_cast<guint>(options.timeout.count()));
    soup_session_set_user_agent(session_.get(), fmt::format("morgagni/{}", kVersion).c_str());
    soup_session_set_proxy_resolver(session_.get(), nullptr);
    if (!options.token.empty()) {
      authorization_ = "Bearer " + options.token;
    } else if (!options.user.empty()) {
      const std::string pair = options.user + ":" + options.password;
      const GCharHandle coded(
          g_base64_encode(reinterpret_cast<const guchar*>(pair.data()), pair.size()));
      authorization_ = std::string("Basic ") + coded.get();
    }
  }

  void trust(GTlsDatabase* database) { soup_session_set_tls_database(session_.get(), database); }

  Result<void> get(const std::string& url,
                   const std::string& accept,
                   const HttpSink& sink,
                   std::stop_token stop) override {
    const GObjectHandle<SoupMessage> message(soup_message_new("GET", url.c_str()));
    if (!message) return make_error(ErrorCode::kInvalidArgument, url + ": not an address");
    const std::string host = g_uri_get_host(soup_message_get_uri(message.get()));
    prepare(*message, accept);
    std::string refusal;
    g_signal_connect(
        message.get(),
        "accept-certificate",
        G_CALLBACK(+[](SoupMessage*, GTlsCertificate*, GTlsCertificateFlags flags, gpointer refused)
                       -> gboolean {
          *static_cast<std::string*>(refused) = words_of(flags);
          return FALSE;
        }),
        &refusal);
    const GObjectHandle<GCancellable> cancellable(g_cancellable_new());
    const std::stop_callback cancel(stop, [&] { g_cancellable_cancel(cancellable.get()); });
    GError* raw_error = nullptr;
    const GObjectHandle<GInputStream> body(
        soup_session_send(session_.get(), message.get(), cancellable.get(), &raw_error));
    g_signal_handlers_disconnect_by_data(message.get(), &refusal);
    if (const GErrorHandle error(raw_error); error) {
      if (refusal.empty()) return tl::unexpected<Error>(error_of(host, *error));
      return make_error(ErrorCode::kInvalidArgument,
                        fmt::format("{}: its TLS certificate is not trusted: {}", host, refusal));
    }
    MOR_CHECK(hear_head(*message, host, sink));
    return hear_body(*body, *cancellable, host, sink);
  }

 private:
  void prepare(SoupMessage& message, const std::string& accept) {
    soup_message_add_flags(&message, SOUP_MESSAGE_NO_REDIRECT);
    auto* head = soup_message_get_request_headers(&message);
    soup_message_headers_replace(head, "Accept", accept.c_str());
    if (!authorization_.empty())
      soup_message_headers_replace(head, "Authorization", authorization_.c_str());
    if (certificate_) soup_message_set_tls_client_certificate(&message, certificate_.get());
  }

  static Result<void> hear_head(SoupMessage& message,
                                const std::string& host,
                                const HttpSink& sink) {
    const int status = static_cast<int>(soup_message_get_status(&message));
    auto* head = soup_message_get_response_headers(&message);
    if (status != SOUP_STATUS_OK && status != SOUP_STATUS_NO_CONTENT) {
      return tl::unexpected<Error>(
          refusal_of(host, status, soup_message_headers_get_one(head, "Location")));
    }
    const char* type = soup_message_headers_get_one(head, "Content-Type");
    return sink.head({status, type == nullptr ? "" : type});
  }

  Result<void> hear_body(GInputStream& body,
                         GCancellable& cancellable,
                         const std::string& host,
                         const HttpSink& sink) {
    while (true) {
      GError* raw_error = nullptr;
      const gssize count =
          g_input_stream_read(&body, buffer_.data(), buffer_.size(), &cancellable, &raw_error);
      const GErrorHandle error(raw_error);
      if (count < 0) return tl::unexpected<Error>(error_of(host, *error));
      if (count == 0) return {};
      MOR_CHECK(sink.data({buffer_.data(), static_cast<std::size_t>(count)}));
    }
  }

  GObjectHandle<SoupSession> session_;
  GObjectHandle<GTlsCertificate> certificate_;
  std::string authorization_;
  std::vector<char> buffer_ = std::vector<char>(kReadBytes);
};

}  // namespace

Result<std::unique_ptr<HttpClient>> HttpClient::create(const PacsOptions& options) {
  const auto& tls = options.tls;
  const auto unusable = [](const std::filesystem::path& file, const GError& error) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{}: cannot be used for TLS: {}", file.string(), error.message));
  };
  GObjectHandle<GTlsCertificate> certificate;
  GError* raw_error = nullptr;
  if (!tls.certificate.empty()) {
    certificate.reset(
        g_tls_certificate_new_from_files(tls.certificate.c_str(), tls.key.c_str(), &raw_error));
    if (const GErrorHandle error(raw_error); error) return unusable(tls.certificate, *error);
  }
  auto client = std::make_unique<SoupClient>(options, std::move(certificate));
  if (!tls.ca.empty()) {
    const auto absolute = std::filesystem::absolute(tls.ca);
    const GObjectHandle<GTlsDatabase> database(
        g_tls_file_database_new(absolute.c_str(), &raw_error));
    if (const GErrorHandle error(raw_error); error) return unusable(tls.ca, *error);
    client->trust(database.get());
  }
  return client;
}

}  // namespace mor::internal
