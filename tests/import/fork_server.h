// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

/// What import_launcher, the fork server and the tests say to each other: one packet with the job
/// and the two files of the import protocol beside it, one ImportEnd back.
namespace mor::fork_server {

inline constexpr const char* kSocketVariable = "MOR_IMPORT_FORK_SERVER";
inline constexpr std::size_t kMaxPacketBytes = 8192;

/// How one import process ended.
struct ImportEnd {
  std::int32_t status = 0;       ///< As waitpid() gives it.
  std::int64_t max_rss_kib = 0;  ///< The libraries' pages, shared with the server, among it.
  std::int64_t cpu_us = 0;
};

/// The most of all so far: the answer to a packet without files.
struct ImportPeaks {
  std::int64_t num_imports = 0;
  std::int64_t num_killed = 0;  ///< By a signal.
  std::int64_t max_rss_kib = 0;
  std::int64_t max_cpu_us = 0;
  std::int64_t sum_cpu_us = 0;
};

}  // namespace mor::fork_server
