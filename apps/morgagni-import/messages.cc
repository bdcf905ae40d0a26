// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "messages.h"

#include <algorithm>
#include <cerrno>
#include <string>

#include <unistd.h>

namespace mor::import {
namespace {

constexpr std::size_t kMaxSentenceBytes = 2000;

bool write_all(int fd, const void* data, std::size_t num_bytes) {
  const char* bytes = static_cast<const char*>(data);
  while (num_bytes > 0) {
    const ssize_t written = ::write(fd, bytes, num_bytes);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes += written;
    num_bytes -= static_cast<std::size_t>(written);
  }
  return true;
}

void say(char kind, std::string_view text) {
  std::string line = {kind, ' '};
  line += text.substr(0, kMaxSentenceBytes);
  std::replace(line.begin(), line.end(), '\n', ' ');
  line += '\n';
  // Nobody listening means that the parent is gone: there is no one left to tell.
  (void)write_all(kImportMessagesFd, line.data(), line.size());
}

}  // namespace

void say_progress(double fraction) {
  say('p', std::to_string(fraction));
}
void say_file(std::string_view name) {
  say('f', name);
}
void say_note(std::string_view sentence) {
  say('n', sentence);
}

void say_error(const Error& error) {
  say('e', std::to_string(static_cast<int>(error.code)) + " " + error.message);
}

void set_description(ImportHeader& header, std::string_view text) {
  header.description.fill('\0');
  std::copy_n(text.begin(),
              std::min(text.size(), header.description.size() - 1),
              header.description.begin());
}

Result<void> hand_over(const ImportedVolume& volume) {
  if (!write_all(kImportVoxelsFd, &volume.header, sizeof(volume.header)) ||
      !write_all(kImportVoxelsFd, volume.hu.data(), volume.hu.size() * sizeof(std::int16_t)))
    return make_error(ErrorCode::kIo, "there is not enough memory to hand the CT over");
  return {};
}

}  // namespace mor::import
