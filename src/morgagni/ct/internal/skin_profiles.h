// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "morgagni/ct/internal/bit_mask.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// What the CT shows on the way from the air into a body, at one place of its surface.
struct SkinProfile {
  static constexpr double kStepMm = 0.5;
  static constexpr double kEdgeHu = -300.0;  ///< Halfway from air to cloth or skin.
  static constexpr int kZero = 8;  ///< Of `hu`: where the edge is crossed; before it is air.
  static constexpr int kNum = 33;

  Eigen::Vector3f place_mm = Eigen::Vector3f::Zero();  ///< On the grid: voxel times spacing.
  Eigen::Vector3f inwards = Eigen::Vector3f::Zero();   ///< Of length 1.
  std::array<float, kNum> hu{};
  float area_mm2 = 0.0F;  ///< 0: nothing could be seen here.

  /// @param step  From the crossing, inwards.
  [[nodiscard]] float at(int step) const { return hu[static_cast<std::size_t>(kZero + step)]; }
};

/// Profiles of a surface, one in each cell of 3 mm: each the mean of what was seen in its own and
/// the neighbouring cells whose surface faces the same way, so that noise does not count.
/// @cost About 0.1 s of CPU for a head.
class SkinProfiles {
 public:
  /// @param edge_hu  Where the air ends: SkinProfile::kZero of each.
  SkinProfiles(const Volume& volume, const BitMask& solid, double edge_hu = SkinProfile::kEdgeHu);

  [[nodiscard]] const std::vector<SkinProfile>& all() const { return profiles_; }
  /// Those of the cells around one.
  [[nodiscard]] std::vector<std::size_t> beside(std::size_t profile) const;
  /// Those that `joins(from, to)` leads to from one, and are not seen before.
  template <class Joins>
  [[nodiscard]] std::vector<std::size_t> region(std::size_t start,
                                                std::vector<char>& seen,
                                                const Joins& joins) const {
    std::vector<std::size_t> region = {start};
    seen[start] = 1;
    for (std::size_t next = 0; next < region.size(); ++next) {
      for (const std::size_t k : beside(region[next])) {
        if (seen[k] != 0 || !joins(region[next], k)) continue;
        seen[k] = 1;
        region.push_back(k);
      }
    }
    return region;
  }
  [[nodiscard]] double area_mm2(const std::vector<std::size_t>& profiles) const;
  /// Calls visit(profile) for those whose surface lies within a distance of a place.
  template <class Visit>
  void for_each_within(const Eigen::Vector3f& place_mm,
                       float distance_mm,
                       const Visit& visit) const {
    for_each_near(cell_of(place_mm), static_cast<int>(distance_mm / kCellMm) + 1, [&](auto i) {
      if ((profiles_[i].place_mm - place_mm).norm() <= distance_mm) visit(i);
    });
  }
  using Cell = std::array<int, 3>;
  /// The cell that a place lies in; there may be none of the surface.
  [[nodiscard]] static Cell cell_of(const Eigen::Vector3f& place_mm);
  /// Those of a cell and of the cells up to two away.
  [[nodiscard]] std::vector<std::size_t> near(const Cell& cell) const;
  /// The voxels of the cells of some profiles.
  [[nodiscard]] BitMask voxels_of(const std::vector<std::size_t>& profiles,
                                  const Volume& volume) const;

 private:
  static constexpr double kCellMm = 3.0;
  using Voxels = std::vector<std::array<int, 3>>;

  std::vector<Voxels> sorted_surface(const Volume& volume, const BitMask& solid);
  template <class Visit>
  void for_each_near(const Cell& cell, int reach, const Visit& visit) const {
    for (int dz = -reach; dz <= reach; ++dz) {
      for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
          const auto number = at({cell[0] + dx, cell[1] + dy, cell[2] + dz});
          if (number >= 0) visit(static_cast<std::size_t>(number));
        }
      }
    }
  }
  [[nodiscard]] std::size_t place_of(const Cell& cell) const;
  [[nodiscard]] std::int32_t at(const Cell& cell) const;
  void smooth();

  std::array<int, 3> size_{};
  std::vector<std::int32_t> at_;  ///< The profile of each cell; -1: no surface is seen there.
  std::vector<Cell> cells_;       ///< Of each profile.
  std::vector<SkinProfile> profiles_;
};

/// Profiles near to many places, which are looked from one after the other.
class NearProfiles {
 public:
  NearProfiles(const SkinProfiles& profiles, std::vector<std::size_t> near);

  void look_from(const Eigen::Vector3f& place_mm);
  /// The one whose surface is nearest.
  [[nodiscard]] std::optional<std::size_t> nearest() const;
  /// Of those over the place, no farther beside it than this and no higher over it than their
  /// `thick_mm`, the one least beside it.
  [[nodiscard]] std::optional<std::size_t> over(float beside_mm,
                                                const std::vector<float>& thick_mm) const;

 private:
  std::vector<std::size_t> near_;
  Eigen::ArrayX3f places_mm_;
  Eigen::ArrayX3f inwards_;
  Eigen::ArrayXf off_sq_mm2_;  ///< From each profile to the place.
  Eigen::ArrayXf through_mm_;  ///< The same, inwards.
};

}  // namespace mor::internal
