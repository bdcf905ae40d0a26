// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/printable_text.h"

#include <algorithm>

#include <glib.h>

namespace mor {
namespace {

/// As UTF-8, whatever it was. @param text  Without zero bytes, which end a text for GLib.
std::string as_utf8(const std::string& text) {
  const auto num_bytes = static_cast<gssize>(text.size());
  const char* end = nullptr;
  if (g_utf8_validate_len(text.data(), text.size(), &end) != FALSE) return text;
  constexpr auto kCutOff = static_cast<gunichar>(-2);
  if (g_utf8_get_char_validated(end, num_bytes - (end - text.data())) == kCutOff)
    return std::string(text.data(), end);
  std::string converted;
  for (const char byte : text) {
    const auto letter = static_cast<unsigned char>(byte);
    if (letter < 0x80) {
      converted += byte;
    } else {
      converted += static_cast<char>(0xc0U | letter >> 6U);
      converted += static_cast<char>(0x80U | (letter & 0x3fU));
    }
  }
  return converted;
}

}  // namespace

std::string printable_text(std::string_view text) {
  std::string without_zeros(text);
  std::replace(without_zeros.begin(), without_zeros.end(), '\0', ' ');
  const std::string valid = as_utf8(without_zeros);
  std::string printable;
  for (const char* at = valid.data(); at < valid.data() + valid.size();) {
    const gunichar letter = g_utf8_get_char(at);
    const char* next = g_utf8_next_char(at);
    const bool is_harmless =
        g_unichar_isprint(letter) != FALSE && g_unichar_type(letter) != G_UNICODE_FORMAT;
    if (is_harmless) {
      printable.append(at, next);
    } else {
      printable += ' ';
    }
    at = next;
  }
  return printable;
}

}  // namespace mor
