// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_views.h"

#include <algorithm>
#include <utility>

#include "morgagni/registration/internal/sensor_points.h"
#include "morgagni/registration/internal/start_fusion.h"
#include "morgagni/registration/internal/start_motion.h"
#include "morgagni/registration/internal/start_scene.h"

namespace mor::internal {

std::optional<Eigen::Isometry3d> SeenViews::add(StartPicture picture,
                                                std::vector<StartPlane> planes,
                                                float body_extent_mm) {
  std::optional<Eigen::Isometry3d> last_from_newest;
  if (!views_.empty()) last_from_newest = camera_motion(views_.back().own, picture);
  if (!last_from_newest) views_.clear();
  if (views_.size() == kMostViews) views_.erase(views_.begin());
  for (auto& view : views_) {
    view.newest_from_this = last_from_newest->inverse() * view.newest_from_this;
  }
  views_.push_back(
      {picture, std::move(picture), std::move(planes), {}, Eigen::Isometry3d::Identity()});
  if (!last_from_newest) return std::nullopt;  // Alone, it needs no points.
  fuse(body_extent_mm);
  return last_from_newest;
}

void SeenViews::fuse(float body_extent_mm) {
  for (auto& view : views_) {
    std::vector<OtherPicture> others;
    for (const auto& other : views_) {
      if (&other == &view) continue;
      others.push_back({&other.own, other.newest_from_this.inverse() * view.newest_from_this});
    }
    view.picture = fused(view.own, others);
    view.standing = standing_points(view.picture, view.planes, body_extent_mm);
  }
}

void SeenViews::forget_earlier() {
  views_.erase(views_.begin(), views_.end() - 1);
  views_.back().picture = views_.back().own;
}

PointCloud SeenViews::standing() const {
  PointCloud all;
  for (const auto& view : views_) {
    const Eigen::Isometry3f pose = view.newest_from_this.cast<float>();
    for (std::size_t i = 0; i < view.standing.size(); ++i) {
      all.points.push_back(pose * view.standing.points[i]);
      all.normals.push_back(pose.linear() * view.standing.normals[i]);
    }
  }
  return all;
}

}  // namespace mor::internal
