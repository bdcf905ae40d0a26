// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/internal/zip_writer.h"

#include <memory>

#include <zip.h>

namespace mor::internal {
namespace {

using Source = std::unique_ptr<zip_source_t, decltype(&zip_source_free)>;

tl::unexpected<Error> failed(const std::string& why) {
  return make_error(ErrorCode::kInternal, "a ZIP file could not be made in memory: " + why);
}

Result<std::string> bytes_of(zip_source_t* source) {
  zip_stat_t status;
  zip_stat_init(&status);
  if (zip_source_stat(source, &status) != 0 || zip_source_open(source) != 0)
    return failed("it cannot be read back");
  std::string bytes(status.size, '\0');
  const auto count = zip_source_read(source, bytes.data(), bytes.size());
  zip_source_close(source);
  if (count != static_cast<zip_int64_t>(bytes.size())) return failed("it cannot be read back");
  return bytes;
}

}  // namespace

Result<std::string> zip(std::span<const ZipPart> parts) {
  const Source source(zip_source_buffer_create(nullptr, 0, 0, nullptr), zip_source_free);
  if (!source) return failed("out of memory");
  zip_source_keep(source.get());  // One reference is the archive's.
  zip_t* archive = zip_open_from_source(source.get(), ZIP_TRUNCATE, nullptr);
  if (archive == nullptr) {
    zip_source_free(source.get());
    return failed("it cannot be opened");
  }
  for (const auto& part : parts) {
    zip_source_t* bytes = zip_source_buffer(archive, part.bytes.data(), part.bytes.size(), 0);
    if (bytes != nullptr && zip_file_add(archive, part.name.c_str(), bytes, ZIP_FL_ENC_UTF_8) >= 0)
      continue;
    if (bytes != nullptr) zip_source_free(bytes);
    zip_discard(archive);
    return failed(part.name);
  }
  if (zip_close(archive) != 0) {
    const std::string why = zip_strerror(archive);
    zip_discard(archive);
    return failed(why);
  }
  return bytes_of(source.get());
}

}  // namespace mor::internal
