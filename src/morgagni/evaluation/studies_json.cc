// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <nlohmann/json.hpp>

#include "morgagni/evaluation/studies.h"

namespace mor {
namespace {

using Json = nlohmann::ordered_json;

Json to_json_value(const StudyMethod& method) {
  return {{"method", to_string(method.method)},
          {"device", method.device},
          {"down_sampling", method.down_sampling}};
}

Json to_json_value(const Summary& summary) {
  return {{"mean", summary.mean},
          {"sd", summary.sd},
          {"median", summary.median},
          {"p95", summary.p95},
          {"max", summary.max}};
}

Json to_json_value(const StudyRun& run) {
  return {{"fre_mm", run.fre_mm},
          {"tagged_tre_mm", run.tagged_tre_mm},
          {"internal_tre_mm", run.internal_tre_mm},
          {"start_tre_mm", run.start_tre_mm},
          {"registration_ms", run.registration_ms},
          {"cpu_ms", run.cpu_ms},
          {"points", run.num_points},
          {"iterations", run.num_iterations}};
}

Json to_json_value(const Study& study) {
  Json columns = Json::array();
  for (const auto& column : study.columns) {
    Json value = to_json_value(column.method);
    if (!column.not_run.empty()) value["not_run"] = column.not_run;
    value["runs"] = Json::array();
    for (const auto& run : column.runs) value["runs"].push_back(to_json_value(run));
    columns.push_back(std::move(value));
  }
  return {{"name", study.name},
          {"camera", study.camera},
          {"markers", study.num_markers},
          {"columns", std::move(columns)}};
}

Json to_json_value(const StudiesOptions& options) {
  return {{"seed", options.seed},
          {"poses", options.num_poses},
          {"many_poses", options.num_many_poses},
          {"down_samplings", options.down_samplings},
          {"opencl", options.runs_opencl},
          {"tag_px", options.tagging.marker_px},
          {"tag_ct_mm", options.tagging.marker_ct_mm},
          {"landmark_mm", options.tagging.landmark_mm},
          {"bias_mm", options.bias_mm},
          {"focal_error_percent", options.focal_error_percent},
          {"success_mm", options.success_mm}};
}

}  // namespace

std::string to_json(const StudiesReport& report) {
  Json studies = Json::array();
  for (const auto* study : {&report.phantom, &report.post_mortem}) {
    studies.push_back(to_json_value(*study));
  }
  for (const auto& study : report.down_sampled) studies.push_back(to_json_value(study));
  for (const auto* study : {&report.many_plain,
                            &report.many_hand,
                            &report.many_parts,
                            &report.many_cluttered,
                            &report.biased}) {
    studies.push_back(to_json_value(*study));
  }
  Json recorded = Json::array();
  for (const auto& row : report.recorded) {
    Json value = to_json_value(row.method);
    value["recording"] = row.recording;
    value["success_rate"] = row.success_rate;
    value["tre_mm"] = to_json_value(row.tre_mm);
    value["tre_success_mm"] = to_json_value(row.tre_success_mm);
    recorded.push_back(std::move(value));
  }
  return Json{{"data", "simulated"},
              {"case", report.case_name},
              {"options", to_json_value(report.options)},
              {"studies", std::move(studies)},
              {"recordings", std::move(recorded)},
              {"notes", report.notes}}
      .dump(1);
}

}  // namespace mor
