// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/geometry/point_cloud.h"
#include "morgagni/registration/internal/start_finding.h"
#include "morgagni/registration/internal/start_picture.h"
#include "morgagni/registration/internal/start_planes.h"

namespace mor::internal {

/// A picture that the search has looked at.
struct SeenView {
  StartPicture own;      ///< As it was taken.
  StartPicture picture;  ///< With what the others measured at the same places (start_fusion.h).
  std::vector<StartPlane> planes;
  /// What is not in a large plane, spread evenly, in its own frame. Empty while it stands alone.
  PointCloud standing;
  Eigen::Isometry3d newest_from_this = Eigen::Isometry3d::Identity();
  int age = 0;  ///< Pictures taken since.
};

/// The newest picture, at the end, and earlier ones of a camera that moves about a scene that
/// stands still: those from places that differ most, as they show most.
class SeenViews {
 public:
  static constexpr std::size_t kMostViews = 5;

  SeenViews() = default;
  explicit SeenViews(std::vector<SeenView> views) : views_(std::move(views)) {}

  /// Adds the newest picture. Those before are forgotten where the motion since is not clear.
  /// @param body_extent_mm  The body's largest side: sets how dense its points are.
  /// @return last_from_newest, the camera's motion since the last picture. None: it stands alone.
  std::optional<Eigen::Isometry3d> add(StartPicture picture,
                                       std::vector<StartPlane> planes,
                                       float body_extent_mm);
  /// Keeps the newest alone.
  void forget_earlier();

  [[nodiscard]] const std::vector<SeenView>& all() const { return views_; }
  [[nodiscard]] const SeenView& newest() const { return views_.back(); }
  [[nodiscard]] bool are_several() const { return views_.size() > 1; }
  /// What stands in all of them, frame of the newest.
  [[nodiscard]] PointCloud standing() const;

 private:
  /// last_from_newest, where it is clear.
  [[nodiscard]] std::optional<Eigen::Isometry3d> motion_to(const StartPicture& picture) const;
  /// Of those before the newest, the one whose place is nearest to a later one's.
  [[nodiscard]] std::ptrdiff_t least_needed() const;
  /// Averages the pictures at each one's place.
  void fuse(float body_extent_mm);

  std::vector<SeenView> views_;
};

/// What a search hands on to the one in the next picture.
struct StartRecall {
  std::size_t num_searched = 0;  ///< Pictures so far.
  SeenViews views;
  std::vector<StartFinding> findings;  ///< Poses not yet believed, frame of the newest view.
};

}  // namespace mor::internal
