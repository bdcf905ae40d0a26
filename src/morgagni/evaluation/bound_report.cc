// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <functional>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/statistics.h"
#include "morgagni/evaluation/bound_calibration.h"

namespace mor {
namespace {

using Keeps = std::function<bool(const BoundSample&, const BoundTarget&)>;

BoundCoverage line(const BoundRuns& runs,
                   const BoundCalibration& calibration,
                   double told_bias_mm,
                   std::string name,
                   const Keeps& keeps) {
  BoundCoverage result;
  result.name = std::move(name);
  std::vector<double> errors_mm;
  std::vector<double> bounds_mm;
  int held = 0;
  for (const auto& sample : runs.samples) {
    const auto pose = pose_covariance(
        sample.information, with_sensor_bias(calibration, told_bias_mm, sample.distance_mm));
    if (!pose) continue;
    const std::size_t before = errors_mm.size();
    for (const auto& target : sample.targets) {
      if (!keeps(sample, target)) continue;
      errors_mm.push_back(target.error_mm);
      bounds_mm.push_back(error_bound_mm(*pose, target.ct_mm));
      held += errors_mm.back() <= bounds_mm.back() ? 1 : 0;
    }
    result.num_frames += errors_mm.size() > before ? 1 : 0;
  }
  result.num_targets = static_cast<int>(errors_mm.size());
  if (!errors_mm.empty()) result.coverage = static_cast<double>(held) / result.num_targets;
  result.median_error_mm = quantile(errors_mm, 0.5);
  result.p95_error_mm = quantile(errors_mm, 0.95);
  result.median_bound_mm = quantile(bounds_mm, 0.5);
  return result;
}

std::string_view to_string(BoundTarget::Kind kind) {
  switch (kind) {
    case BoundTarget::Kind::kSeenSkin:
      return "middle of the skin seen";
    case BoundTarget::Kind::kCenter:
      return "body's centre";
    case BoundTarget::Kind::kAnywhere:
      break;
  }
  return "anywhere in the body";
}

}  // namespace

std::vector<BoundCoverage> bound_coverage(const BoundRuns& runs,
                                          const BoundCalibration& calibration) {
  const auto is_good = [&](const BoundSample& sample) {
    return sample.state == TrackingState::kTracking;
  };
  const auto counts = [&](const BoundSample& sample) {
    return is_good(sample) && runs.groups[sample.group].bias_mm == 0.0;
  };
  std::vector<BoundCoverage> lines;
  const auto add = [&](std::string name, const Keeps& keeps) {
    auto made = line(runs, calibration, 0.0, std::move(name), keeps);
    if (made.num_targets > 0) lines.push_back(std::move(made));
  };
  add("all without bias", [&](const auto& sample, const auto&) { return counts(sample); });
  for (std::size_t i = 0; i < runs.groups.size(); ++i) {
    const auto& group = runs.groups[i];
    const Keeps in_group = [&](const auto& sample, const auto&) {
      return sample.group == i && is_good(sample);
    };
    add(group.name, in_group);
    if (group.bias_mm == 0.0) continue;
    auto told =
        line(runs, calibration, group.bias_mm, group.name + ", told to the bound", in_group);
    if (told.num_targets > 0) lines.push_back(std::move(told));
  }
  constexpr std::array<std::pair<double, double>, 3> kBands = {
      {{0.0, 650.0}, {650.0, 850.0}, {850.0, 1e9}}};
  for (const auto& band : kBands) {
    const auto [least, most] = band;
    add(most < 1e9 ? fmt::format("distance {:.0f} to {:.0f} mm", least, most)
                   : fmt::format("distance above {:.0f} mm", least),
        [&, least = least, most = most](const auto& sample, const auto&) {
          return counts(sample) && sample.distance_mm >= least && sample.distance_mm < most;
        });
  }
  for (const auto kind :
       {BoundTarget::Kind::kSeenSkin, BoundTarget::Kind::kCenter, BoundTarget::Kind::kAnywhere}) {
    add(std::string(to_string(kind)), [&](const auto& sample, const auto& target) {
      return counts(sample) && target.kind == kind;
    });
  }
  add("uncertain frames", [&](const auto& sample, const auto&) {
    return !is_good(sample) && runs.groups[sample.group].bias_mm == 0.0;
  });
  return lines;
}

std::string to_markdown(const std::vector<BoundCoverage>& lines) {
  std::string text =
      "| cases | frames | points | within the bound | error median / p95, mm | bound median, mm |\n"
      "|---|---|---|---|---|---|\n";
  for (const auto& line : lines) {
    text += fmt::format("| {} | {} | {} | {:.1f} % | {:.2f} / {:.2f} | {:.2f} |\n",
                        line.name,
                        line.num_frames,
                        line.num_targets,
                        100.0 * line.coverage,
                        line.median_error_mm,
                        line.p95_error_mm,
                        line.median_bound_mm);
  }
  return text;
}

std::string to_json(const std::vector<BoundCoverage>& lines,
                    const BoundRuns& runs,
                    const BoundStudyOptions& options,
                    const BoundCalibration& calibration) {
  nlohmann::ordered_json json;
  json["simulated"] = true;
  json["seeds"] = {options.first_seed,
                   options.first_seed + static_cast<std::uint64_t>(options.num_seeds) - 1};
  json["frames_per_seed"] = options.num_frames;
  json["calibration"] = {{"correlated_readings", calibration.correlated_readings},
                         {"clutter_growth", calibration.clutter_growth},
                         {"systematic_mm", calibration.systematic_mm},
                         {"floor_mm", calibration.floor_mm}};
  for (std::size_t i = 0; i < runs.groups.size(); ++i) {
    json["groups"].push_back({{"name", runs.groups[i].name},
                              {"camera", runs.groups[i].camera},
                              {"frames", runs.num_frames[i]},
                              {"not_found", runs.num_not_found[i]}});
  }
  for (const auto& line : lines) {
    json["coverage"].push_back({{"name", line.name},
                                {"frames", line.num_frames},
                                {"points", line.num_targets},
                                {"coverage", line.coverage},
                                {"median_error_mm", line.median_error_mm},
                                {"p95_error_mm", line.p95_error_mm},
                                {"median_bound_mm", line.median_bound_mm}});
  }
  return json.dump(1);
}

std::string to_csv(const BoundRuns& runs, const BoundCalibration& calibration) {
  std::string text = "group,seed,frame,distance_mm,state,target,bound_mm,error_mm\n";
  for (const auto& sample : runs.samples) {
    const auto pose = pose_covariance(sample.information, calibration);
    if (!pose) continue;
    for (const auto& target : sample.targets) {
      text += fmt::format("\"{}\",{},{},{:.0f},{},\"{}\",{:.4f},{:.4f}\n",
                          runs.groups[sample.group].name,
                          sample.seed,
                          sample.frame_id,
                          sample.distance_mm,
                          mor::to_string(sample.state),
                          to_string(target.kind),
                          error_bound_mm(*pose, target.ct_mm),
                          target.error_mm);
    }
  }
  return text;
}

}  // namespace mor
