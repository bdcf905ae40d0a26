// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// How near a calibration comes to the truth: boards drawn through lenses that distort, with blur,
// grain and a range camera's noise (SimulatedBoardCamera). All of it is synthetic; each seed is
// another camera, other poses and other noise. Seeds below 100 were used in developing.
#include <cmath>
#include <ctime>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/calibration/board_pattern.h"
#include "morgagni/calibration/view_collector.h"
#include "morgagni/camera/simulated_board_camera.h"
#include "morgagni/core/statistics.h"

namespace mor {
namespace {

struct Arguments {
  std::string board = to_string(CalibrationBoard{});
  std::string camera;
  int num_seeds = 20;
  int first_seed = 101;
  int num_views = 24;
  int num_wall_views = 10;
  bool has_infrared = true;
};

struct Errors {
  double color_focal_percent = 0.0;
  double depth_focal_percent = 0.0;
  double color_center_px = 0.0;
  double depth_center_px = 0.0;
  double baseline_mm = 0.0;
  double depth_before_mm = 0.0;
  double depth_after_mm = 0.0;
  double reduced_percent = 0.0;
};

double worst_focal_percent(const PinholeCamera& found, const PinholeCamera& truth) {
  return 100.0 * std::max(std::abs(found.focal_x_px / truth.focal_x_px - 1.0),
                          std::abs(found.focal_y_px / truth.focal_y_px - 1.0));
}

double center_px(const PinholeCamera& found, const PinholeCamera& truth) {
  return std::hypot(found.center_x_px - truth.center_x_px, found.center_y_px - truth.center_y_px);
}

/// The systematic error left, over the picture and from 500 to 1200 mm.
void measure_depth(const SimulatedBoardCamera& camera,
                   const RgbdCalibration& found,
                   Errors& errors) {
  double before = 0.0;
  double after = 0.0;
  int count = 0;
  const auto& lens = camera.truth().depth;
  for (double z_mm = 500.0; z_mm <= 1200.0; z_mm += 25.0) {
    for (int y = 8; y < lens.height_px; y += 16) {
      for (int x = 8; x < lens.width_px; x += 16) {
        const double wrong_mm = camera.bias_mm(x, y, z_mm);
        const double left_mm =
            wrong_mm +
            (found.depth_correction
                 ? found.depth_correction->add_mm(
                       Eigen::Vector2d(x, y), lens.width_px, lens.height_px, z_mm + wrong_mm)
                 : 0.0);
        before += wrong_mm * wrong_mm;
        after += left_mm * left_mm;
        ++count;
      }
    }
  }
  errors.depth_before_mm = std::sqrt(before / count);
  errors.depth_after_mm = std::sqrt(after / count);
  errors.reduced_percent = 100.0 * (1.0 - errors.depth_after_mm / errors.depth_before_mm);
}

/// Two frames a view, the second where the first has gaps: less than a board held still gives.
Image<std::uint16_t> filled_depth(const SimulatedBoardCamera& camera,
                                  std::uint64_t pose,
                                  Image<std::uint16_t> depth_mm) {
  const auto again = camera.frame_at(pose, 1);
  for (std::size_t i = 0; i < depth_mm.size(); ++i) {
    if (depth_mm.data()[i] == 0) depth_mm.data()[i] = again->depth_mm.data()[i];
  }
  return depth_mm;
}

void add_views(const SimulatedBoardCamera& camera,
               const Arguments& arguments,
               int num_views,
               ViewCollector& collector) {
  for (int i = 0; i < num_views; ++i) {
    const auto pose = static_cast<std::uint64_t>(i);
    const auto frame = camera.frame_at(pose, 0);
    const auto infrared = camera.infrared_at(pose);
    const auto depth_mm = filled_depth(camera, pose, frame->depth_mm);
    (void)collector.add(fmt::format("view {}", collector.views().size() + 1),
                        &frame->color,
                        arguments.has_infrared ? &infrared : nullptr,
                        &depth_mm);
  }
}

Result<Errors> run(const Arguments& arguments, int seed) {
  MOR_TRY(const auto board, parse_board(arguments.board));
  MOR_TRY(auto options,
          SimulatedBoardOptions::parse(arguments.camera + (arguments.camera.empty() ? "" : ",") +
                                       fmt::format("seed={}", seed)));
  options.backing = BoardBacking::kAir;
  MOR_TRY(const auto camera, SimulatedBoardCamera::create(board_picture(board), options));
  ViewCollector collector(board, camera->calibration());
  add_views(*camera, arguments, arguments.num_views, collector);
  // Then the board hangs on a wall, which the depth camera sees whole.
  options.backing = BoardBacking::kWall;
  options.near_mm = 500.0;
  options.far_mm = 1250.0;
  options.tilt_deg = 15.0;
  MOR_TRY(const auto wall_camera, SimulatedBoardCamera::create(board_picture(board), options));
  add_views(*wall_camera, arguments, arguments.num_wall_views, collector);
  MOR_TRY(const auto result, collector.solve());
  const auto& found = result.calibration;
  const auto& truth = camera->truth();
  Errors errors;
  errors.color_focal_percent = worst_focal_percent(found.color, truth.color);
  errors.depth_focal_percent = worst_focal_percent(found.depth, truth.depth);
  errors.color_center_px = center_px(found.color, truth.color);
  errors.depth_center_px = center_px(found.depth, truth.depth);
  errors.baseline_mm = std::abs(found.color_from_depth.translation().norm() -
                                truth.color_from_depth.translation().norm());
  measure_depth(*camera, found, errors);
  for (const auto& remark : result.remarks) fmt::print("seed {}: {}\n", seed, remark);
  return errors;
}

struct Row {
  const char* name;
  double Errors::*value;
  double limit;
  bool is_at_least;
};

constexpr Row kRows[] = {
    {"colour focal length, %", &Errors::color_focal_percent, 0.2, false},
    {"depth focal length, %", &Errors::depth_focal_percent, 0.2, false},
    {"colour centre, px", &Errors::color_center_px, 1.0, false},
    {"depth centre, px", &Errors::depth_center_px, 1.0, false},
    {"baseline, mm", &Errors::baseline_mm, 0.5, false},
    {"depth error before, mm", &Errors::depth_before_mm, 0.0, true},
    {"depth error after, mm", &Errors::depth_after_mm, 0.0, true},
    {"depth error reduced by, %", &Errors::reduced_percent, 80.0, true},
};

void print_table(const std::vector<Errors>& all) {
  fmt::print("{:<28}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}  success\n",
             "synthetic boards",
             "mean",
             "SD",
             "median",
             "p95",
             "max",
             "min");
  for (const auto& row : kRows) {
    std::vector<double> values;
    double sum = 0.0;
    int good = 0;
    for (const auto& errors : all) {
      const double value = errors.*row.value;
      values.push_back(value);
      sum += value;
      good += (row.is_at_least ? value >= row.limit : value <= row.limit) ? 1 : 0;
    }
    const double mean = sum / static_cast<double>(values.size());
    double squares = 0.0;
    for (const double value : values) squares += (value - mean) * (value - mean);
    const double sd =
        std::sqrt(squares / std::max<double>(1.0, static_cast<double>(values.size()) - 1.0));
    fmt::print("{:<28}{:>8.3f}{:>8.3f}{:>8.3f}{:>8.3f}{:>8.3f}{:>8.3f}  {}\n",
               row.name,
               mean,
               sd,
               quantile(values, 0.5),
               quantile(values, 0.95),
               quantile(values, 1.0),
               quantile(values, 0.0),
               row.limit == 0.0 ? std::string()
                                : fmt::format("{} of {} ({} {})",
                                              good,
                                              values.size(),
                                              row.is_at_least ? ">=" : "<=",
                                              row.limit));
  }
}

int evaluate(const Arguments& arguments) {
  std::vector<Errors> all;
  int num_failed = 0;
  for (int seed = arguments.first_seed; seed < arguments.first_seed + arguments.num_seeds; ++seed) {
    const auto errors = run(arguments, seed);
    if (errors) {
      all.push_back(*errors);
    } else {
      ++num_failed;
      fmt::print("seed {}: {}\n", seed, errors.error().message);
    }
  }
  fmt::print(
      "{} seeds from {}, {} views and {} on a wall, {}, camera {}; {} refused; {:.1f} s of "
      "processor time\n",
      arguments.num_seeds,
      arguments.first_seed,
      arguments.num_views,
      arguments.num_wall_views,
      arguments.has_infrared ? "with infrared" : "without infrared",
      arguments.camera.empty() ? "as by default" : arguments.camera,
      num_failed,
      static_cast<double>(std::clock()) / CLOCKS_PER_SEC);
  if (all.empty()) return 1;
  print_table(all);
  return 0;
}

}  // namespace
}  // namespace mor

int main(int argc, char** argv) {
  mor::Arguments arguments;
  CLI::App app{"Calibration of synthetic boards against the truth"};
  app.add_option("--board", arguments.board)->capture_default_str();
  app.add_option("--camera", arguments.camera, "Keys of simulated-board:, such as sensor=tof");
  app.add_option("--seeds", arguments.num_seeds)
      ->capture_default_str()
      ->check(CLI::Range(1, 10000));
  app.add_option("--first-seed", arguments.first_seed)->capture_default_str();
  app.add_option("--views", arguments.num_views)->capture_default_str()->check(CLI::Range(8, 200));
  app.add_option("--wall-views", arguments.num_wall_views)
      ->capture_default_str()
      ->check(CLI::Range(0, 200));
  app.add_flag("!--no-infrared", arguments.has_infrared);
  CLI11_PARSE(app, argc, argv);
  return mor::evaluate(arguments);
}
