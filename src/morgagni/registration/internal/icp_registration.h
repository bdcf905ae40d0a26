// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "morgagni/registration/fine_registration.h"
#include "morgagni/registration/internal/icp_backend.h"

namespace mor::internal {

/// The paper's ICP family, on any device. Uses every moving point.
///
/// - ICP: Besl & McKay, "A method for registration of 3-D shapes", IEEE PAMI 1992, with the
///   closed-form motion of Horn 1987.
/// - Trimmed: Chetverikov et al., "The trimmed iterative closest point algorithm", ICPR 2002.
/// - Anisotropic (A-ICP): Maier-Hein et al., "Convergent iterative closest-point algorithm to
///   accomodate anisotropic and inhomogenous localization error", IEEE PAMI 34(8), 2012,
///   doi:10.1109/TPAMI.2011.248, with the weighted motion of Balachandran & Fitzpatrick,
///   "Iterative solution for rigid-body point-based registration with anisotropic weighting", SPIE
///   2009.
///
/// A cloud on a line, plane or sphere, and pairs that leave the pose open, end as kDegenerate with
/// the start pose.
class IcpRegistration final : public FineRegistration {
 public:
  /// @param device  None: the CPU. It is dropped for the CPU, with one warning, when it fails.
  IcpRegistration(std::shared_ptr<const IcpSurface> surface,
                  const RegistrationOptions& options,
                  std::unique_ptr<IcpBackend> device);

  /// The start's quality changes nothing: these methods have one schedule.
  /// @threads Reentrant; alignments on a device wait for each other.
  [[nodiscard]] Result<RegistrationResult> align(const PointCloud& moving,
                                                 const Eigen::Isometry3d& fixed_from_moving_init,
                                                 StartQuality start) const override;
  [[nodiscard]] std::string device_name() const override;

 private:
  std::shared_ptr<const IcpSurface> surface_;
  RegistrationOptions options_;
  mutable std::mutex device_mutex_;
  mutable std::unique_ptr<IcpBackend> device_;  ///< None: the CPU.
};

/// The same, on the device that the options name. Where there is no OpenCL, or it does not start,
/// the CPU takes over with a warning.
/// @errors kInvalidArgument: a device's name that fits none.
[[nodiscard]] Result<std::unique_ptr<FineRegistration>> make_icp_registration(
    const TriangleMesh& fixed, const RegistrationOptions& options);

}  // namespace mor::internal
