// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <map>
#include <memory>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "morgagni/casefile/prepare.h"
#include "morgagni/core/kept_memory.h"
#include "morgagni/core/log.h"
#include "morgagni/pacs/download.h"

#include "exit.h"
#include "pacs/pacs_commands.h"
#include "pacs/peer_options.h"
#include "stop_signals.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

enum class Way : std::uint8_t { kGet, kMove };
const std::map<std::string, Way> kWays = {{"get", Way::kGet}, {"move", Way::kMove}};

struct Arguments {
  PeerArguments peer;
  std::string series_uid;
  std::string modality = "CT";
  fs::path out;
  fs::path case_folder;
  Way way = Way::kGet;
  DownloadOptions download;
};

/// One line, redrawn; on no terminal only its last state.
class DownloadBar {
 public:
  void show(const DownloadProgress& progress) {
    const auto now = std::chrono::steady_clock::now();
    const bool done = progress.num_files == progress.num_wanted;
    if (!done && (!is_terminal_ || now - last_ < std::chrono::milliseconds(80))) return;
    last_ = now;
    constexpr int kWidth = 24;
    const int filled =
        progress.num_wanted == 0 ? 0 : kWidth * progress.num_files / progress.num_wanted;
    const double megabytes = static_cast<double>(progress.num_bytes) / 1e6;
    fmt::print(stderr,
               "{}{:<28} [{:<{}}] {} of {}  {:.1f} MB  {:.1f} MB/s{}",
               is_terminal_ ? "\r" : "",
               "fetch",
               std::string(static_cast<std::size_t>(filled), '#'),
               kWidth,
               progress.num_files,
               progress.num_wanted,
               megabytes,
               progress.seconds > 0.0 ? megabytes / progress.seconds : 0.0,
               done ? "\n" : "\033[K");
    std::fflush(stderr);
  }

 private:
  const bool is_terminal_ = isatty(STDERR_FILENO) == 1;
  std::chrono::steady_clock::time_point last_;
};

[[noreturn]] void fail(const std::string& sentence) {
  value_or_exit(Result<void>(tl::unexpect, Error{ErrorCode::kInvalidArgument, sentence}));
  std::abort();  // Not reached: the line above throws.
}

/// The one study that is meant.
PacsStudy choose_study(PacsPeer& peer, const PacsFilter& filter, const std::stop_token& stop) {
  const auto found = value_or_exit(peer.find_studies(filter, stop));
  if (found.studies.size() == 1) return found.studies.front();
  if (found.studies.empty()) fail("no study fits: see what there is with `morgagni pacs query`");
  for (const auto& study : found.studies) fmt::print(stderr, "{}\n", to_text(study));
  fail(fmt::format("{}{} studies fit: choose one by --study UID",
                   found.has_more ? "more than " : "",
                   found.studies.size()));
}

/// The series that are wanted of a study; the others are named.
std::vector<PacsSeries> choose_series(PacsPeer& peer,
                                      const Arguments& arguments,
                                      const PacsStudy& study,
                                      const std::stop_token& stop) {
  std::vector<PacsSeries> wanted;
  for (auto& series : value_or_exit(peer.find_series(study.uid, stop))) {
    const bool is_wanted = arguments.series_uid.empty() ? series.modality == arguments.modality
                                                        : series.uid == arguments.series_uid;
    if (!is_wanted) {
      fmt::print(stderr, "left out: {}\n", to_text(series));
      continue;
    }
    wanted.push_back(std::move(series));
  }
  if (!wanted.empty()) return wanted;
  fail(arguments.series_uid.empty()
           ? fmt::format("study {} has no series of {}", study.uid, arguments.modality)
           : fmt::format("study {} has no series {}", study.uid, arguments.series_uid));
}

void prepare(const Arguments& arguments) {
  keep_freed_memory();
  const auto summary = value_or_exit(
      prepare_case(arguments.out, arguments.case_folder, PrepareOptions{}, console_progress()));
  fmt::print(
      "{}: skin of {} vertices, bones of {} triangles; read in {:.1f} s, prepared in {:.1f} s\n",
      arguments.case_folder.string(),
      summary.num_skin_vertices,
      summary.num_bone_triangles,
      summary.reading_seconds,
      summary.seconds);
}

