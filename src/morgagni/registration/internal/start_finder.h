// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "morgagni/registration/automatic_start.h"
#include "morgagni/registration/fine_registration.h"
#include "morgagni/registration/internal/start_picture.h"
#include "morgagni/registration/internal/start_scene.h"
#include "morgagni/registration/internal/start_search.h"
#include "morgagni/registration/internal/start_verification.h"
#include "morgagni/registration/internal/start_volume.h"

namespace mor::internal {

/// A refined pose with all that speaks for and against it.
struct StartFinding {
  Eigen::Isometry3d ct_from_depth = Eigen::Isometry3d::Identity();
  double search_score = 0.0;
  double glance_score = 0.0;
  RegistrationResult fit;
  SkinAgreement agreement;
  double score = 0.0;
};

/// The automatic start's steps, one after the other, on the caller's TBB arena.
class StartFinder {
 public:
  [[nodiscard]] static Result<StartFinder> create(std::shared_ptr<const FixedSurface> fixed,
                                                  const PinholeCamera& depth_camera,
                                                  const AutomaticStartOptions& options);

  [[nodiscard]] Result<AutomaticStartResult> find(ImageView<const std::uint16_t> depth_mm,
                                                  const std::stop_token& stop) const;

  /// The best poses on one plane of the picture, each verified, best first.
  [[nodiscard]] Result<std::vector<StartFinding>> find_on(const StartPicture& picture,
                                                          const StartPlane& plane,
                                                          const std::stop_token& stop) const;
  [[nodiscard]] StartPicture picture_of(ImageView<const std::uint16_t> depth_mm) const {
    return maker_.make(depth_mm, static_cast<float>(options_.max_distance_mm));
  }
  [[nodiscard]] std::vector<StartPlane> planes_of(const StartPicture& picture) const;

 private:
  StartFinder(std::shared_ptr<const FixedSurface> fixed,
              const PinholeCamera& depth_camera,
              const AutomaticStartOptions& options,
              std::unique_ptr<FineRegistration> registration);

  [[nodiscard]] AutomaticStartResult decide(const std::vector<StartFinding>& findings) const;

  AutomaticStartOptions options_;
  StartPictureMaker maker_;
  std::vector<StartVolume> volumes_;
  float extent_mm_;
  std::unique_ptr<FineRegistration> registration_;
  StartVerifier verifier_;
  Eigen::AlignedBox3d bounds_;
};

}  // namespace mor::internal
