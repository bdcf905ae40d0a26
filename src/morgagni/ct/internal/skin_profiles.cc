// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/skin_profiles.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <tbb/parallel_for.h>

#include "morgagni/ct/internal/volume_sample.h"

namespace mor::internal {
namespace {

/// The way inwards is seen from what lies within this distance.
constexpr double kFacingMm = 5.0;
constexpr double kFacingStepMm = 1.2;
constexpr float kFacingAlike = 0.7F;  ///< Cosine.
/// So many surface voxels of a cell are looked at.
constexpr std::size_t kMostPerCell = 5;
constexpr double kAirHu = -1000.0;

/// The body goes on beyond the scan's ends, not beyond its sides.
double hu_at(const Volume& volume, Eigen::Vector3d mm) {
  mm.z() = std::clamp(mm.z(), 0.0, (volume.size[2] - 1) * volume.spacing_mm.z());
  return sampled_hu(volume, mm).value_or(kAirHu);
}

/// A ball of voxels around a place, as rows along x.
class Facing {
 public:
  explicit Facing(const Volume& volume) : size_(volume.size), spacing_mm_(volume.spacing_mm) {
    const Eigen::Array3i reach = (kFacingMm / spacing_mm_.array()).cast<int>();
    const Eigen::Array3i stride = (kFacingStepMm / spacing_mm_.array()).cast<int>().max(1);
    for (int dz = -reach.z(); dz <= reach.z(); dz += stride.z()) {
      for (int dy = -reach.y(); dy <= reach.y(); dy += stride.y()) {
        Row row = {{}, dy, dz};
        for (int dx = -reach.x(); dx <= reach.x(); dx += stride.x()) {
          const Eigen::Vector3d offset = Eigen::Vector3d(dx, dy, dz).cwiseProduct(spacing_mm_);
          if (offset.squaredNorm() <= kFacingMm * kFacingMm) row.dx.push_back(dx);
        }
        rows_.push_back(std::move(row));
      }
    }
  }

  /// From the middle of the air around a voxel to that of the solid.
  [[nodiscard]] std::optional<Eigen::Vector3d> inwards(const BitMask& solid,
                                                       const Eigen::Vector3i& middle) const {
    Eigen::Vector3i sum = Eigen::Vector3i::Zero();
    for (const Row& row : rows_) {
      // The scan's end is no surface.
      const int z = std::clamp(middle.z() + row.dz, 0, size_[2] - 1);
      const int y = middle.y() + row.dy;
      int surplus = -static_cast<int>(row.dx.size());  // Of solid over air.
      if (y >= 0 && y < size_[1]) {
        for (const int dx : row.dx) {
          const int x = middle.x() + dx;
          const int is_solid = x >= 0 && x < size_[0] && solid.test(x, y, z) ? 1 : 0;
          surplus += 2 * is_solid;
          sum.x() += 2 * is_solid * dx;  // Those of all cancel out.
        }
      }
      sum.y() += surplus * row.dy;
      sum.z() += surplus * row.dz;
    }
    if (sum.isZero()) return std::nullopt;
    return sum.cast<double>().cwiseProduct(spacing_mm_).normalized();
  }

 private:
  struct Row {
    std::vector<int> dx;
    int dy = 0;
    int dz = 0;
  };