void get(const Arguments& arguments) {
  const StopSignals signals;
  const auto stop = signals.token();
  auto peer_arguments = arguments.peer;
  peer_arguments.options.by_move = arguments.way == Way::kMove;
  const auto peer = value_or_exit(open_peer(peer_arguments));
  const auto study = choose_study(*peer, arguments.peer.filter, stop);
  const auto series = choose_series(*peer, arguments, study, stop);
  if (!arguments.case_folder.empty() && series.size() > 1) {
    for (const auto& one : series) fmt::print(stderr, "{}\n", to_text(one));
    fail("--prepare takes one series: choose it by --series UID");
  }
  DownloadBar bar;
  const auto fetched = download_series(
      *peer,
      series,
      arguments.out,
      arguments.download,
      [&bar](const DownloadProgress& progress) { bar.show(progress); },
      stop);
  if (!fetched) {
    const auto pending = pending_folder(arguments.out);
    std::error_code status;
    const bool has_some = fs::exists(pending, status);
    value_or_exit(Result<void>(
        tl::unexpect,
        Error{
            fetched.error().code,
            fmt::format("{}{}",
                        fetched.error().message,
                        has_some ? fmt::format("; what is there stays in {}, and the same command "
                                               "goes on from there",
                                               pending.string())
                                 : "")}));
  }
  const auto& progress = fetched->progress;
  fmt::print(
      "{}: {} objects of {} series, {:.1f} MB in {:.1f} s{}{}\n",
      arguments.out.string(),
      progress.num_files,
      series.size(),
      static_cast<double>(progress.num_bytes) / 1e6,
      progress.seconds,
      fetched->num_found == 0 ? "" : fmt::format(", {} were there already", fetched->num_found),
      fetched->num_failures == 0 ? ""
                                 : fmt::format(", taken up again {} times", fetched->num_failures));
  if (!arguments.case_folder.empty()) prepare(arguments);
}

}  // namespace

void add_pacs_get_command(CLI::App& pacs) {
  auto arguments = std::make_shared<Arguments>();
  auto* command = pacs.add_subcommand("get", "Fetch the CT series of a study from a PACS");
  auto& options = arguments->peer.options;
  add_peer_options(*command, arguments->peer);
  command->add_option("--out", arguments->out, "New folder; it appears when all is there")
      ->required();
  command->add_option("--series", arguments->series_uid, "Only this Series Instance UID");
  command->add_option("--modality", arguments->modality, "Only series of it")
      ->capture_default_str();
  command->add_option(
      "--prepare", arguments->case_folder, "Make this case of it, as `morgagni prepare` does");
  command
      ->add_option("--by",
                   arguments->way,
                   "dicom: C-GET, or C-MOVE to a receiver of our own, which the PACS must know")
      ->transform(CLI::CheckedTransformer(kWays).description("get or move"))
      ->default_str("get");
  command->add_option("--listen", options.listen_address, "--by move: address of that receiver")
      ->capture_default_str();
  command->add_option("--listen-port", options.listen_port, "--by move: its port")
      ->capture_default_str();
  command
      ->add_option("--tries",
                   arguments->download.max_failures,
                   "So many failures in a row without an object end it")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  add_size_options(*command, options.max_object_bytes, options.min_free_bytes);
  command->footer(
      "Examples:\n"
      "  morgagni pacs get https://pacs.example/dicom-web --patient-id 0815 --out ct/0815\n"
      "  morgagni pacs get dicom://PACS@10.0.0.7:104 --study 1.2.840.1 --out ct/0815 "
      "--prepare cases/0815\n"
      "  morgagni pacs get dicom://PACS@10.0.0.7:104 --accession A17 --out ct/A17 --by move\n"
      "      --aet MORGAGNI --listen 0.0.0.0 --listen-port 11112");
  command->callback([arguments] { get(*arguments); });
}

}  // namespace mor
