// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <condition_variable>
#include <memory>
#include <mutex>
#include <vector>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/casefile/case.h"
#include "morgagni/casefile/prepare.h"
#include "morgagni/core/log.h"
#include "morgagni/pacs/received_journal.h"
#include "morgagni/pacs/storage_receiver.h"
#include "morgagni/pacs/study_gatherer.h"

#include "exit.h"
#include "pacs/pacs_commands.h"
#include "pacs/peer_options.h"
#include "stop_signals.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  fs::path cases;
  ReceiverOptions receiver;
  int quiet_s = 30;
  int idle_timeout_s = 60;
  bool forget = false;
};

/// What arrives becomes cases, one after the other, on the thread that calls run().
class CaseMaker {
 public:
  explicit CaseMaker(const Arguments& arguments)
      : arguments_(arguments),
        journal_(arguments.receiver.folder),
        gatherer_(std::chrono::seconds(arguments.quiet_s)) {
    for (const auto& object : journal_.read()) add(object);
  }

  void add(const ReceivedObject& object) {
    const std::lock_guard lock(mutex_);
    const bool is_new = gatherer_.add(object, StudyGatherer::Clock::now());
    if (!is_new) return;
    if (const auto noted = journal_.add(object); !noted) log::warn("{}", noted.error().message);
    changed_.notify_all();
  }

  /// Until a signal.
  void run(StopSignals& signals) {
    const auto stop = signals.token();
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
      const auto due = gatherer_.next_due();
      if (!due) {
        changed_.wait(lock, stop, [this] { return gatherer_.next_due().has_value(); });
        continue;
      }
      changed_.wait_until(lock, stop, *due, [] { return false; });
      const auto quiet = gatherer_.take_quiet(StudyGatherer::Clock::now());
      lock.unlock();
      for (const auto& series : quiet) {
        if (stop.stop_requested()) return;
        const bool done = make_case(series, signals);
        lock.lock();
        // Unless more of it came meanwhile, or the next run has to try again.
        if (done && !gatherer_.has(series.last.study_uid, series.last.series_uid))
          journal_.remove(series.last.series_uid);
        lock.unlock();
      }
      lock.lock();
    }
  }

 private:
  /// @return Whether nothing is left to do for it.
  bool make_case(const GatheredSeries& series, StopSignals& signals) const {
    const auto& words = series.last;
    const auto name = fmt::format("series {} of patient {} (\"{}\", {})",
                                  terminal_text(words.series_number),
                                  terminal_text(words.patient_id),
                                  terminal_text(words.series_description),
                                  words.series_uid);
    if (!series.is_ct()) {
      log::info("left out, no CT: {}: {} objects of {}",
                name,
                series.num_objects,
                terminal_text(words.modality));
      return true;
    }
    const auto folder = arguments_.cases / series.case_name();
    std::error_code status;
    if (arguments_.forget && fs::exists(folder / kCaseFile, status)) {
      log::error(
          "{}: came after its case {} was made and, by --forget, the first objects deleted: "
          "the case stays as it is, and these {} objects in {}",
          name,
          folder.string(),
          series.num_objects,
          series.folder.string());
      return false;
    }
    log::info("{} has been quiet for {} s: {} new objects, preparing",
              name,
              arguments_.quiet_s,
              series.num_objects);
    const auto files = files_in(series.folder);
    const auto silent = [](std::string_view /*stage*/, double /*fraction*/) {};
    // Stopped meanwhile, the series stays in the journal, and the next run makes the case.
    const auto summary = signals.at_once(
        [&] { return prepare_case(series.folder, folder, PrepareOptions{}, silent); });
    if (!summary) {
      log::error("{}: no case: {}; the objects stay in {}",
                 name,
                 summary.error().message,
                 series.folder.string());
      return false;
    }
    log::info("{}: case {}: skin of {} vertices, in {:.1f} s",
              name,
              folder.string(),
              summary->num_skin_vertices,
              summary->reading_seconds + summary->seconds);
    if (arguments_.forget) forget(series.folder, files);
    return true;
  }

  static std::vector<fs::path> files_in(const fs::path& folder) {
    std::vector<fs::path> files;
    std::error_code status;
    for (const auto& entry : fs::directory_iterator(folder, status)) files.push_back(entry.path());
    return files;
  }

  /// What came since stays.
  static void forget(const fs::path& folder, const std::vector<fs::path>& files) {
    std::error_code status;
    for (const auto& file : files) fs::remove(file, status);
    fs::remove(folder, status);
    fs::remove(folder.parent_path(), status);
  }

  const Arguments& arguments_;
  ReceivedJournal journal_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  StudyGatherer gatherer_;
};

