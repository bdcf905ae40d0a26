// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/stream/internal/static_files.h"

#include <algorithm>
#include <array>
#include <utility>

#include "morgagni/core/files.h"

namespace mor::internal {

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxFileBytes = 32 * 1024 * 1024;

constexpr std::array<std::pair<std::string_view, std::string_view>, 12> kContentTypes{{
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".json", "application/json"},
    {".map", "application/json"},
    {".webmanifest", "application/manifest+json"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".ico", "image/x-icon"},
    {".woff2", "font/woff2"},
    {".txt", "text/plain; charset=utf-8"},
    {".wasm", "application/wasm"},
}};

std::string_view content_type_of(const fs::path& file) {
  const std::string extension = file.extension().string();
  const auto* const found = std::find_if(kContentTypes.begin(),
                                         kContentTypes.end(),
                                         [&](const auto& type) { return type.first == extension; });
  return found != kContentTypes.end() ? found->second : "application/octet-stream";
}

/// The path below the root; none where a part of it could lead elsewhere.
std::optional<fs::path> relative_path(std::string_view url_path) {
  if (!url_path.starts_with('/')) return std::nullopt;
  fs::path path;
  for (url_path.remove_prefix(1); !url_path.empty();) {
    const auto end = std::min(url_path.find('/'), url_path.size());
    const auto part = url_path.substr(0, end);
    const bool is_plain = !part.empty() && part.front() != '.' &&
                          part.find_first_of(std::string_view("\\\0:", 3)) == part.npos;
    if (!is_plain) return std::nullopt;
    path /= part;
    url_path.remove_prefix(std::min(end + 1, url_path.size()));
  }
  return path.empty() ? fs::path("index.html") : path;
}

bool is_inside(const fs::path& root, const fs::path& file) {
  return std::mismatch(root.begin(), root.end(), file.begin(), file.end()).first == root.end();
}

}  // namespace

std::optional<StaticFile> read_static_file(const fs::path& root, std::string_view url_path) {
  const auto relative = relative_path(url_path);
  if (!relative) return std::nullopt;
  std::error_code error;
  const fs::path real_root = fs::canonical(root, error);
  if (error) return std::nullopt;
  const fs::path file = fs::canonical(real_root / *relative, error);
  if (error || !is_inside(real_root, file) || !fs::is_regular_file(file, error))
    return std::nullopt;
  auto bytes = read_text_file(file, kMaxFileBytes);
  if (!bytes) return std::nullopt;
  return StaticFile{.content_type = std::string(content_type_of(file)),
                    .bytes = *std::move(bytes),
                    .never_changes = *relative->begin() == "assets"};
}

}  // namespace mor::internal
