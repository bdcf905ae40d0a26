// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/pacs/internal/dimse_peer.h"

#include <algorithm>
#include <mutex>
#include <set>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/log.h"
#include "morgagni/pacs/dimse_protocol.h"
#include "morgagni/pacs/internal/dimse_process.h"
#include "morgagni/pacs/internal/dimse_task.h"
#include "morgagni/pacs/storage_receiver.h"

namespace mor::internal {
namespace {

namespace fs = std::filesystem;

/// A list of UIDs longer than this does not fit into one element of a query.
constexpr std::size_t kMaxUidsAtOnce = 500;

TagValues with_empty(TagValues keys, std::initializer_list<const char*> asked) {
  for (const char* name : asked) keys.emplace(name, "");
  return keys;
}

class DimsePeer : public PacsPeer {
 public:
  DimsePeer(PacsAddress address, PacsOptions options, fs::path program)
      : address_(std::move(address)),
        options_(std::move(options)),
        program_(std::move(program)),
        name_(fmt::format("{}:{}", address_.host, address_.port)) {}

  Result<void> echo(std::stop_token stop) override {
    MOR_CHECK(run(task(dimse::kEcho), {}, stop));
    return {};
  }

  Result<PacsStudies> find_studies(const PacsFilter& filter, std::stop_token stop) override {
    MOR_CHECK(filter.check());
    const auto keys = with_empty(keys_of(filter),
                                 {tag::kStudyUid,
                                  tag::kPatientId,
                                  tag::kPatientName,
                                  tag::kStudyDate,
                                  tag::kStudyDescription,
                                  tag::kAccession,
                                  tag::kModalitiesInStudy});
    MOR_TRY(const auto found, find("STUDY", keys, kMaxStudies + 1, stop));
    PacsStudies result;
    for (const auto& values : found) {
      auto study = study_of(values);
      if (!is_dicom_uid(study.uid)) continue;
      result.has_more = result.studies.size() == kMaxStudies;
      if (!result.has_more) result.studies.push_back(std::move(study));
    }
    return result;
  }

  Result<std::vector<PacsSeries>> find_series(const std::string& study_uid,
                                              std::stop_token stop) override {
    const auto keys = with_empty({{tag::kStudyUid, study_uid}},
                                 {tag::kSeriesUid,
                                  tag::kModality,
                                  tag::kSeriesNumber,
                                  tag::kSeriesDescription,
                                  tag::kNumSeriesInstances});
    MOR_TRY(const auto found, find("SERIES", keys, kMaxSeries, stop));
    std::vector<PacsSeries> all;
    for (const auto& values : found) {
      auto series = series_of(values, study_uid);
      if (is_dicom_uid(series.uid)) all.push_back(std::move(series));
    }
    return all;
  }

  Result<std::vector<std::string>> find_instances(const PacsSeries& series,
                                                  std::stop_token stop) override {
    const auto keys =
        with_empty({{tag::kStudyUid, series.study_uid}, {tag::kSeriesUid, series.uid}},
                   {tag::kSopInstanceUid});
    MOR_TRY(const auto found, find("IMAGE", keys, kMaxInstances, stop));
    std::set<std::string> all;
    for (const auto& values : found) {
      const auto uid = value_of(values, tag::kSopInstanceUid);
      if (is_dicom_uid(uid)) all.insert(uid);
    }
    return std::vector<std::string>(all.begin(), all.end());
  }

  Result<void> fetch(const PacsSeries& series,
                     const std::vector<std::string>& wanted,
                     bool all,
                     const fs::path& folder,
                     const OnObject& on_object,
                     std::stop_token stop) override {
    if (options_.by_move && is_loopback(options_.listen_address) && !is_loopback(address_.host)) {
      return make_error(
          ErrorCode::kInvalidArgument,
          fmt::format("{} cannot send to {}: --listen takes an address of this computer that it "
                      "reaches",
                      name_,
                      options_.listen_address));
    }
    const auto step = all ? wanted.size() : kMaxUidsAtOnce;
    for (std::size_t i = 0; i < wanted.size(); i += step) {
      const std::vector<std::string> some(
          wanted.begin() + static_cast<std::ptrdiff_t>(i),
          wanted.begin() + static_cast<std::ptrdiff_t>(std::min(i + step, wanted.size())));
      auto job = retrieve_task(series, all ? std::vector<std::string>() : some);
      MOR_CHECK(options_.by_move ? fetch_by_move(job, series, some, folder, on_object, stop)
                                 : fetch_by_get(job, some, folder, on_object, stop));
    }
    return {};
  }

 private:
  [[nodiscard]] nlohmann::json task(const char* name) const {
    auto task = dimse_task(name, options_);
    task["host"] = address_.host;
    task["port"] = address_.port;
    task["called_aet"] = address_.aet;
    if (address_.tls) task["tls"] = dimse_tls(options_.tls);
    return task;
  }

  Result<int> run(const nlohmann::json& task, const DimseEvents& events, std::stop_token stop) {
    MOR_TRY(auto text, dimse_text(task));
    return run_dimse_process(program_, {.task = std::move(text), .peer = name_}, events, stop);
  }

