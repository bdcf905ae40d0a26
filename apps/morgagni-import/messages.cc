// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "messages.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
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
void say_weakness(std::string_view sentence) {
  say('w', sentence);
}

void say_series(const CtSeries& series) {
  std::string line;
  for (std::string field : {series.uid,
                            series.description,
                            series.patient_id,
                            series.patient_position,
                            std::to_string(series.num_slices),
                            std::to_string(series.columns),
                            std::to_string(series.rows),
                            std::to_string(series.min_gap_mm),
                            std::to_string(series.max_gap_mm),
                            series.frame_of_reference_uid}) {
    constexpr std::size_t kMaxFieldBytes = 128;
    field.resize(std::min(field.size(), kMaxFieldBytes));
    std::replace(field.begin(), field.end(), '\t', ' ');
    line += field + '\t';
  }
  say('s', line);
}

void say_label(int value, const std::array<double, 3>& color, std::string_view name) {
  std::string line = std::to_string(value);
  for (const double channel : color) line += ' ' + std::to_string(channel);
  say('l', line + ' ' + std::string(name));
}

void say_num_maps(std::size_t num_maps) {
  say('k', std::to_string(num_maps));
}

void say_frame(std::string_view frame) {
  say('c', frame);
}

std::string short_text(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", number);
  return text.data();
}

std::string some_of(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 5;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i)
    text += (i == 0 ? "" : ", ") + names[i];
  if (names.size() > kMost) text += " and " + std::to_string(names.size() - kMost) + " more";
  return text;
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

}  // namespace mor::import
