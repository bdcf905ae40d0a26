// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/study_plots.h"

#include <algorithm>
#include <array>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/evaluation/internal/paper_figures.h"
#include "morgagni/evaluation/internal/svg.h"

namespace mor {
namespace {

using internal::Svg;
using internal::SvgAxis;
using internal::SvgPoint;

constexpr const char* kPaperColor = "#8a8f98";
constexpr const char* kGrid = "#e3e5e8";
constexpr const char* kFrame = "#9aa0a6";

const char* color_of(RegistrationMethod method) {
  switch (method) {
    case RegistrationMethod::kIcp:
      return "#c9752b";
    case RegistrationMethod::kTrimmedIcp:
      return "#3566a8";
    case RegistrationMethod::kAnisotropicIcp:
      return "#9a5fb0";
    case RegistrationMethod::kTrimmedAnisotropicIcp:
      return "#5f5fb0";
    case RegistrationMethod::kField:
      break;
  }
  return "#12875a";
}

std::string label_of(const StudyMethod& method) {
  std::string label(to_string(method.method));
  if (method.method == RegistrationMethod::kField) return label + " (ours)";
  return label + ", " + method.device;
}

std::vector<double> values_of(const StudyColumn& column, double StudyRun::*value) {
  std::vector<double> values;
  for (const auto& run : column.runs) values.push_back(run.*value);
  return values;
}

/// A frame with horizontal lines at the ticks of `y`.
void draw_panel(Svg& svg, SvgPoint corner, double width, double height, const SvgAxis& y) {
  for (const double tick : y.ticks()) {
    svg.line({corner.x, y.px(tick)}, {corner.x + width, y.px(tick)}, kGrid);
    svg.text({corner.x - 6.0, y.px(tick) + 4.0}, fmt::format("{:g}", tick), "end", 11.0);
  }
  svg.line({corner.x, corner.y}, {corner.x, corner.y + height}, kFrame);
  svg.line({corner.x, corner.y + height}, {corner.x + width, corner.y + height}, kFrame);
}

struct Strip {
  std::string label;
  std::string color;
  bool filled;
  std::vector<double> values;
};

/// One column of dots a strip, with a bar at its median; what lies above the axis sits on its edge,
/// marked with its value.
void draw_strips(Svg& svg,
                 SvgPoint corner,
                 double width,
                 const SvgAxis& y,
                 double most,
                 const std::vector<Strip>& strips) {
  const double step = width / static_cast<double>(strips.size());
  for (std::size_t i = 0; i < strips.size(); ++i) {
    const auto& strip = strips[i];
    const double x = corner.x + step * (static_cast<double>(i) + 0.5);
    const double median = summarize(strip.values).median;
    if (!strip.values.empty()) {
      svg.line({x - 0.28 * step, y.px(median)}, {x + 0.28 * step, y.px(median)}, strip.color, 2.5);
    }
    for (std::size_t k = 0; k < strip.values.size(); ++k) {
      const double aside =
          (static_cast<double>(k) + 0.5) / static_cast<double>(strip.values.size());
      const SvgPoint at{x + 0.4 * step * (aside - 0.5), y.px(strip.values[k])};
      svg.dot(at, 3.5, strip.color, strip.filled);
      if (strip.values[k] > most) {
        // One above, one below: neighbours' figures would run into each other.
        const double down = k % 2 == 0 ? -6.0 : 14.0;
        svg.text({at.x, at.y + down}, fmt::format("{:.0f}", strip.values[k]), "middle", 9.0);
      }
    }
    const auto comma = strip.label.find(", ");
    svg.text({x, y.px(0.0) + 17.0}, strip.label.substr(0, comma), "middle", 11.0);
    if (comma != std::string::npos) {
      svg.text({x, y.px(0.0) + 31.0}, strip.label.substr(comma + 2), "middle", 11.0);
    }
  }
}

std::vector<Strip> strips_of(const Study& study) {
  std::vector<Strip> strips;
  for (const auto& column : study.columns) {
    if (!column.is_shown_by_pose()) continue;
    strips.push_back({label_of(column.method),
                      color_of(column.method.method),
                      column.method.device == "cpu",
                      values_of(column, &StudyRun::tagged_tre_mm)});
  }
  return strips;
}

template <std::size_t N>
Strip printed(const char* label, const std::array<double, N>& values) {
  return {label, kPaperColor, false, {values.begin(), values.end()}};
}

std::string accuracy_plot(const StudiesReport& report) {
  constexpr double kMostMm = 12.0;
  constexpr double kTop = 46.0;
  constexpr double kHeight = 260.0;
  Svg svg(960.0, 370.0);
  const SvgAxis y(0.0, kMostMm, kTop + kHeight, kTop, false);
  const auto draw = [&](double left, double width, const char* title, std::vector<Strip> strips) {
    draw_panel(svg, {left, kTop}, width, kHeight, y);
    svg.text({left, 26.0}, title, "start", 14.0, true);
    draw_strips(svg, {left, kTop}, width, y, kMostMm, strips);
  };
  auto phantom = strips_of(report.phantom);
  phantom.insert(phantom.begin(), printed("trimmed-icp, paper", paper::kPhantomTrimmedTreMm));
  phantom.insert(phantom.begin(), printed("icp, paper", paper::kPhantomIcpTreMm));
  auto post_mortem = strips_of(report.post_mortem);
  post_mortem.insert(post_mortem.begin(),
                     printed("trimmed-icp, paper", paper::kPostMortemTrimmedTreMm));
  draw(60.0, 520.0, "Phantom study", phantom);
  draw(640.0, 300.0, "Post-mortem-like study", post_mortem);
  svg.upright_text({20.0, kTop + 0.5 * kHeight}, "TRE at the tagged markers, mm");
  svg.text(
      {60.0, 362.0},
      "A dot a pose, a bar the median. Grey: printed in the paper (real data). Rings: OpenCL or "
      "printed.",
      "start",
      11.0);
  return svg.finish();
}

struct Curve {
  std::string label;
  std::string color;
  std::string dash;
  std::vector<SvgPoint> values;
};

void draw_curves(Svg& svg, const SvgAxis& x, const SvgAxis& y, const std::vector<Curve>& curves) {
  for (const auto& curve : curves) {
    std::vector<SvgPoint> points;
    for (const auto& value : curve.values) points.push_back({x.px(value.x), y.px(value.y)});
    svg.polyline(points, curve.color, 2.0, curve.dash);
    for (const auto& point : points) svg.dot(point, 3.0, curve.color, curve.dash.empty());
  }
}

void draw_legend(Svg& svg, SvgPoint at, const std::vector<Curve>& curves, double step) {
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const double x = at.x + step * static_cast<double>(i);
    svg.polyline({{x, at.y}, {x + 26.0, at.y}}, curves[i].color, 2.5, curves[i].dash);
    svg.text({x + 32.0, at.y + 4.0}, curves[i].label);
  }
}

/// One curve a column of the table, in the order of the first study; `value` sums up a column.
std::vector<Curve> down_sampling_curves(const StudiesReport& report, double StudyRun::*value) {
  std::vector<Curve> curves;
  for (std::size_t i = 0; i < report.down_sampled.front().columns.size(); ++i) {
    const auto& method = report.down_sampled.front().columns[i].method;
    Curve curve{label_of(method), color_of(method.method), method.device == "cpu" ? "" : "6 4", {}};
    for (const auto& study : report.down_sampled) {
      const auto& column = study.columns[i];
      if (column.runs.empty()) continue;
      curve.values.push_back(
          {column.method.down_sampling, summarize(values_of(column, value)).median});
    }
    if (!curve.values.empty()) curves.push_back(std::move(curve));
  }
  return curves;
}

Curve printed_curve(double paper::DownSampled::*value) {
  Curve curve{"trimmed-icp, paper (mean; real data, GPU)", kPaperColor, "2 3", {}};
  for (const auto& row : paper::kDownSampled) curve.values.push_back({row.factor, row.*value});
  return curve;
}

std::string down_sampling_plot(const StudiesReport& report) {
  constexpr double kTop = 60.0;
  constexpr double kHeight = 240.0;
  constexpr double kWidth = 380.0;
  Svg svg(960.0, 360.0);
  auto errors = down_sampling_curves(report, &StudyRun::tagged_tre_mm);
  auto times = down_sampling_curves(report, &StudyRun::registration_ms);
  errors.push_back(printed_curve(&paper::DownSampled::tre_mm));
  times.push_back(printed_curve(&paper::DownSampled::ms));
  double most_mm = 8.0;
  for (const auto& curve : errors) {
    for (const auto& value : curve.values) most_mm = std::max(most_mm, 1.1 * value.y);
  }
  const SvgAxis y_mm(0.0, std::min(most_mm, 30.0), kTop + kHeight, kTop, false);
  const SvgAxis y_ms(0.1, 50000.0, kTop + kHeight, kTop, true);
  for (const bool is_time : {false, true}) {
    const double left = is_time ? 550.0 : 70.0;
    const SvgAxis x(0.9, 4.1, left, left + kWidth, false);
    const auto& y = is_time ? y_ms : y_mm;
    draw_panel(svg, {left, kTop}, kWidth, kHeight, y);
    for (const auto& row : paper::kDownSampled) {
      svg.text({x.px(row.factor), kTop + kHeight + 17.0},
               fmt::format("{:g}", row.factor),
               "middle",
               11.0);
    }
    svg.text({left + 0.5 * kWidth, kTop + kHeight + 36.0},
             "down-sampling of the depth picture",
             "middle");
    svg.text(
        {left, 26.0},
        is_time ? "Time of a registration: median (wall)" : "Error, post-mortem-like study: median",
        "start",
        14.0,
        true);
    svg.upright_text({left - 48.0, kTop + 0.5 * kHeight},
                     is_time ? "ms (logarithmic)" : "TRE at the tagged markers, mm");
    draw_curves(svg, x, y, is_time ? times : errors);
  }
  draw_legend(svg, {70.0, 350.0}, errors, 190.0);
  return svg.finish();
}

constexpr double kLeastErrorMm = 0.01;
constexpr double kMostErrorMm = 100.0;

/// The share of poses below each error: from the lower left to the right, as far as the panel goes.
Curve distribution(const StudyColumn& column) {
  Curve curve{label_of(column.method), color_of(column.method.method), "", {}};
  auto errors = values_of(column, &StudyRun::internal_tre_mm);
  std::sort(errors.begin(), errors.end());
  double share = 0.0;
  for (const double error : errors) {
    if (error > kMostErrorMm) break;
    curve.values.push_back({error, share});
    share += 100.0 / static_cast<double>(errors.size());
    curve.values.push_back({error, share});
  }
  return curve;
}

std::string distribution_plot(const StudiesReport& report) {
  constexpr double kTop = 46.0;
  constexpr double kHeight = 200.0;
  constexpr double kWidth = 142.0;
  const std::array<std::pair<const Study*, const char*>, 5> panels = {
      {{&report.many_plain, "Plain"},
       {&report.many_hand, "Hand"},
       {&report.many_parts, "Parts not in the CT"},
       {&report.many_cluttered, "Hand, towel, parts"},
       {&report.biased, "Biased sensor"}}};
  Svg svg(960.0, 340.0);
  const SvgAxis y(0.0, 100.0, kTop + kHeight, kTop, false);
  std::vector<Curve> legend;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const double left = 60.0 + 180.0 * static_cast<double>(i);
    const SvgAxis x(kLeastErrorMm, kMostErrorMm, left, left + kWidth, true);
    draw_panel(svg, {left, kTop}, kWidth, kHeight, y);
    svg.text({left, 26.0}, panels[i].second, "start", 14.0, true);
    for (const double tick : {0.01, 0.1, 1.0, 10.0, 100.0}) {
      svg.line({x.px(tick), kTop}, {x.px(tick), kTop + kHeight}, kGrid);
      svg.text({x.px(tick), kTop + kHeight + 17.0}, fmt::format("{:g}", tick), "middle", 11.0);
    }
    legend.clear();
    for (const auto& column : panels[i].first->columns) {
      if (column.runs.empty()) continue;
      legend.push_back(distribution(column));
      std::vector<SvgPoint> points;
      points.push_back({x.px(kLeastErrorMm), y.px(0.0)});
      for (const auto& value : legend.back().values) {
        points.push_back({x.px(value.x), y.px(value.y)});
      }
      points.push_back({x.px(kMostErrorMm), points.back().y});
      svg.polyline(points, legend.back().color, 2.0);
    }
  }
  svg.text({500.0, kTop + kHeight + 38.0}, "error inside the body, mm (logarithmic)", "middle");
  svg.upright_text({20.0, kTop + 0.5 * kHeight}, "poses below it, %");
  draw_legend(svg, {240.0, 322.0}, legend, 180.0);
  return svg.finish();
}

}  // namespace

std::vector<StudyPlot> study_plots(const StudiesReport& report) {
  return {{"accuracy.svg",
           "Target registration error at the tagged markers, pose by pose, beside the paper's",
           accuracy_plot(report)},
          {"down_sampling.svg",
           "Error and time against down-sampling, beside the paper's table 3",
           down_sampling_plot(report)},
          {"many_poses.svg",
           "Share of poses below an error inside the body",
           distribution_plot(report)}};
}

}  // namespace mor
