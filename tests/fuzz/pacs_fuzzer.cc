// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// What a PACS says, and what the process that talks to one tells its parent. The first byte says
// which parser, and in pieces of which size the bytes come.
#include <algorithm>
#include <cstdint>
#include <span>
#include <string>

#include "morgagni/pacs/internal/dicom_json.h"
#include "morgagni/pacs/internal/dimse_talk.h"
#include "morgagni/pacs/internal/multipart_reader.h"
#include "morgagni/pacs/internal/part10.h"
#include "morgagni/pacs/internal/tag_values.h"

namespace {

using namespace mor::internal;

/// Calls `take` with the text in pieces until it says no.
template <class Take>
void in_pieces(std::string_view text, std::size_t piece_bytes, const Take& take) {
  for (std::size_t at = 0; at < text.size(); at += piece_bytes)
    if (!take(text.substr(at, piece_bytes))) return;
}

/// The first line is the answer's Content-Type.
void read_multipart(std::string_view text, std::size_t piece_bytes) {
  const auto end = std::min(text.find('\n'), text.size());
  const auto boundary = multipart_boundary(std::string(text.substr(0, end)));
  std::string part;
  bool is_open = false;
  const PartSink sink = {.begin = [&]() -> mor::Result<void> {
                           if (is_open) __builtin_trap();
                           part.clear();
                           is_open = true;
                           return {};
                         },
                         .data = [&](std::string_view bytes) -> mor::Result<void> {
                           if (!is_open) __builtin_trap();
                           part += bytes;
                           return {};
                         },
                         .end = [&]() -> mor::Result<void> {
                           if (!is_open) __builtin_trap();
                           is_open = false;
                           (void)part10_uid(std::string_view(part).substr(0, kPart10HeadBytes));
                           return {};
                         }};
  MultipartReader reader(boundary.value_or("b"), sink);
  in_pieces(text.substr(std::min(end + 1, text.size())), piece_bytes, [&](std::string_view bytes) {
    return reader.feed(bytes).has_value();
  });
  (void)reader.finish();
}

void read_json(std::string_view text) {
  const auto objects = parse_dicom_json(text);
  if (!objects) return;
  for (const auto& values : *objects) {
    (void)study_of(values);
    (void)series_of(values, "1.2");
  }
}

void hear_dimse(std::string_view text, std::size_t piece_bytes) {
  const DimseEvents events = {.match = [](TagValues values) { (void)study_of(values); },
                              .stored = [](const std::filesystem::path& /*file*/, TagValues) {},
                              .caller = [](std::string) {},
                              .refused = [](std::string) {}};
  DimseTalk talk(events);
  in_pieces(text, piece_bytes, [&](std::string_view bytes) {
    talk.hear(bytes);
    return !talk.is_broken();
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  const std::size_t piece_bytes = 1 + (data[0] >> 2U) * std::size_t{7};
  switch (data[0] & 3U) {
    case 0:
      read_multipart(text, piece_bytes);
      break;
    case 1:
      read_json(text);
      break;
    case 2:
      hear_dimse(text, piece_bytes);
      break;
    default:
      (void)part10_uid(text);
  }
  return 0;
}
