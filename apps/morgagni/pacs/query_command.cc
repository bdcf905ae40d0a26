// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <memory>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "exit.h"
#include "pacs/pacs_commands.h"
#include "pacs/peer_options.h"
#include "stop_signals.h"

namespace mor {
namespace {

struct Arguments {
  PeerArguments peer;
  bool echo = false;
  bool json = false;
};

/// The series of few studies are shown; of many, the studies only.
constexpr std::size_t kMaxShownWithSeries = 20;

using Json = nlohmann::ordered_json;

Json json_of(const PacsSeries& series) {
  return {{"uid", series.uid},
          {"modality", series.modality},
          {"number", series.number},
          {"description", series.description},
          {"objects", series.num_instances}};
}

Json json_of(const PacsStudy& study, const std::vector<PacsSeries>& series) {
  auto list = Json::array();
  for (const auto& one : series) list.push_back(json_of(one));
  return {{"uid", study.uid},
          {"patient_id", study.patient_id},
          {"patient_name", study.patient_name},
          {"date", study.date},
          {"description", study.description},
          {"accession", study.accession},
          {"modalities", study.modalities},
          {"series", list}};
}

void print_json(const Json& json) {
  fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
}

void query(const Arguments& arguments) {
  const StopSignals signals;
  const auto stop = signals.token();
  const auto peer = value_or_exit(open_peer(arguments.peer));
  if (arguments.echo) {
    const auto start = std::chrono::steady_clock::now();
    value_or_exit(peer->echo(stop));
    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
    fmt::print("{} answers, {:.0f} ms\n", arguments.peer.address, time.count());
    return;
  }
  const auto found = value_or_exit(peer->find_studies(arguments.peer.filter, stop));
  const bool with_series = arguments.json || found.studies.size() <= kMaxShownWithSeries;
  auto list = Json::array();
  for (const auto& study : found.studies) {
    std::vector<PacsSeries> series;
    if (with_series) series = value_or_exit(peer->find_series(study.uid, stop));
    if (arguments.json) {
      list.push_back(json_of(study, series));
      continue;
    }
    fmt::print("{}\n", to_text(study));
    for (const auto& one : series) fmt::print("    {}\n", to_text(one));
  }
  if (arguments.json) return print_json({{"studies", list}, {"more", found.has_more}});
  if (found.studies.empty()) fmt::print("no study fits\n");
  if (found.has_more)
    fmt::print("... and more than these {}: ask more narrowly\n", found.studies.size());
}

}  // namespace

void add_pacs_query_command(CLI::App& pacs) {
  auto arguments = std::make_shared<Arguments>();
  auto* command = pacs.add_subcommand("query", "List the studies and series of a PACS");
  add_peer_options(*command, arguments->peer);
  command
      ->add_option("--modality",
                   arguments->peer.filter.modality,
                   "Studies with a series of it, as CT; give \"\" for all")
      ->default_str("CT");
  arguments->peer.filter.modality = "CT";
  command->add_flag("--echo", arguments->echo, "Only see whether it answers and lets us in");
  command->add_flag("--json", arguments->json, "As JSON");
  command->footer(
      "Examples:\n"
      "  morgagni pacs query https://pacs.example/dicom-web --patient-name 'Doe^J*'\n"
      "  morgagni pacs query dicom://PACS@10.0.0.7:104 --date 20260101-20260131\n"
      "  morgagni pacs query dicoms://PACS@pacs.example --ca hospital.pem --echo");
  command->callback([arguments] { query(*arguments); });
}

}  // namespace mor
