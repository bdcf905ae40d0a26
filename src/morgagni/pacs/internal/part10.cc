// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/pacs/internal/part10.h"

#include <cstdint>

#include "morgagni/pacs/pacs_peer.h"

namespace mor::internal {
namespace {

constexpr std::size_t kPreambleBytes = 128;
constexpr std::uint32_t kMetaGroup = 0x0002;
constexpr std::uint32_t kSopInstanceUid = 0x0003;

std::uint32_t number_at(std::string_view bytes, std::size_t at, int num_bytes) {
  std::uint32_t number = 0;
  for (int i = num_bytes - 1; i >= 0; --i)
    number = number << 8U | static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(i)]);
  return number;
}

/// Value representations whose length has four bytes, after two empty ones.
bool has_long_length(std::string_view vr) {
  return vr == "OB" || vr == "OW" || vr == "UN" || vr == "SQ" || vr == "UT" || vr == "OF" ||
         vr == "OD" || vr == "OL" || vr == "UC" || vr == "UR" || vr == "OV" || vr == "SV" ||
         vr == "UV";
}

}  // namespace

Result<std::string> part10_uid(std::string_view head) {
  if (head.size() < kPreambleBytes + 4 || head.substr(kPreambleBytes, 4) != "DICM")
    return make_error(ErrorCode::kIo, "the answer is no DICOM file");
  constexpr std::size_t kShortHead = 8;
  constexpr std::size_t kLongHead = 12;
  for (std::size_t at = kPreambleBytes + 4; at + kLongHead <= head.size();) {
    if (number_at(head, at, 2) != kMetaGroup) break;
    const bool is_long = has_long_length(head.substr(at + 4, 2));
    const std::size_t length = is_long ? number_at(head, at + 8, 4) : number_at(head, at + 6, 2);
    const std::size_t value = at + (is_long ? kLongHead : kShortHead);
    if (length > head.size() - std::min(value, head.size())) break;
    if (number_at(head, at + 2, 2) == kSopInstanceUid) {
      auto uid = head.substr(value, length);
      uid = uid.substr(0, uid.find_last_not_of(std::string_view("\0 ", 2)) + 1);
      if (is_dicom_uid(uid)) return std::string(uid);
      break;
    }
    at = value + length;
  }
  return make_error(ErrorCode::kIo, "a DICOM file without a proper SOP Instance UID");
}

}  // namespace mor::internal
