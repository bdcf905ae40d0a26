// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "morgagni/core/result.h"
#include "morgagni/pacs/pacs_address.h"

namespace mor {

/// PEM files, without passwords; empty: none.
struct PacsTls {
  std::filesystem::path ca;           ///< Whom to trust. DICOMweb without: the system's.
  std::filesystem::path certificate;  ///< Our own, where the peer wants one.
  std::filesystem::path key;
};

struct PacsOptions {
  std::string aet = "MORGAGNI";  ///< Ours. DIMSE only.
  PacsTls tls = {};
  std::string user = {};  ///< DICOMweb only, as the two below.
  std::string password = {};
  std::string token = {};            ///< Sent as a bearer token.
  std::chrono::seconds timeout{30};  ///< Without a word from the peer. 1 s .. 1 h.
  /// DIMSE: by C-MOVE to a receiver of our own rather than by C-GET.
  bool by_move = false;
  std::string listen_address = "127.0.0.1";  ///< Of that receiver.
  std::uint16_t listen_port = 11112;
  std::uint64_t max_object_bytes = 2000000000;
  std::uint64_t min_free_bytes = 1000000000;  ///< Of the disk that is written to.

  [[nodiscard]] Result<void> check() const;
};

/// What is looked for; empty members match all. Names take * and ?.
struct PacsFilter {
  std::string patient_name;
  std::string patient_id;
  std::string study_date;  ///< 20260131, 20260101-20260131, 20260101-.
  std::string modality;    ///< Of a series in the study.
  std::string accession;
  std::string study_uid;

  [[nodiscard]] Result<void> check() const;
};

/// All text is UTF-8 as the peer gave it: clean it before it goes to a terminal (terminal_text()).
struct PacsStudy {
  std::string uid;
  std::string patient_id;
  std::string patient_name;
  std::string date;
  std::string description;
  std::string accession;
  std::string modalities;
};

struct PacsSeries {
  std::string study_uid;
  std::string uid;
  std::string modality;
  std::string number;
  std::string description;
  int num_instances = 0;  ///< 0: the peer does not say.
};

struct PacsStudies {
  std::vector<PacsStudy> studies;
  bool has_more = false;  ///< Than kMaxStudies.
};

/// A file that came whole, and its size.
using OnObject = std::function<void(const std::filesystem::path& file, std::uint64_t bytes)>;

inline constexpr int kMaxStudies = 200;
inline constexpr int kMaxSeries = 1000;
inline constexpr int kMaxInstances = 20000;

/// A PACS, however it is spoken to. It may be hostile: what it says is bounded, checked, and never
/// takes this process down; the objects it hands out are written as they come, not parsed.
/// Each call ends soon after `stop` with kCancelled. One thread at a time.
class PacsPeer {
 public:
  virtual ~PacsPeer() = default;

  /// Whether it is there and lets us in. @errors As all: kIo, kTimeout (it may help to try again);
  /// kInvalidArgument (it refuses us), kUnsupported, kNotFound.
  [[nodiscard]] virtual Result<void> echo(std::stop_token stop) = 0;

  [[nodiscard]] virtual Result<PacsStudies> find_studies(const PacsFilter& filter,
                                                         std::stop_token stop) = 0;
  [[nodiscard]] virtual Result<std::vector<PacsSeries>> find_series(const std::string& study_uid,
                                                                    std::stop_token stop) = 0;
  /// SOP Instance UIDs, proper ones only.
  [[nodiscard]] virtual Result<std::vector<std::string>> find_instances(const PacsSeries& series,
                                                                        std::stop_token stop) = 0;

  /// Writes `wanted` into `folder` as UID.dcm; each file is there whole or not at all. Returns when
  /// the peer has sent all that it sends, which need not be all.
  /// @param all  `wanted` is the whole series, which may be asked for in one piece.
  [[nodiscard]] virtual Result<void> fetch(const PacsSeries& series,
                                           const std::vector<std::string>& wanted,
                                           bool all,
                                           const std::filesystem::path& folder,
                                           const OnObject& on_object,
                                           std::stop_token stop) = 0;
};

/// Does not connect yet. @errors kInvalidArgument: options; kNotFound: morgagni-dimse.
[[nodiscard]] Result<std::unique_ptr<PacsPeer>> open_pacs_peer(const PacsAddress& address,
                                                               const PacsOptions& options);

/// A DICOM UID by its alphabet and length, which make it a harmless name of a file.
[[nodiscard]] bool is_dicom_uid(std::string_view text);

/// A stranger's text for a terminal or a log: control characters become blanks, long text is cut.
[[nodiscard]] std::string terminal_text(std::string_view text);

}  // namespace mor
