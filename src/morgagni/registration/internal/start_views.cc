// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_views.h"

#include <limits>
#include <utility>

#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/internal/start_fusion.h"
#include "morgagni/registration/internal/start_motion.h"
#include "morgagni/registration/internal/start_scene.h"

namespace mor::internal {
namespace {

constexpr int kMostAge = 25;  ///< In pictures; what was so long ago may have changed.

/// How far apart two places of the camera are; a turn of 3 degrees is one of 25 mm.
double apart_mm(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  constexpr double kTurnMm = 480.0;
  const Eigen::Isometry3d between = a.inverse() * b;
  return between.translation().norm() + kTurnMm * rotation_angle_rad(between);
}

}  // namespace

std::optional<Eigen::Isometry3d> SeenViews::motion_to(const StartPicture& picture) const {
  if (views_.empty()) return std::nullopt;
  const SeenView& last = views_.back();
  std::vector<OtherPicture> others;
  for (const auto& view : views_) {
    if (&view == &last) continue;
    others.push_back({&view.own, view.newest_from_this.inverse()});
  }
  return camera_motion(last.own, picture, others);
}

std::optional<Eigen::Isometry3d> SeenViews::add(StartPicture picture,
                                                std::vector<StartPlane> planes,
                                                float body_extent_mm) {
  const auto last_from_newest = motion_to(picture);
  if (!last_from_newest) views_.clear();
  for (auto& view : views_) {
    view.newest_from_this = last_from_newest->inverse() * view.newest_from_this;
    ++view.age;
  }
  views_.push_back({.own = picture,
                    .picture = std::move(picture),
                    .planes = std::move(planes),
                    .standing = {},
                    .newest_from_this = Eigen::Isometry3d::Identity()});
  if (!last_from_newest) return std::nullopt;  // Alone, it needs no points.
  if (views_.size() > kMostViews) views_.erase(views_.begin() + least_needed());
  fuse(body_extent_mm);
  return last_from_newest;
}

std::ptrdiff_t SeenViews::least_needed() const {
  if (views_.front().age > kMostAge) return 0;
  std::ptrdiff_t least = 0;
  double nearest_mm = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < views_.size(); ++i) {
    for (std::size_t j = i + 1; j < views_.size(); ++j) {
      const double mm = apart_mm(views_[i].newest_from_this, views_[j].newest_from_this);
      if (mm >= nearest_mm) continue;
      nearest_mm = mm;
      least = static_cast<std::ptrdiff_t>(i);
    }
  }
  return least;
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