void serve(Arguments& arguments) {
  auto& options = arguments.receiver;
  options.idle_timeout = std::chrono::seconds(arguments.idle_timeout_s);
  options.folder = arguments.cases / "received";
  const auto& [ca, certificate, key] = options.tls;
  options.use_tls = !ca.empty() || !certificate.empty() || !key.empty();
  StopSignals signals;
  CaseMaker maker(arguments);
  const auto receiver = value_or_exit(StorageReceiver::start(
      options, [&maker](const ReceivedObject& object) { maker.add(object); }));
  fmt::print("{} receives {} at {}:{}, cases go to {}  (stop with Ctrl-C)\n",
             options.aet,
             options.use_tls ? "DICOM over TLS" : "DICOM",
             options.listen_address,
             receiver->port(),
             arguments.cases.string());
  std::fflush(stdout);
  if (!is_loopback(options.listen_address) && options.accepted_callers.empty())
    log::warn("anybody on the network may send: --accept AET and --ca say who may");
  maker.run(signals);
  log::info("stopping");
}

}  // namespace

void add_pacs_serve_command(CLI::App& pacs) {
  auto arguments = std::make_shared<Arguments>();
  auto* command = pacs.add_subcommand(
      "serve", "Receive CTs that others send (C-STORE), and make cases of them");
  auto& options = arguments->receiver;
  command
      ->add_option("--cases", arguments->cases, "Folder of the cases; DICOM goes to its received")
      ->required();
  command
      ->add_option("--quiet-s",
                   arguments->quiet_s,
                   "A study of which nothing came for so long is taken for complete")
      ->capture_default_str()
      ->check(CLI::Range(1, 86400));
  command->add_option("--aet", options.aet, "Our AE title")->capture_default_str();
  command->add_flag("--any-aet", options.any_called_aet, "Whatever AE title they call us");
  command->add_option("--accept", options.accepted_callers, "AE title that may send; several times")
      ->expected(1)
      ->take_all();
  command->add_option("--listen", options.listen_address, "Address to listen on; 0.0.0.0: all")
      ->capture_default_str();
  command->add_option("--port", options.port, "0 takes a free one")->capture_default_str();
  add_tls_options(*command, options.tls);
  command->add_option("--max-associations", options.max_associations, "Connections at once")
      ->capture_default_str();
  command->add_option("--timeout-s", arguments->idle_timeout_s, "Connections that say nothing end")
      ->capture_default_str()
      ->check(CLI::Range(1, 3600));
  add_size_options(*command, options.max_object_bytes, options.min_free_bytes);
  command->add_flag("--forget",
                    arguments->forget,
                    "Delete the DICOM of a series when its case is made; slices that come later "
                    "are then no part of it");
  command->footer(
      "Examples:\n"
      "  morgagni pacs serve --cases cases\n"
      "  morgagni pacs serve --cases cases --listen 0.0.0.0 --accept PACS --accept CT1\n"
      "  morgagni pacs serve --cases cases --listen 0.0.0.0 --port 2762 --certificate my.pem\n"
      "      --key my.key --ca hospital.pem");
  command->callback([arguments] { serve(*arguments); });
}

}  // namespace mor
