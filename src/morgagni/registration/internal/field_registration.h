// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "morgagni/registration/fine_registration.h"
#include "morgagni/registration/internal/skin_view.h"

namespace mor::internal {

/// The default engine: point-to-plane Gauss-Newton (Chen & Medioni 1992) on SE(3) over the skin's
/// distance field, with Tukey's kernel annealed from wide to narrow, few points first and all last.
class FieldRegistration final : public FineRegistration {
 public:
  FieldRegistration(std::shared_ptr<const FixedSurface> fixed, const RegistrationOptions& options);

  /// One thread.
  [[nodiscard]] Result<RegistrationResult> align(const PointCloud& moving,
                                                 const Eigen::Isometry3d& fixed_from_moving_init,
                                                 StartQuality start) const override;

 private:
  std::shared_ptr<const FixedSurface> fixed_;
  SkinProbe probe_;
  RegistrationOptions options_;
};

}  // namespace mor::internal