  Result<std::vector<TagValues>> find(const char* level,
                                      const TagValues& keys,
                                      int max_matches,
                                      std::stop_token stop) {
    auto job = task(dimse::kFind);
    job["level"] = level;
    job["keys"] = keys;
    job["max_matches"] = max_matches;
    std::vector<TagValues> found;
    const DimseEvents events{.match = [&](TagValues values) {
      if (found.size() < static_cast<std::size_t>(max_matches)) found.push_back(std::move(values));
    }};
    MOR_CHECK(run(job, events, stop));
    return found;
  }

  /// @param uids  Empty: all of the series.
  nlohmann::json retrieve_task(const PacsSeries& series, const std::vector<std::string>& uids) {
    auto job = task(options_.by_move ? dimse::kMove : dimse::kGet);
    job["level"] = uids.empty() ? "SERIES" : "IMAGE";
    job["keys"] = TagValues{{tag::kStudyUid, series.study_uid}, {tag::kSeriesUid, series.uid}};
    if (!uids.empty()) {
      std::string list;
      for (const auto& uid : uids) list += (list.empty() ? "" : "\\") + uid;
      job["keys"][tag::kSopInstanceUid] = list;
    }
    return job;
  }

  Result<void> fetch_by_get(nlohmann::json& job,
                            const std::vector<std::string>& wanted,
                            const fs::path& folder,
                            const OnObject& on_object,
                            std::stop_token stop) {
    job["folder"] = folder.string();
    std::set<std::string> missing(wanted.begin(), wanted.end());
    auto kept = file_names(folder);  // Of an earlier try, or another part of the list.
    std::error_code status;
    const DimseEvents events{
        .stored =
            [&](const fs::path& /*file*/, const TagValues& tags) {
              const auto uid = value_of(tags, tag::kSopInstanceUid);
              if (!is_dicom_uid(uid)) return;
              const auto file = folder / (uid + ".dcm");
              if (missing.erase(uid) != 0) {
                kept.insert(file.filename());
                if (on_object) on_object(file, fs::file_size(file, status));
              } else if (!kept.contains(file.filename())) {
                log::warn("{} sends {}, which was not asked for", name_, uid);
                fs::remove(file, status);
              }
            },
        .refused = [&](const std::string& why) { log::warn("{}: {}", name_, why); }};
    auto outcome = run(job, events, stop);
    remove_parts(folder);
    if (!outcome) return tl::unexpected<Error>(std::move(outcome).error());
    return {};
  }

  static std::set<fs::path> file_names(const fs::path& folder) {
    std::set<fs::path> names;
    std::error_code status;
    for (const auto& entry : fs::directory_iterator(folder, status))
      names.insert(entry.path().filename());
    return names;
  }

  /// What a killed child left.
  static void remove_parts(const fs::path& folder) {
    std::error_code status;
    for (const auto& entry : fs::directory_iterator(folder, status))
      if (entry.path().extension() == ".part") fs::remove_all(entry.path(), status);
  }

  Result<void> fetch_by_move(nlohmann::json& job,
                             const PacsSeries& series,
                             const std::vector<std::string>& wanted,
                             const fs::path& folder,
                             const OnObject& on_object,
                             std::stop_token stop) {
    const auto inbox = folder / "move.part";
    std::mutex mutex;
    std::set<std::string> missing(wanted.begin(), wanted.end());
    std::error_code status;
    ReceiverOptions options{.aet = options_.aet,
                            .listen_address = options_.listen_address,
                            .port = options_.listen_port,
                            .use_tls = address_.tls,
                            .tls = options_.tls,
                            .idle_timeout = options_.timeout,
                            .max_object_bytes = options_.max_object_bytes,
                            .min_free_bytes = options_.min_free_bytes,
                            .folder = inbox};
    MOR_TRY(const auto receiver, StorageReceiver::start(options, [&](const ReceivedObject& object) {
              const std::lock_guard lock(mutex);
              if (object.series_uid != series.uid || missing.erase(object.uid) == 0) {
                log::warn("{} was sent here, which was not asked for", object.uid);
                return;
              }
              const auto file = folder / (object.uid + ".dcm");
              fs::rename(object.file, file, status);
              if (on_object) on_object(file, fs::file_size(file, status));
            }));
    auto outcome = run(job, {}, stop);
    receiver->finish(std::chrono::seconds(5));
    fs::remove_all(inbox, status);
    if (!outcome) return tl::unexpected<Error>(std::move(outcome).error());
    return {};
  }

  PacsAddress address_;
  PacsOptions options_;
  fs::path program_;
  std::string name_;
};

}  // namespace

Result<std::unique_ptr<PacsPeer>> open_dimse_peer(const PacsAddress& address,
                                                  const PacsOptions& options) {
  if (address.tls && options.tls.ca.empty()) {
    return make_error(ErrorCode::kInvalidArgument,
                      "dicoms:// needs --ca: the certificate that vouches for the PACS");
  }
  MOR_TRY(auto program, find_dimse_program());
  return std::make_unique<DimsePeer>(address, options, std::move(program));
}

}  // namespace mor::internal
