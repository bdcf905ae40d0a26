// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/calibration/skin_readings.h"
#include "morgagni/geometry/pinhole_camera.h"

namespace mor::internal {

/// What the body lies on: a plane that all views of a motion share, frame ct, and how far its top
/// lies above that plane: a height and a tilt of any size and a small smooth unevenness, bilinear
/// between control points of a lattice in the plane.
class TableModel {
 public:
  static constexpr std::size_t kNumTouched = 4;

  /// The largest plane under the body that holds a good share of what lies beside the body.
  /// @param body_mm  The body's middle. None: no such plane.
  [[nodiscard]] static std::optional<TableModel> find(const std::vector<SensedSkin>& views,
                                                      const PinholeCamera& camera,
                                                      const Eigen::Vector3d& body_mm);

  [[nodiscard]] const Eigen::Vector3d& normal() const { return normal_; }  ///< To the body.
  [[nodiscard]] std::size_t size() const { return nodes_.size(); }

  /// What an ideal camera would read in a block; see ExpectedReading. Blurred as the skin is.
  [[nodiscard]] ExpectedReading expected(const SkinReading& reading,
                                         const PinholeCamera& camera,
                                         const Eigen::Isometry3d& ct_from_depth) const;

  [[nodiscard]] Eigen::MatrixXd prior_covariance() const;

  /// The control points around a place, in ascending order, and their shares.
  /// @return False where none was read when the table was found.
  bool weights(const Eigen::Vector3d& ct_mm,
               std::span<std::uint16_t, kNumTouched> index,
               std::span<float, kNumTouched> share) const;

 private:
  using Node = std::pair<int, int>;

  void set_plane(const Eigen::Vector3d& normal, double offset_mm);
  void touch(const std::vector<Eigen::Vector3d>& places_mm);
  [[nodiscard]] Eigen::Vector2d on_plane(const Eigen::Vector3d& ct_mm) const;

  Eigen::Vector3d normal_ = Eigen::Vector3d::UnitZ();
  double offset_mm_ = 0.0;
  Eigen::Matrix<double, 2, 3> axes_ = Eigen::Matrix<double, 2, 3>::Zero();
  Eigen::Vector2d middle_ = Eigen::Vector2d::Zero();  ///< Of the control points.
  std::map<Node, std::uint16_t> nodes_;               ///< By row, then column.
};

}  // namespace mor::internal
