// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/registration/internal/start_scene.h"
#include "morgagni/registration/internal/start_verification.h"

namespace mor::internal {

/// A pose with what speaks for and against it.
struct StartFinding {
  Eigen::Isometry3d ct_from_depth = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d on_plane = Eigen::Isometry3d::Identity();  ///< Before refinement left it.
  Eigen::Vector3d up_ct = -Eigen::Vector3d::UnitY();  ///< Normal of the plane it was found on.
  double foot_ct_mm = 0.0;                            ///< That plane's height along it, frame ct.
  std::shared_ptr<const StartScene> scene;            ///< What stands on the plane it was found on.
  SkinAgreement agreement;
  double score = 0.0;      ///< Larger is better; comparable among findings of one step.
  bool is_judged = false;  ///< `agreement` is what all pictures so far say together.
};

/// The plane that the finding was found on, frame depth.
[[nodiscard]] StartPlane plane_of(const StartFinding& finding);

/// Sorts the findings, best first, and keeps `count` of those of which none puts the body within
/// `near_mm` of where a better one does.
/// @param bounds  Of the body, frame ct.
void keep_best(std::vector<StartFinding>& findings,
               std::size_t count,
               double near_mm,
               const Eigen::AlignedBox3d& bounds);

/// How much of the best finding's score the next one has, 0..1. @param findings  Best first.
[[nodiscard]] double runner_up_share(const std::vector<StartFinding>& findings);

/// Whether the best may be believed, after a look at all (start_decision.h). @param num_tries
/// Pictures in which one might have been.
[[nodiscard]] bool passes(const std::vector<StartFinding>& findings, std::size_t num_tries);
/// Whether it is beyond doubt: what else there may be needs no look.
[[nodiscard]] bool settles(const std::vector<StartFinding>& findings);

}  // namespace mor::internal
