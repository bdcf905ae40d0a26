// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/studies_markdown.h"

#include <array>
#include <span>
#include <utility>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "morgagni/evaluation/internal/paper_figures.h"
#include "morgagni/evaluation/study_plots.h"

namespace mor {
namespace {

Summary summary_of(const StudyColumn& column, double StudyRun::*value) {
  std::vector<double> values;
  for (const auto& run : column.runs) values.push_back(run.*value);
  return summarize(values);
}

double median_points(const StudyColumn& column) {
  std::vector<double> values;
  for (const auto& run : column.runs) values.push_back(run.num_points);
  return summarize(values).median;
}

double success_rate(const StudyColumn& column, double success_mm) {
  double count = 0.0;
  for (const auto& run : column.runs) count += run.internal_tre_mm < success_mm ? 1.0 : 0.0;
  return count / static_cast<double>(column.runs.size());
}

std::string mean_and_sd(const Summary& summary, int digits = 1) {
  return fmt::format("{:.{}f} ± {:.{}f}", summary.mean, digits, summary.sd, digits);
}

std::string label_of(const StudyMethod& method) {
  return fmt::format("{}, {}", to_string(method.method), method.device);
}

/// What the paper printed, as a row of summary_table().
std::string printed_row(const char* label, const char* tre_mm, const char* ms) {
  return fmt::format("| *paper: {}* | 1 | *{}* | | | | | | *{}* | | |\n", label, tre_mm, ms);
}

constexpr const char* kSummaryHead =
    "| method, device | down-sampling | TRE as tagged, mm | TRE inside, mm | median | p95 | max | "
    "below {:g} mm | wall, ms | CPU, ms (median) | points |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|\n";

std::string summary_row(const StudyColumn& column, double success_mm) {
  const auto label = label_of(column.method);
  if (column.runs.empty()) {
    return fmt::format("| {} | {:g} | not run: {} | | | | | | | | |\n",
                       label,
                       column.method.down_sampling,
                       column.not_run);
  }
  const auto inside = summary_of(column, &StudyRun::internal_tre_mm);
  return fmt::format(
      "| {} | {:g} | {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.0f} % | {} | {:.1f} | "
      "{:.0f} |\n",
      label,
      column.method.down_sampling,
      mean_and_sd(summary_of(column, &StudyRun::tagged_tre_mm)),
      mean_and_sd(inside, 2),
      inside.median,
      inside.p95,
      inside.max,
      100.0 * success_rate(column, success_mm),
      mean_and_sd(summary_of(column, &StudyRun::registration_ms)),
      summary_of(column, &StudyRun::cpu_ms).median,
      median_points(column));
}

std::string summary_table(const Study& study, const std::string& printed, double success_mm) {
  std::string text = fmt::format(fmt::runtime(kSummaryHead), success_mm) + printed;
  for (const auto& column : study.columns) text += summary_row(column, success_mm);
  return text + "\n";
}

/// The paper's own form: a row a pose. `printed` are the paper's columns, head and values.
struct PrintedColumn {
  const char* head;
  std::span<const double> values;
};

std::string pose_table(const Study& study, const std::vector<PrintedColumn>& printed) {
  std::string head = "| pose | FRE |";
  std::string line = "|---|---|";
  for (const auto& column : study.columns) {
    if (!column.is_shown_by_pose()) continue;
    head += fmt::format(" {} TRE | ms |", label_of(column.method));
    line += "---|---|";
  }
  for (const auto& column : printed) {
    head += fmt::format(" *paper: {}* |", column.head);
    line += "---|";
  }
  std::string text = head + "\n" + line + "\n";
  const std::size_t num_poses = study.columns.back().runs.size();
  for (std::size_t i = 0; i < num_poses; ++i) {
    text += fmt::format("| {} | {:.1f} |", i + 1, study.columns.back().runs[i].fre_mm);
    for (const auto& column : study.columns) {
      if (!column.is_shown_by_pose()) continue;
      text += fmt::format(
          " {:.1f} | {:.1f} |", column.runs[i].tagged_tre_mm, column.runs[i].registration_ms);
    }
    for (const auto& column : printed) {
      text += i < column.values.size() ? fmt::format(" *{:.1f}* |", column.values[i]) : " |";
    }
    text += "\n";
  }
  return text + "\n";
}

std::string fiducial_line(const Study& study, const std::string& printed) {
  const auto& column = study.columns.back();
  return fmt::format(
      "FRE {} mm (paper: {}); start {} mm off inside the body. `{}`, {} markers.\n\n",
      mean_and_sd(summary_of(column, &StudyRun::fre_mm)),
      printed,
      mean_and_sd(summary_of(column, &StudyRun::start_tre_mm)),
      study.camera,
      study.num_markers);
}

/// The first cells of a row: the factor, and what the paper printed for it.
std::string printed_down_sampling(double factor) {
  for (const auto& row : paper::kDownSampled) {
    if (row.factor != factor) continue;
    return fmt::format("| {:g} | *{:.1f} ± {:.1f}* | *{:.1f} ± {:.1f}* |",
                       factor,
                       row.tre_mm,
                       row.tre_sd_mm,
                       row.ms,
                       row.ms_sd);
  }
  return fmt::format("| {:g} | | |", factor);
}

std::string down_sampling_table(const StudiesReport& report) {
  std::string head = "| down-sampling | *paper: TRE* | *paper: ms* |";
  std::string line = "|---|---|---|";
  for (const auto& column : report.down_sampled.front().columns) {
    head += fmt::format(" {}: TRE | ms |", label_of(column.method));
    line += "---|---|";
  }
  std::string text = head + "\n" + line + "\n";
  for (std::size_t i = 0; i < report.down_sampled.size(); ++i) {
    text += printed_down_sampling(report.options.down_samplings[i]);
    for (const auto& column : report.down_sampled[i].columns) {
      if (column.runs.empty()) {
        text += " not run | |";
        continue;
      }
      text += fmt::format(" {} | {} |",
                          mean_and_sd(summary_of(column, &StudyRun::tagged_tre_mm)),
                          mean_and_sd(summary_of(column, &StudyRun::registration_ms)));
    }
    text += "\n";
  }
  return text + "\n";
}

std::string recorded_table(const StudiesReport& report) {
  std::string text =
      "| recording | method, device | right | TRE of all, mm | median | TRE of the right ones, mm "
      "|\n|---|---|---|---|---|---|\n";
  for (const auto& row : report.recorded) {
    text += fmt::format("| {} | {} | {:.0f} % | {} | {:.2f} | {} |\n",
                        row.recording,
                        label_of(row.method),
                        100.0 * row.success_rate,
                        mean_and_sd(row.tre_mm, 2),
                        row.tre_mm.median,
                        row.success_rate > 0.0 ? mean_and_sd(row.tre_success_mm, 2) : "-");
  }
  return text + "\n";
}

std::string introduction(const StudiesReport& report, const std::string& machine) {
  const auto& options = report.options;
  return fmt::format(
      "# The paper's studies, regenerated\n\n"
      "**All data here are simulated**: pictures of a Kinect v1 model (noise, shadow, drop-outs) "
      "over the skin of the case `{}`. The paper's figures stand beside ours in *italics*: real "
      "phantom, real corpse, real Kinect, another machine (GeForce GTX 560), so they show the "
      "order "
      "of size, not a contest.\n\n"
      "What the simulation leaves out: errors of the CT and its segmentation (the camera looks at "
      "the very surface that is registered), deformation between CT and picture, reflections, the "
      "sensor's systematic error (but for the last study) and the error of the calibration between "
      "depth and colour.\n\n"
      "Tagging is simulated: normal errors of {:g} px each way in the colour picture (the depth is "
      "read there), {:g} mm each way in the CT. A start is Horn's fit of four places on the skin "
      "with {:g} mm each way. *TRE as tagged* is what the paper measures: root mean square over "
      "the "
      "five visible markers nearest to the picture's centre, tagging included. *TRE inside* is "
      "measured at {} places in the body against the truth, without tagging. Neither markers nor "
      "places are used by any registration. Seed {}.\n\n"
      "Every method gets the same poses and starts, and the surface cut out of the picture where "
      "the start expects the body. ICP: 200 iterations, threshold 1e-5, overlap 90 %, as the "
      "paper. Times: one registration, {}; CPU: of the calling thread alone.\n\n",
      report.case_name,
      options.tagging.marker_px,
      options.tagging.marker_ct_mm,
      options.tagging.landmark_mm,
      16,
      options.seed,
      machine);
}

std::string plot_line(const StudyPlot& plot) {
  return fmt::format("![{}]({})\n\n", plot.caption, plot.file_name);
}

}  // namespace

std::string to_markdown(const StudiesReport& report, const std::string& machine) {
  const double success_mm = report.options.success_mm;
  const auto plots = study_plots(report);
  std::string text = introduction(report, machine);
  text += plot_line(plots[0]);
  text += "## Table 1: phantom study\n\n";
  text += fiducial_line(report.phantom, paper::kPhantomFre);
  text += summary_table(
      report.phantom,
      printed_row("icp", paper::kPhantomIcpTre, paper::kPhantomIcpTime) +
          printed_row("trimmed-icp", paper::kPhantomTrimmedTre, paper::kPhantomTrimmedTime),
      success_mm);
  text += pose_table(report.phantom,
                     {{"FRE", paper::kPhantomFreMm},
                      {"icp TRE", paper::kPhantomIcpTreMm},
                      {"ms", paper::kPhantomIcpMs},
                      {"trimmed-icp TRE", paper::kPhantomTrimmedTreMm},
                      {"ms", paper::kPhantomTrimmedMs}});
  text +=
      "## Table 2: post-mortem-like study\n\n"
      "A hand and its forearm, which the CT does not have, rest on the body or hover over it, as "
      "the "
      "paper's left arm that only the Kinect saw.\n\n";
  text += fiducial_line(report.post_mortem, paper::kPostMortemFre);
  text += summary_table(
      report.post_mortem,
      printed_row("trimmed-icp", paper::kPostMortemTrimmedTre, paper::kPostMortemTrimmedTime),
      success_mm);
  text += pose_table(report.post_mortem,
                     {{"FRE", paper::kPostMortemFreMm},
                      {"trimmed-icp TRE", paper::kPostMortemTrimmedTreMm},
                      {"ms", paper::kPostMortemTrimmedMs}});
  text +=
      "## Table 3: down-sampling\n\nThe poses of table 2, trimmed ICP and ours. TRE as tagged, "
      "mm; wall time, ms.\n\n";
  text += down_sampling_table(report) + plot_line(plots[1]);
  text += fmt::format(
      "## {} poses\n\nFive poses say little. The same on more, CPU, at a down-sampling of 2.5:\n\n",
      report.options.num_many_poses);
  const std::array<std::pair<const Study*, const char*>, 5> many = {
      {{&report.many_plain, "Plain, as table 1"},
       {&report.many_hand, "A hand, as table 2"},
       {&report.many_parts,
        "Parts not in the CT: the body goes on where the CT ends, things lie beside it. More of "
        "the "
        "picture is outside the CT than the 10 % that trimmed ICP cuts off"},
       {&report.many_cluttered, "Hand, towel and parts: about half of the skin is hidden"},
       {&report.biased, "A biased sensor, nothing in the way"}}};
  for (const auto& [study, title] : many) {
    text += fmt::format("**{}.** `{}`\n\n", title, study->camera);
    text += summary_table(*study, "", success_mm);
  }
  text += plot_line(plots[2]);
  if (!report.recorded.empty()) {
    text +=
        "## Recordings with a systematic depth error\n\nStarts up to 30 mm and 20 degrees off, "
        "four a frame; *right*: below the limit.\n\n" +
        recorded_table(report);
  }
  if (!report.notes.empty()) {
    text += "Left out:\n\n";
    for (const auto& note : report.notes) text += fmt::format("- {}\n", note);
  }
  return text;
}

}  // namespace mor
