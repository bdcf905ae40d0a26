// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <vector>

#include "morgagni/core/result.h"
#include "morgagni/pacs/pacs_peer.h"

namespace mor {

struct DownloadOptions {
  int max_failures = 5;                        ///< In a row without a single object. >= 1.
  std::chrono::milliseconds retry_wait{1000};  ///< Before the second try; doubles up to 30 s.
};

/// How far a download is.
struct DownloadProgress {
  int num_files = 0;  ///< Whole and on disk.
  int num_wanted = 0;
  std::uint64_t num_bytes = 0;  ///< Fetched by this run.
  double seconds = 0.0;         ///< Since this run began.
};
using OnDownload = std::function<void(const DownloadProgress&)>;

struct DownloadSummary {
  DownloadProgress progress;
  int num_found = 0;     ///< Files that an earlier run had fetched.
  int num_failures = 0;  ///< Connections that broke and were taken up again.
};

/// FOLDER.pending, where what is fetched for `folder` is collected; absolute.
[[nodiscard]] std::filesystem::path pending_folder(const std::filesystem::path& folder);

/// Brings whole series of a PACS into a folder: FOLDER/SERIES_UID/SOP_UID.dcm.
///
/// They are collected in FOLDER.pending, which gets its name when all is there. A broken connection
/// is taken up again, and so is a run that ended early: what is whole is not fetched again.
///
/// @param folder  Must not exist yet.
/// @errors kInvalidArgument: `folder` exists, or FOLDER.pending has other series, or another run;
/// the peer's, with what
///         is missing: FOLDER.pending stays, for the next run; kCancelled: the same; kIo.
[[nodiscard]] Result<DownloadSummary> download_series(PacsPeer& peer,
                                                      const std::vector<PacsSeries>& series,
                                                      const std::filesystem::path& folder,
                                                      const DownloadOptions& options,
                                                      const OnDownload& on_progress,
                                                      std::stop_token stop);

}  // namespace mor
