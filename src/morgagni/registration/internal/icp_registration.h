// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "morgagni/geometry/kd_tree.h"
#include "morgagni/registration/fine_registration.h"

namespace mor::internal {

/// Point-to-point ICP, the paper's reference: Besl & McKay, "A method for registration of 3-D
/// shapes", IEEE PAMI 1992, with the closed-form motion of Horn 1987. Trimmed: Chetverikov et al.,
/// "The trimmed iterative closest point algorithm", ICPR 2002. Uses every moving point.
class IcpRegistration final : public FineRegistration {
 public:
  IcpRegistration(std::shared_ptr<const FixedSurface> fixed, const RegistrationOptions& options);

  /// The start's quality changes nothing: these methods have one schedule.
  [[nodiscard]] Result<RegistrationResult> align(const PointCloud& moving,
                                                 const Eigen::Isometry3d& fixed_from_moving_init,
                                                 StartQuality start) const override;

 private:
  std::shared_ptr<const FixedSurface> fixed_;
  RegistrationOptions options_;
  KdTree tree_;
};

}  // namespace mor::internal
