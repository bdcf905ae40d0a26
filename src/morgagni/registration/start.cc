// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/start.h"

#include <cmath>

#include <spdlog/fmt/fmt.h>

#include "morgagni/geometry/rigid.h"

namespace mor {
namespace {

/// Where the camera looks, in the CT (LPS: +x left, +y back, +z head), to see a side of the body.
Eigen::Vector3d viewing_direction(BodySide side) {
  switch (side) {
    case BodySide::kAnterior:
      return Eigen::Vector3d::UnitY();
    case BodySide::kPosterior:
      return -Eigen::Vector3d::UnitY();
    case BodySide::kLeft:
      return -Eigen::Vector3d::UnitX();
    case BodySide::kRight:
      return Eigen::Vector3d::UnitX();
  }
  return Eigen::Vector3d::UnitY();
}

}  // namespace

std::optional<BodySide> parse_body_side(std::string_view name) {
  if (name == "anterior") return BodySide::kAnterior;
  if (name == "posterior") return BodySide::kPosterior;
  if (name == "left") return BodySide::kLeft;
  if (name == "right") return BodySide::kRight;
  return std::nullopt;
}

Result<void> PlacementOptions::check() const {
  if (!(distance_mm >= kMinDistanceMm && distance_mm <= kMaxDistanceMm)) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("distance_mm must be in [{}, {}], got {}",
                                  kMinDistanceMm,
                                  kMaxDistanceMm,
                                  distance_mm));
  }
  if (!std::isfinite(roll_rad)) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("roll_rad must be finite, got {}", roll_rad));
  }
  return {};
}

Result<LandmarkStart> start_from_landmarks(const std::vector<LandmarkPair>& pairs) {
  std::vector<Eigen::Vector3d> ct;
  std::vector<Eigen::Vector3d> depth;
  for (const auto& pair : pairs) {
    ct.push_back(pair.ct);
    depth.push_back(pair.depth);
  }
  LandmarkStart start;
  MOR_TRY(start.ct_from_depth, fit_rigid(ct, depth));
  double sum_sq_mm2 = 0.0;
  for (const auto& pair : pairs) {
    start.residuals_mm.push_back((start.ct_from_depth * pair.depth - pair.ct).norm());
    sum_sq_mm2 += start.residuals_mm.back() * start.residuals_mm.back();
  }
  start.fre_mm = std::sqrt(sum_sq_mm2 / static_cast<double>(pairs.size()));
  return start;
}

Result<Eigen::Isometry3d> place_in_front_of_camera(const Eigen::AlignedBox3f& bounds,
                                                   const PlacementOptions& options) {
  MOR_CHECK(options.check());
  if (bounds.isEmpty() || !bounds.min().allFinite() || !bounds.max().allFinite()) {
    return make_error(ErrorCode::kInvalidArgument,
                      "a body can be placed only when its bounds are known and finite");
  }
  const Eigen::Vector3d z_axis = viewing_direction(options.side);
  const Eigen::Vector3d y_axis = -Eigen::Vector3d::UnitZ();  // Down in the picture: to the feet.
  Eigen::Isometry3d ct_from_depth = Eigen::Isometry3d::Identity();
  ct_from_depth.linear().col(0) = y_axis.cross(z_axis);
  ct_from_depth.linear().col(1) = y_axis;
  ct_from_depth.linear().col(2) = z_axis;
  ct_from_depth.linear() *=
      Eigen::AngleAxisd(options.roll_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  // The axis goes through the centre of the bounds and enters them half their depth before it.
  const double half_depth_mm = 0.5 * std::abs(bounds.sizes().cast<double>().dot(z_axis));
  ct_from_depth.translation() =
      bounds.center().cast<double>() - (options.distance_mm + half_depth_mm) * z_axis;
  return ct_from_depth;
}

}  // namespace mor
