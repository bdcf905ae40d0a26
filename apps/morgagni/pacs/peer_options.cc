// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "pacs/peer_options.h"

#include <cstdlib>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/files.h"

namespace mor {
namespace {

constexpr std::uint64_t kMb = 1000000;

/// A secret from a file, or from the environment; never from the command line, which others see.
Result<std::string> secret(const std::filesystem::path& file, const char* variable) {
  if (file.empty()) {
    const char* value = std::getenv(variable);
    return value == nullptr ? std::string() : std::string(value);
  }
  constexpr std::uintmax_t kMaxBytes = 65536;
  MOR_TRY(auto text, read_text_file(file, kMaxBytes));
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  if (text.find_first_of(std::string_view("\0\r\n", 3)) != std::string::npos) {
    return make_error(ErrorCode::kInvalidArgument, file.string() + ": more than one line");
  }
  return text;
}

void add_megabytes(CLI::App& command,
                   const std::string& name,
                   std::uint64_t& bytes,
                   const std::string& text) {
  command
      .add_option_function<std::uint64_t>(
          name, [&bytes](std::uint64_t megabytes) { bytes = megabytes * kMb; }, text)
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1000000}))
      ->default_str(std::to_string(bytes / kMb));
}

}  // namespace

void add_tls_options(CLI::App& command, PacsTls& tls) {
  command.add_option("--ca", tls.ca, "TLS: certificate (PEM) that vouches for the other side");
  command.add_option("--certificate", tls.certificate, "TLS: our own certificate (PEM)");
  command.add_option("--key", tls.key, "TLS: its private key (PEM, without a password)");
}

void add_size_options(CLI::App& command,
                      std::uint64_t& max_object_bytes,
                      std::uint64_t& min_free_bytes) {
  add_megabytes(command, "--max-object-mb", max_object_bytes, "Larger objects are refused");
  add_megabytes(command, "--min-free-mb", min_free_bytes, "So much of the disk is left free");
}

void add_peer_options(CLI::App& command, PeerArguments& arguments) {
  auto& options = arguments.options;
  auto& filter = arguments.filter;
  command
      .add_option("PACS",
                  arguments.address,
                  "https://HOST/PATH (DICOMweb), dicom://AET@HOST:PORT or dicoms://AET@HOST:PORT "
                  "(over TLS)")
      ->required();
  command.add_option(
      "--patient-name", filter.patient_name, "As in the PACS, Doe^J*; * and ? stand for others");
  command.add_option("--patient-id", filter.patient_id, "As in the PACS");
  command.add_option(
      "--date", filter.study_date, "Of the study: 20260131, 20260101-20260131, 20260101-");
  command.add_option("--accession", filter.accession, "Accession number");
  command.add_option("--study", filter.study_uid, "Study Instance UID");
  command.add_option("--aet", options.aet, "dicom: our own AE title")->capture_default_str();
  auto* user = command.add_option("--user",
                                  options.user,
                                  "DICOMweb: user; the password comes from --password-file or "
                                  "MORGAGNI_PACS_PASSWORD");
  command.add_option(
      "--password-file", arguments.password_file, "A file with that password and nothing else");
  command
      .add_option("--token-file",
                  arguments.token_file,
                  "DICOMweb: bearer token; else from MORGAGNI_PACS_TOKEN")
      ->excludes(user);
  add_tls_options(command, options.tls);
  command.add_option("--timeout-s", arguments.timeout_s, "Without a word from the PACS")
      ->capture_default_str();
}

Result<std::unique_ptr<PacsPeer>> open_peer(PeerArguments arguments) {
  MOR_TRY(const auto address, parse_pacs_address(arguments.address));
  MOR_CHECK(arguments.filter.check());
  auto& options = arguments.options;
  options.timeout = std::chrono::seconds(arguments.timeout_s);
  MOR_TRY(options.password, secret(arguments.password_file, "MORGAGNI_PACS_PASSWORD"));
  if (options.user.empty()) {
    MOR_TRY(options.token, secret(arguments.token_file, "MORGAGNI_PACS_TOKEN"));
  }
  return open_pacs_peer(address, options);
}

std::string to_text(const PacsStudy& study) {
  return fmt::format("{:<8}  {:<12}  {:<24}  {:<8}  {}  {}",
                     terminal_text(study.date),
                     terminal_text(study.patient_id),
                     terminal_text(study.patient_name),
                     terminal_text(study.modalities),
                     terminal_text(study.description),
                     study.uid);
}

std::string to_text(const PacsSeries& series) {
  return fmt::format("{:>3}  {:<4}  {:>5} objects  \"{}\"  {}",
                     terminal_text(series.number),
                     terminal_text(series.modality),
                     series.num_instances == 0 ? "?" : std::to_string(series.num_instances),
                     terminal_text(series.description),
                     series.uid);
}

}  // namespace mor