  std::array<int, 3> size_;
  Eigen::Vector3d spacing_mm_;
  std::vector<Row> rows_;
};

/// How far inwards of a surface voxel the edge is crossed.
std::optional<double> crossing_mm(const Volume& volume,
                                  const Eigen::Vector3d& place_mm,
                                  const Eigen::Vector3d& inwards,
                                  double edge_hu) {
  constexpr double kSeekMm = 0.25;
  constexpr double kReachMm = 2.0;
  double before_hu = hu_at(volume, place_mm - kReachMm * inwards);
  for (double mm = kSeekMm - kReachMm; mm < kReachMm; mm += kSeekMm) {
    const double hu = hu_at(volume, place_mm + mm * inwards);
    if (before_hu < edge_hu && hu >= edge_hu)
      return mm - kSeekMm * (hu - edge_hu) / (hu - before_hu);
    before_hu = hu;
  }
  return std::nullopt;
}

SkinProfile profile_of(const std::vector<std::array<int, 3>>& voxels,
                       const Volume& volume,
                       const BitMask& solid,
                       const Facing& facing,
                       double edge_hu) {
  const auto place_of = [&](const std::array<int, 3>& voxel) -> Eigen::Vector3d {
    return Eigen::Vector3d(voxel[0], voxel[1], voxel[2]).cwiseProduct(volume.spacing_mm);
  };
  Eigen::Vector3d middle_mm = Eigen::Vector3d::Zero();
  for (const auto& voxel : voxels) middle_mm += place_of(voxel);
  middle_mm /= static_cast<double>(voxels.size());
  SkinProfile profile;
  profile.place_mm = middle_mm.cast<float>();
  const auto inwards = facing.inwards(solid, volume.nearest_voxel(middle_mm));
  if (!inwards) return profile;
  profile.inwards = inwards->cast<float>();
  const std::size_t stride = (voxels.size() + kMostPerCell - 1) / kMostPerCell;
  int num = 0;
  for (std::size_t i = 0; i < voxels.size(); i += stride) {
    const Eigen::Vector3d place = place_of(voxels[i]);
    const auto zero_mm = crossing_mm(volume, place, *inwards, edge_hu);
    if (!zero_mm) continue;
    ++num;
    for (int k = 0; k < SkinProfile::kNum; ++k) {
      const double mm = *zero_mm + (k - SkinProfile::kZero) * SkinProfile::kStepMm;
      profile.hu[static_cast<std::size_t>(k)] +=
          static_cast<float>(hu_at(volume, place + mm * *inwards));
    }
  }
  if (num == 0) return profile;
  for (float& hu : profile.hu) hu /= static_cast<float>(num);
  // A surface voxel stands for as much surface as it has across the direction it faces most.
  const Eigen::Vector3d face_mm2 = volume.spacing_mm.prod() * volume.spacing_mm.cwiseInverse();
  profile.area_mm2 = static_cast<float>(static_cast<double>(voxels.size()) /
                                        inwards->cwiseAbs().cwiseQuotient(face_mm2).maxCoeff());
  return profile;
}

}  // namespace

SkinProfiles::SkinProfiles(const Volume& volume, const BitMask& solid, double edge_hu) {
  const auto cells = sorted_surface(volume, solid);
  profiles_.resize(cells.size());
  const Facing facing(volume);
  tbb::parallel_for(std::size_t{0}, cells.size(), [&](std::size_t i) {
    profiles_[i] = profile_of(cells[i], volume, solid, facing, edge_hu);
    if (profiles_[i].area_mm2 <= 0.0F) at_[place_of(cells_[i])] = -1;
  });
  smooth();
}

std::vector<SkinProfiles::Voxels> SkinProfiles::sorted_surface(const Volume& volume,
                                                               const BitMask& solid) {
  const Eigen::Vector3d cells_per_voxel = volume.spacing_mm / kCellMm;
  for (std::size_t axis = 0; axis < 3; ++axis)
    size_[axis] =
        static_cast<int>(volume.size[axis] * cells_per_voxel[static_cast<Eigen::Index>(axis)]) + 1;
  at_.assign(static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]) *
                 static_cast<std::size_t>(size_[2]),
             -1);
  BitMask surface = solid;
  surface.subtract(eroded(solid, 1.0, Eigen::Vector3d::Ones()));
  std::vector<Voxels> cells;
  for_each_voxel(surface, [&](const std::array<int, 3>& voxel) {
    Cell cell{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      cell[axis] = static_cast<int>(voxel[axis] * cells_per_voxel[static_cast<Eigen::Index>(axis)]);
    auto& number = at_[place_of(cell)];
    if (number < 0) {
      number = static_cast<std::int32_t>(cells.size());
      cells.emplace_back();
      cells_.push_back(cell);
    }
    cells[static_cast<std::size_t>(number)].push_back(voxel);
  });
  return cells;
}

std::size_t SkinProfiles::place_of(const Cell& cell) const {
  return (static_cast<std::size_t>(cell[2]) * static_cast<std::size_t>(size_[1]) +
          static_cast<std::size_t>(cell[1])) *
             static_cast<std::size_t>(size_[0]) +
         static_cast<std::size_t>(cell[0]);
}

std::int32_t SkinProfiles::at(const Cell& cell) const {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (cell[axis] < 0 || cell[axis] >= size_[axis]) return -1;
  return at_[place_of(cell)];
}

std::vector<std::size_t> SkinProfiles::beside(std::size_t profile) const {
  constexpr std::size_t kMost = 26;
  std::vector<std::size_t> found;
  found.reserve(kMost);
  for_each_near(cells_[profile], 1, [&](std::size_t i) {
    if (i != profile) found.push_back(i);
  });
  return found;
}

double SkinProfiles::area_mm2(const std::vector<std::size_t>& profiles) const {
  double sum = 0.0;
  for (const std::size_t i : profiles) sum += profiles_[i].area_mm2;
  return sum;
}

