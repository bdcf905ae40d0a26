// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <initializer_list>

#include <spdlog/fmt/fmt.h>

#include "dcmtk/config/osconfig.h"
#include "dcmtk/dcmdata/dctk.h"
#include "messages.h"

namespace mor::dimse {

/// "0020000D".
inline std::string hex_of(const DcmTagKey& key) {
  return fmt::format("{:04X}{:04X}", key.getGroup(), key.getElement());
}

/// The values that are there, all of each separated by backslashes, none longer than 1024 bytes.
inline Tags tags_of(DcmItem& dataset, std::initializer_list<DcmTagKey> keys) {
  constexpr std::size_t kMaxTextBytes = 1024;
  Tags tags;
  for (const auto& key : keys) {
    OFString value;
    if (dataset.findAndGetOFStringArray(key, value).bad()) continue;
    std::string text(value.c_str(), std::min(value.size(), kMaxTextBytes));
    const auto end = text.find_last_not_of(' ');
    text.resize(end == std::string::npos ? 0 : end + 1);
    tags[hex_of(key)] = text;
  }
  return tags;
}

}  // namespace mor::dimse
