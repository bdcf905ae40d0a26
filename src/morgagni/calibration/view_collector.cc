// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/view_collector.h"

#include <algorithm>
#include <cmath>

#include <spdlog/fmt/fmt.h>

namespace mor {
namespace {

constexpr double kWallShare = 0.5;  ///< Of the depth picture.

/// Mean distance between the corners that two sightings share; none where they share few.
std::optional<double> mean_shift_px(const BoardSighting& a, const BoardSighting& b) {
  double sum = 0.0;
  int count = 0;
  for (const auto& corner : a.corners) {
    const auto same = std::ranges::find(b.corners, corner.id, &SeenCorner::id);
    if (same == b.corners.end()) continue;
    sum += (corner.px - same->px).norm();
    ++count;
  }
  if (count < 4) return std::nullopt;
  return sum / count;
}

}  // namespace

ViewCollector::ViewCollector(const CalibrationBoard& board,
                             const RgbdCalibration& by_design,
                             const CollectorOptions& options)
    : board_(board), by_design_(by_design), options_(options), reader_(by_design.depth) {}

/// The board's plane goes on around it, over most of the depth picture.
bool ViewCollector::is_on_wall(const RigView& view) const {
  if (!view.color || view.depth_mm.empty()) return false;
  const auto color_from_board = camera_from_board(board_, *view.color, by_design_.color);
  if (!color_from_board) return false;
  const auto readings = reader_.read(view.depth_mm,
                                     board_,
                                     by_design_.color_from_depth.inverse() * *color_from_board,
                                     BoardArea::kWhole,
                                     0);
  const auto beside = std::ranges::count(readings, true, &DepthReading::is_beside);
  return static_cast<double>(beside) > kWallShare * static_cast<double>(reader_.num_blocks());
}

void ViewCollector::keep(RigView view) {
  on_wall_.push_back(is_on_wall(view));
  views_.push_back(std::move(view));
}

bool ViewCollector::is_like_one_taken(const BoardSighting& sighting) const {
  return std::ranges::any_of(views_, [&](const RigView& view) {
    if (!view.color) return false;
    const auto shift_px = mean_shift_px(sighting, *view.color);
    return shift_px && *shift_px < options_.new_pose_px;
  });
}

LiveLook ViewCollector::look(const RgbdFrame& frame, Taking taking, const Infrared& infrared) {
  LiveLook look;
  auto search = find_board(frame.color.view(), board_);
  if (search.found.empty()) {
    last_.reset();
    num_still_ = 0;
    look.say = search.reason;
    return look;
  }
  const auto& sighting = search.found.front();
  look.sighting = sighting;
  const auto moved_px = last_ ? mean_shift_px(*last_, sighting) : std::nullopt;
  look.is_still = moved_px && *moved_px < options_.still_px;
  if (!look.is_still || depth_sum_mm_.width() != frame.depth_mm.width() ||
      depth_sum_mm_.height() != frame.depth_mm.height()) {
    num_still_ = 0;
    depth_sum_mm_ = Image<float>(frame.depth_mm.width(), frame.depth_mm.height());
    depth_count_ = Image<std::uint8_t>(frame.depth_mm.width(), frame.depth_mm.height());
  }
  last_ = sighting;
  ++num_still_;
  for (std::size_t i = 0; i < depth_sum_mm_.size(); ++i) {
    if (frame.depth_mm.data()[i] == 0 || depth_count_.data()[i] == 255) continue;
    depth_sum_mm_.data()[i] += frame.depth_mm.data()[i];
    ++depth_count_.data()[i];
  }
  look.is_new = !is_like_one_taken(sighting);
  if (taking == Taking::kNothing) return look;
  if (sighting.edge_width_px > options_.max_edge_width_px) {
    look.say = "the picture is blurred: hold still, and give more light";
  } else if (!look.is_still) {
    look.say = "hold still";
  } else if (!look.is_new && taking != Taking::kThisPose) {
    look.say = "this pose is taken: move or tilt the board";
  } else if (num_still_ < options_.still_frames) {
    look.say = "hold still";
  } else {
    take(infrared);
    look.was_taken = true;
    look.say = fmt::format("view {} is taken: move or tilt the board", views_.size());
  }
  return look;
}

void ViewCollector::take(const Infrared& infrared) {
  RigView view{.name = fmt::format("view {}", views_.size() + 1),
               .color = last_,
               .infrared = std::nullopt,
               .depth_mm = depth_sum_mm_};
  for (std::size_t i = 0; i < view.depth_mm.size(); ++i) {
    if (depth_count_.data()[i] > 0) view.depth_mm.data()[i] /= depth_count_.data()[i];
  }
  if (infrared) {
    if (const auto picture = infrared()) {
      auto search = find_board(picture->view(), board_);
      if (!search.found.empty()) view.infrared = std::move(search.found.front());
    }
  }
  keep(std::move(view));
}

std::string ViewCollector::add(const std::string& name,
                               const Image<Rgb8>* color,
                               const Image<Rgb8>* infrared,
                               const Image<std::uint16_t>* depth_mm) {
  RigView view{.name = name, .color = {}, .infrared = {}, .depth_mm = {}};
  std::string reason;
  const auto find = [&](const Image<Rgb8>* picture, const char* what) {
    std::optional<BoardSighting> sighting;
    if (picture == nullptr) return sighting;
    auto search = find_board(picture->view(), board_);
    if (!search.found.empty()) {
      sighting = std::move(search.found.front());
    } else {
      reason += fmt::format("{}{}: {}", reason.empty() ? "" : "; ", what, search.reason);
    }
    return sighting;
  };
  view.color = find(color, "colour");
  view.infrared = find(infrared, "infrared");
  if (depth_mm != nullptr) {
    view.depth_mm = Image<float>(depth_mm->width(), depth_mm->height());
    for (std::size_t i = 0; i < depth_mm->size(); ++i) {
      view.depth_mm.data()[i] = depth_mm->data()[i];
    }
  }
  if (view.color || view.infrared) keep(std::move(view));
  return reason;
}

void ViewCollector::drop_last() {
  if (views_.empty()) return;
  views_.pop_back();
  on_wall_.pop_back();
}

Coverage ViewCollector::coverage() const {
  std::vector<BoardSighting> sightings;
  std::vector<bool> on_wall;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    if (!views_[i].color) continue;
    sightings.push_back(*views_[i].color);
    on_wall.push_back(on_wall_[i]);
  }
  return coverage_of(board_, sightings, on_wall, by_design_.color, options_.wanted);
}

Result<RigCalibration> ViewCollector::solve(const RigOptions& options) const {
  return calibrate_rig(board_, views_, by_design_, options);
}

}  // namespace mor
