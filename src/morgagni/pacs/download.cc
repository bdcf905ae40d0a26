// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/pacs/download.h"

#include <algorithm>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <system_error>

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "morgagni/core/folder_lock.h"
#include "morgagni/core/log.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// Returns early when it is stopped.
void wait(std::chrono::milliseconds time, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any nobody_notifies;
  std::unique_lock lock(mutex);
  nobody_notifies.wait_for(lock, stop, time, [] { return false; });
}

/// Whether another try may help.
bool may_pass(const Error& error) {
  return error.code == ErrorCode::kIo || error.code == ErrorCode::kTimeout;
}

class Download {
 public:
  Download(PacsPeer& peer,
           fs::path pending,
           const DownloadOptions& options,
           const OnDownload& on_progress,
           std::stop_token stop)
      : peer_(peer),
        pending_(std::move(pending)),
        options_(options),
        on_progress_(on_progress),
        stop_(std::move(stop)) {}

  /// Asks what there is to fetch.
  Result<void> list(const std::vector<PacsSeries>& all) {
    for (const auto& series : all) {
      Part part{series, pending_ / series.uid, {}};
      MOR_CHECK(try_again([&]() -> Result<void> {
        MOR_TRY(part.wanted, peer_.find_instances(series, stop_));
        return {};
      }));
      if (part.wanted.empty()) {
        return make_error(ErrorCode::kNotFound,
                          fmt::format("the PACS lists no object of series {}", series.uid));
      }
      std::error_code status;
      fs::create_directories(part.folder, status);
      if (status) {
        return make_error(ErrorCode::kIo,
                          fmt::format("{}: {}", part.folder.string(), status.message()));
      }
      remove_parts(part.folder);
      summary_.progress.num_wanted += static_cast<int>(part.wanted.size());
      summary_.num_found += static_cast<int>(part.wanted.size() - missing_of(part).size());
      parts_.push_back(std::move(part));
    }
    summary_.progress.num_files = summary_.num_found;
    return {};
  }

  Result<DownloadSummary> fetch() {
    report();
    for (const auto& part : parts_) {
      MOR_CHECK(try_again([&] { return fetch_missing(part); }));
    }
    return summary_;
  }

 private:
  struct Part {
    PacsSeries series;
    fs::path folder;
    std::vector<std::string> wanted;
  };

  static void remove_parts(const fs::path& folder) {
    std::error_code status;
    for (const auto& entry : fs::directory_iterator(folder, status))
      if (entry.path().extension() == ".part") fs::remove_all(entry.path(), status);
  }

  static std::vector<std::string> missing_of(const Part& part) {
    std::vector<std::string> missing;
    std::error_code status;
    for (const auto& uid : part.wanted)
      if (!fs::exists(part.folder / (uid + ".dcm"), status)) missing.push_back(uid);
    return missing;
  }

  Result<void> fetch_missing(const Part& part) {
    const auto missing = missing_of(part);
    if (missing.empty()) return {};
    MOR_CHECK(peer_.fetch(
        part.series,
        missing,
        missing.size() == part.wanted.size(),
        part.folder,
        [this](const fs::path& /*file*/, std::uint64_t bytes) {
          ++summary_.progress.num_files;
          summary_.progress.num_bytes += bytes;
          report();
        },
        stop_));
    const auto still = missing_of(part);
    if (still.empty()) return {};
    return make_error(
        ErrorCode::kIo,
        fmt::format("the PACS does not send {} of {} objects of series {}, such as {}",
                    still.size(),
                    part.wanted.size(),
                    part.series.uid,
                    still.front()));
  }

  /// As often as it may help, and without end while there is progress.
  template <class Step>
  Result<void> try_again(const Step& step) {
    auto pause = options_.retry_wait;
    for (int num_failures = 0;;) {
      const int before = summary_.progress.num_files;
      auto outcome = step();
      if (outcome) return outcome;
      if (!may_pass(outcome.error()) || stop_.stop_requested()) return outcome;
      if (summary_.progress.num_files > before) {
        num_failures = 0;
        pause = options_.retry_wait;
      }
      if (++num_failures >= options_.max_failures) return outcome;
      log::warn("{}; trying again in {:.1f} s",
                outcome.error().message,
                static_cast<double>(pause.count()) / 1000.0);
      ++summary_.num_failures;
      wait(pause, stop_);
      constexpr std::chrono::milliseconds kMaxWait{30000};
      pause = std::min(2 * pause, kMaxWait);
    }
  }

  void report() {
    const std::chrono::duration<double> since = Clock::now() - started_;
    summary_.progress.seconds = since.count();
    if (on_progress_) on_progress_(summary_.progress);
  }

  PacsPeer& peer_;
  fs::path pending_;
  DownloadOptions options_;
  const OnDownload& on_progress_;
  std::stop_token stop_;
  const Clock::time_point started_ = Clock::now();
  std::vector<Part> parts_;
  DownloadSummary summary_;
};

/// All that lies on that disk is written out.
void flush(const fs::path& folder) {
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::syncfs(fd);
  ::close(fd);
}

fs::path without_slash(const fs::path& folder) {
  auto absolute = fs::absolute(folder).lexically_normal();
  return absolute.has_filename() ? absolute : absolute.parent_path();
}

/// What an earlier run left must be of the same series: it becomes part of the result.
Result<void> check_pending(const fs::path& pending, const std::vector<PacsSeries>& series) {
  std::error_code status;
  for (const auto& entry : fs::directory_iterator(pending, status)) {
    const auto name = entry.path().filename().string();
    const bool is_wanted = std::any_of(
        series.begin(), series.end(), [&name](const auto& one) { return one.uid == name; });
    if (!is_wanted) {
      return make_error(ErrorCode::kInvalidArgument,
                        fmt::format("{} has what another run fetched, {}: delete it, or give "
                                    "another folder",
                                    pending.string(),
                                    name));
    }
  }
  return {};
}

}  // namespace

fs::path pending_folder(const fs::path& folder) {
  return without_slash(folder).string() + ".pending";
}

Result<DownloadSummary> download_series(PacsPeer& peer,
                                        const std::vector<PacsSeries>& series,
                                        const fs::path& folder,
                                        const DownloadOptions& options,
                                        const OnDownload& on_progress,
                                        std::stop_token stop) {
  const auto target = without_slash(folder);
  std::error_code status;
  if (fs::exists(target, status)) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{} is there already: give a new folder", folder.string()));
  }
  const auto pending = pending_folder(folder);
  MOR_TRY(const auto lock,
          FolderLock::make_and_take(pending,
                                    FolderLock::Kind::kExclusive,
                                    pending.string() + ": another run fetches into it"));
  Download download(peer, pending, options, on_progress, std::move(stop));
  MOR_CHECK(check_pending(pending, series));
  MOR_CHECK(download.list(series));
  MOR_TRY(const auto summary, download.fetch());
  flush(pending);
  if (::renameat2(AT_FDCWD, pending.c_str(), AT_FDCWD, target.c_str(), RENAME_NOREPLACE) != 0) {
    return make_error(
        ErrorCode::kIo,
        fmt::format("{}: cannot be put in its place: {}", target.string(), std::strerror(errno)));
  }
  return summary;
}

}  // namespace mor