SkinProfiles::Cell SkinProfiles::cell_of(const Eigen::Vector3f& place_mm) {
  const Eigen::Vector3i cell = (place_mm / static_cast<float>(kCellMm)).cast<int>();
  return {cell.x(), cell.y(), cell.z()};
}

std::vector<std::size_t> SkinProfiles::near(const Cell& cell) const {
  constexpr int kReach = 2;
  std::vector<std::size_t> found;
  for_each_near(cell, kReach, [&](std::size_t i) { found.push_back(i); });
  return found;
}

BitMask SkinProfiles::voxels_of(const std::vector<std::size_t>& profiles,
                                const Volume& volume) const {
  BitMask voxels(volume.size);
  for (const std::size_t i : profiles) {
    std::array<int, 3> low{};
    std::array<int, 3> high{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double per_voxel = kCellMm / volume.spacing_mm[static_cast<Eigen::Index>(axis)];
      const int begin = cells_[i][axis];
      low[axis] = std::min(volume.size[axis], static_cast<int>(std::ceil(begin * per_voxel)));
      high[axis] =
          std::min(volume.size[axis], static_cast<int>(std::ceil((begin + 1) * per_voxel)));
    }
    for (int z = low[2]; z < high[2]; ++z)
      for (int y = low[1]; y < high[1]; ++y) voxels.set_run(y, z, low[0], high[0]);
  }
  return voxels;
}

void SkinProfiles::smooth() {
  const auto seen = profiles_;
  tbb::parallel_for(std::size_t{0}, seen.size(), [&](std::size_t i) {
    if (seen[i].area_mm2 <= 0.0F) return;
    float weight = seen[i].area_mm2;
    auto sum = seen[i].hu;
    for (float& hu : sum) hu *= weight;
    for (const std::size_t k : beside(i)) {
      if (seen[k].inwards.dot(seen[i].inwards) < kFacingAlike) continue;
      for (std::size_t step = 0; step < sum.size(); ++step)
        sum[step] += seen[k].area_mm2 * seen[k].hu[step];
      weight += seen[k].area_mm2;
    }
    for (float& hu : sum) hu /= weight;
    profiles_[i].hu = sum;
  });
}

NearProfiles::NearProfiles(const SkinProfiles& profiles, std::vector<std::size_t> near)
    : near_(std::move(near)) {
  const auto num = static_cast<Eigen::Index>(near_.size());
  places_mm_.resize(num, 3);
  inwards_.resize(num, 3);
  for (Eigen::Index k = 0; k < num; ++k) {
    const SkinProfile& profile = profiles.all()[near_[static_cast<std::size_t>(k)]];
    places_mm_.row(k) = profile.place_mm.transpose();
    inwards_.row(k) = profile.inwards.transpose();
  }
}

void NearProfiles::look_from(const Eigen::Vector3f& place_mm) {
  const auto off_x = place_mm.x() - places_mm_.col(0);
  const auto off_y = place_mm.y() - places_mm_.col(1);
  const auto off_z = place_mm.z() - places_mm_.col(2);
  off_sq_mm2_ = off_x.square() + off_y.square() + off_z.square();
  through_mm_ = off_x * inwards_.col(0) + off_y * inwards_.col(1) + off_z * inwards_.col(2);
}

std::optional<std::size_t> NearProfiles::nearest() const {
  std::optional<std::size_t> found;
  float least = 1e9F;
  for (std::size_t k = 0; k < near_.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    // Depth counts half: a place lies beneath the surface that it is across from.
    const float off = off_sq_mm2_[i] - 0.5F * through_mm_[i] * through_mm_[i];
    if (off >= least) continue;
    least = off;
    found = near_[k];
  }
  return found;
}

std::optional<std::size_t> NearProfiles::over(float beside_mm,
                                              const std::vector<float>& thick_mm) const {
  constexpr float kOutsideMm = 2.0F;
  constexpr float kBeneathMm = 0.7F;
  std::optional<std::size_t> found;
  float least = beside_mm * beside_mm;
  for (std::size_t k = 0; k < near_.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const float beside = off_sq_mm2_[i] - through_mm_[i] * through_mm_[i];
    const float thick = thick_mm[near_[k]];
    if (beside >= least || thick <= 0.0F || through_mm_[i] < -kOutsideMm ||
        through_mm_[i] > thick + kBeneathMm)
      continue;
    least = beside;
    found = near_[k];
  }
  return found;
}

}  // namespace mor::internal
