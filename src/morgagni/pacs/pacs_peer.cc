// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/pacs/pacs_peer.h"

#include <algorithm>
#include <regex>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/printable_text.h"
#include "morgagni/pacs/internal/dicomweb_peer.h"
#include "morgagni/pacs/internal/dimse_peer.h"

namespace mor {
namespace {

Result<void> check_text(const std::string& text, std::string_view name) {
  constexpr std::size_t kMaxBytes = 64;
  const bool plain = std::none_of(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F || c == '\\'; });
  if (plain && text.size() <= kMaxBytes) return {};
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format("{}: at most {} bytes without control characters and backslashes", name, 64));
}

}  // namespace

Result<void> PacsOptions::check() const {
  MOR_CHECK(check_aet(aet, "--aet"));
  if (timeout.count() < 1 || timeout.count() > 3600) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("--timeout-s must be 1 to 3600, got {}", timeout.count()));
  }
  if (tls.certificate.empty() != tls.key.empty()) {
    return make_error(ErrorCode::kInvalidArgument,
                      "--certificate and --key belong together: a certificate and its private key");
  }
  if (!user.empty() && !token.empty())
    return make_error(ErrorCode::kInvalidArgument, "a user or a token, not both");
  return {};
}

Result<void> PacsFilter::check() const {
  MOR_CHECK(check_text(patient_name, "--patient-name"));
  MOR_CHECK(check_text(patient_id, "--patient-id"));
  MOR_CHECK(check_text(accession, "--accession"));
  static const std::regex kModality("[A-Z]{0,16}");
  if (!std::regex_match(modality, kModality)) {
    return make_error(ErrorCode::kInvalidArgument,
                      "--modality is one of DICOM's, as CT or SEG, got \"" + modality + "\"");
  }
  static const std::regex kDate("|\\d{8}|\\d{8}-(\\d{8})?|-\\d{8}");
  if (!std::regex_match(study_date, kDate)) {
    return make_error(ErrorCode::kInvalidArgument,
                      "--date is 20260131, 20260101-20260131, 20260101- or -20260131, got \"" +
                          study_date + "\"");
  }
  if (!study_uid.empty() && !is_dicom_uid(study_uid)) {
    return make_error(ErrorCode::kInvalidArgument,
                      "--study is a UID of digits and dots, got \"" + study_uid + "\"");
  }
  return {};
}

Result<std::unique_ptr<PacsPeer>> open_pacs_peer(const PacsAddress& address,
                                                 const PacsOptions& options) {
  MOR_CHECK(options.check());
  if (address.kind == PacsAddress::Kind::kDicomweb)
    return internal::open_dicomweb_peer(address, options);
  return internal::open_dimse_peer(address, options);
}

bool is_dicom_uid(std::string_view text) {
  constexpr std::size_t kMaxLetters = 64;
  return !text.empty() && text.size() <= kMaxLetters && text.front() != '.' && text.back() != '.' &&
         text.find("..") == std::string_view::npos &&
         text.find_first_not_of("0123456789.") == std::string_view::npos;
}

std::string terminal_text(std::string_view text) {
  constexpr std::size_t kMaxBytes = 200;
  return printable_text(text.substr(0, kMaxBytes));
}

}  // namespace mor
