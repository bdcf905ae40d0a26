// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/pacs/pacs_address.h"

#include <algorithm>
#include <memory>

#include <arpa/inet.h>
#include <glib.h>
#include <spdlog/fmt/fmt.h>

namespace mor {
namespace {

constexpr int kDicomPort = 104;
constexpr int kDicomTlsPort = 2762;

struct FreeUri {
  void operator()(GUri* uri) const { g_uri_unref(uri); }
};
using UriHandle = std::unique_ptr<GUri, FreeUri>;

tl::unexpected<Error> wrong(std::string_view text, std::string_view why) {
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("{}: {}; a PACS is https://HOST/PATH, dicom://AET@HOST:PORT or "
                                "dicoms://AET@HOST:PORT",
                                text,
                                why));
}

Result<PacsAddress> dicomweb_of(const std::string& text, const GUri& parsed, PacsAddress address) {
  auto* uri = const_cast<GUri*>(&parsed);
  if (g_uri_get_query(uri) != nullptr || g_uri_get_fragment(uri) != nullptr)
    return wrong(text, "an address without ? and #");
  if (g_uri_get_userinfo(uri) != nullptr)
    return wrong(text, "a user goes to --user, not into the address");
  address.kind = PacsAddress::Kind::kDicomweb;
  address.url = text;
  while (address.url.ends_with('/')) address.url.pop_back();
  return address;
}

Result<PacsAddress> dimse_of(const std::string& text, const GUri& parsed, PacsAddress address) {
  auto* uri = const_cast<GUri*>(&parsed);
  const char* aet = g_uri_get_userinfo(uri);
  if (aet == nullptr) return wrong(text, "the AE title of the PACS is missing");
  const std::string_view path = g_uri_get_path(uri);
  if (!path.empty() && path != "/") return wrong(text, "DICOM's network has no path");
  MOR_CHECK(check_aet(aet, text));
  address.kind = PacsAddress::Kind::kDimse;
  address.aet = aet;
  if (address.port == 0)
    address.port = static_cast<std::uint16_t>(address.tls ? kDicomTlsPort : kDicomPort);
  return address;
}

}  // namespace

Result<void> check_aet(std::string_view aet, std::string_view name) {
  constexpr std::size_t kMaxLetters = 16;
  const bool printable =
      std::all_of(aet.begin(), aet.end(), [](char c) { return c >= ' ' && c <= '~' && c != '\\'; });
  if (!aet.empty() && aet.size() <= kMaxLetters && printable && aet.front() != ' ' &&
      aet.back() != ' ')
    return {};
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("{}: an AE title has 1 to 16 letters, digits and signs of ASCII, "
                                "without a backslash, got \"{}\"",
                                name,
                                aet));
}

bool is_loopback(std::string_view host) {
  constexpr std::uint32_t kLoopbackNet = 127;
  in_addr address{};
  const bool is_ip4 = ::inet_pton(AF_INET, std::string(host).c_str(), &address) == 1;
  return host == "localhost" || host == "::1" ||
         (is_ip4 && ntohl(address.s_addr) >> 24U == kLoopbackNet);
}

Result<PacsAddress> parse_pacs_address(std::string_view view) {
  const std::string text(view);
  const UriHandle uri(g_uri_parse(text.c_str(), G_URI_FLAGS_NONE, nullptr));
  if (!uri) return wrong(text, "not an address");
  const std::string_view scheme = g_uri_get_scheme(uri.get());
  const char* host = g_uri_get_host(uri.get());
  if (host == nullptr || *host == '\0') return wrong(text, "the host is missing");
  PacsAddress address;
  address.host = host;
  address.port = static_cast<std::uint16_t>(std::max(0, g_uri_get_port(uri.get())));
  address.tls = scheme == "https" || scheme == "dicoms";
  if (scheme == "http" || scheme == "https") return dicomweb_of(text, *uri, std::move(address));
  if (scheme == "dicom" || scheme == "dicoms") return dimse_of(text, *uri, std::move(address));
  return wrong(text, fmt::format("\"{}\" is not a way to a PACS", scheme));
}

}  // namespace mor
