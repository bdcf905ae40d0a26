// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/result.h"
#include "morgagni/geometry/point_cloud.h"
#include "morgagni/registration/fixed_surface.h"
#include "morgagni/registration/pose_information.h"

namespace mor {

enum class RegistrationMethod : std::uint8_t {
  kIcp,                    ///< Point-to-point ICP, Besl & McKay 1992 with Horn 1987.
  kTrimmedIcp,             ///< The same over the closest share of the pairs, Chetverikov 2002.
  kAnisotropicIcp,         ///< A-ICP: each point with its own covariance, Maier-Hein 2012.
  kTrimmedAnisotropicIcp,  ///< The same over the closest share of the pairs.
  kField,                  ///< Ours: point-to-plane Gauss-Newton on the skin's distance field.
};

/// "icp", "trimmed-icp", "anisotropic-icp", "trimmed-anisotropic-icp", "field". None for another
/// word.
[[nodiscard]] std::optional<RegistrationMethod> parse_registration_method(std::string_view name);
[[nodiscard]] std::string_view to_string(RegistrationMethod method);

/// How far the start pose may be off.
enum class StartQuality : std::uint8_t {
  kRough,    ///< A landmark start, a placement, a perturbed truth: up to 30 mm / 20 deg.
  kTracked,  ///< The last frame's pose: about 5 mm / 2 deg.
};

enum class RegistrationStatus : std::uint8_t {
  kConverged,
  kMaxIterations,
  kTooFewPairs,
  kDegenerate,  ///< The data leaves a direction open: the start's word was taken for it.
};

/// A motion of the pose that the data does not fix.
struct OpenDirection {
  /// A turn about the information's pivot and a shift with it, frame fixed, of such a size that the
  /// points move by about 1 mm, root mean square.
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
  double sigma_mm = 0.0;  ///< Standard deviation along it by the data alone.
};

struct RegistrationResult {
  Eigen::Isometry3d fixed_from_moving = Eigen::Isometry3d::Identity();
  RegistrationStatus status = RegistrationStatus::kMaxIterations;
  double rms_distance_mm =
      0.0;  ///< Residual over the pairs used. The paper calls it FRE; it is no FRE.
  double explained_fraction =
      0.0;  ///< Share of the moving points within 5 mm of the fixed surface, 0..1.
  /// Share of them farther than that below it: the camera cannot see through skin, so there pose or
  /// CT is wrong. Of kField.
  double seen_through_fraction = 0.0;
  int num_pairs = 0;
  int num_iterations = 0;                           ///< Steps done.
  std::optional<PoseInformation> information = {};  ///< Of methods that have one: kField.
  std::vector<OpenDirection> open_directions = {};  ///< The widest first; of kField.
};

struct RegistrationOptions {
  RegistrationMethod method = RegistrationMethod::kField;
  int max_iterations = 200;  ///< >= 1. The paper's.
  double convergence_threshold =
      1e-5;              ///< ICP: stop when the residual improves by less, relative. The paper's.
  double overlap = 0.9;  ///< Trimmed ICP: share of pairs kept. (0, 1]. The paper's.
  /// Where the ICP family runs: "cpu", "opencl" (the first OpenCL device), or a part of an OpenCL
  /// device's name. kField runs on the CPU only.
  std::string device = "cpu";

  [[nodiscard]] Result<void> check() const;
};

/// Brings the camera's surface onto the CT skin from a start pose nearby.
class FineRegistration {
 public:
  virtual ~FineRegistration() = default;

  /// @param moving  Points and normals of the camera's surface, mm, in the camera's own frame: the
  /// camera
  ///                is at its origin (visibility and the noise model rely on it).
  /// @return A pose that did not converge is a result, not an error.
  /// @errors kInvalidArgument: NaN in the start pose or the points, no normals where the method
  /// needs them.
  /// @threads Reentrant. The same result for any number of threads.
  [[nodiscard]] virtual Result<RegistrationResult> align(
      const PointCloud& moving,
      const Eigen::Isometry3d& fixed_from_moving_init,
      StartQuality start) const = 0;

  /// Where it runs at present: "cpu", or an OpenCL device's name.
  [[nodiscard]] virtual std::string device_name() const { return "cpu"; }
};

/// @param fixed  Shared, never changed.
/// Where there is no OpenCL at all, a method that was to run on it runs on the CPU, with a warning.
/// @errors kInvalidArgument: bad options, an empty surface, no field where the method needs one, a
///         device that the method does not run on, a device's name that fits none.
[[nodiscard]] Result<std::unique_ptr<FineRegistration>> make_fine_registration(
    std::shared_ptr<const FixedSurface> fixed, const RegistrationOptions& options);

}  // namespace mor
