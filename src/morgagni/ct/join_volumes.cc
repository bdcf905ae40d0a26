// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/join_volumes.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <spdlog/fmt/fmt.h>
#include <tbb/parallel_for.h>

#include "morgagni/ct/import_protocol.h"
#include "morgagni/ct/internal/volume_sample.h"

namespace mor {
namespace {

constexpr std::int16_t kAirHu = -1024;
/// Slices are alike where one's voxels are at most so many times as large as the other's.
constexpr double kAlikeRatio = 1.2;
/// Of the sharper one of two unlike series: this much of its end goes over into the other.
constexpr double kSharpFeatherMm = 10.0;

/// A CT in the frame of the joined grid.
struct Part {
  const Volume& volume;
  Eigen::Isometry3d grid_from_joined;  ///< Its own mm from the joined grid's mm.

  [[nodiscard]] Eigen::Vector3d end_mm() const {
    return (Eigen::Vector3d(volume.size[0], volume.size[1], volume.size[2]).array() - 1.0)
        .matrix()
        .cwiseProduct(volume.spacing_mm);
  }
  /// From its first or last slice, whichever is nearer.
  [[nodiscard]] double from_its_ends_mm(const Eigen::Vector3d& grid_mm) const {
    return std::min(grid_mm.z(), end_mm().z() - grid_mm.z());
  }
};

Eigen::AlignedBox3d box_in(const Volume& volume, const Eigen::Isometry3d& grid_from_volume) {
  Eigen::AlignedBox3d box;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d mm;
    for (int axis = 0; axis < 3; ++axis)
      mm[axis] = (corner >> axis & 1) * (volume.size[static_cast<std::size_t>(axis)] - 1) *
                 volume.spacing_mm[axis];
    box.extend(grid_from_volume * mm);
  }
  return box;
}

/// Where the second one lies, along z only as far as all of a slice is in it: what a turned end
/// leaves is a wedge of air, through which the airways would lie open to the outside.
Eigen::AlignedBox3d whole_slices(const Volume& volume,
                                 const Eigen::Isometry3d& joined_from_volume) {
  Eigen::AlignedBox3d box = box_in(volume, joined_from_volume);
  constexpr double kAlongZ = 0.9;
  const double along_z = joined_from_volume.linear()(2, 2);
  if (std::abs(along_z) < kAlongZ) return box;
  for (int corner = 0; corner < 4; ++corner) {
    Eigen::Vector3d mm((corner & 1) * (volume.size[0] - 1) * volume.spacing_mm.x(),
                       (corner >> 1) * (volume.size[1] - 1) * volume.spacing_mm.y(),
                       0.0);
    const double one_end = (joined_from_volume * mm).z();
    mm.z() = (volume.size[2] - 1) * volume.spacing_mm.z();
    const double other_end = (joined_from_volume * mm).z();
    box.min().z() = std::max(box.min().z(), std::min(one_end, other_end));
    box.max().z() = std::min(box.max().z(), std::max(one_end, other_end));
  }
  return box;
}

/// Along the first one's axes, in step with its voxels where the whole is as fine as they are.
Result<Volume> joined_grid(const Volume& first, const Volume& second, const Part& second_part) {
  const Eigen::Matrix3d turned = second_part.grid_from_joined.linear().transpose().cwiseAbs();
  Volume grid;
  grid.description = first.description;
  for (int axis = 0; axis < 3; ++axis) {
    int along = 0;
    turned.row(axis).maxCoeff(&along);
    grid.spacing_mm[axis] = std::min(first.spacing_mm[axis], second.spacing_mm[along]);
  }
  const auto first_box = box_in(first, Eigen::Isometry3d::Identity());
  const auto box = first_box.merged(whole_slices(second, second_part.grid_from_joined.inverse()));
  Eigen::Vector3d corner;
  std::int64_t num_bytes = 2;
  for (int axis = 0; axis < 3; ++axis) {
    const double step = grid.spacing_mm[axis];
    const double before = std::floor(box.min()[axis] / step + 1e-3);
    const double behind = std::ceil(box.max()[axis] / step - 1e-3);
    corner[axis] = before * step;
    const double side = behind - before + 1.0;
    if (!(side <= kMaxVolumeSide)) {
      return make_error(ErrorCode::kInvalidArgument,
                        fmt::format("joined, the CT would have {:.0f} voxels a side, the limit is "
                                    "{}",
                                    side,
                                    kMaxVolumeSide));
    }
    grid.size[static_cast<std::size_t>(axis)] = static_cast<int>(side);
    num_bytes *= static_cast<std::int64_t>(side);
  }
  if (num_bytes > kMaxVolumeBytes) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("joined, the CT would take {} MiB, the limit is {} MiB",
                                  num_bytes >> 20,
                                  kMaxVolumeBytes >> 20));
  }
  grid.ct_from_grid = first.ct_from_grid;
  grid.ct_from_grid.translation() = first.ct_from_grid * corner;
  return grid;
}

/// Between the slabs of two CTs that do not overlap; 0 where they do.
double gap_mm(const Part& first, const Part& second) {
  const Eigen::Isometry3d first_from_second =
      first.grid_from_joined * second.grid_from_joined.inverse();
  const auto box = box_in(second.volume, first_from_second);
  return std::max({0.0, box.min().z() - first.end_mm().z(), -box.max().z()});
}

/// Share of the first where both are.
class Blend {
 public:
  Blend(const Volume& first, const Volume& second) {
    const double ratio = first.spacing_mm.prod() / second.spacing_mm.prod();
    alike_ = ratio <= kAlikeRatio && ratio >= 1.0 / kAlikeRatio;
    first_is_sharper_ = ratio < 1.0;
  }

  [[nodiscard]] double first_share(double first_from_ends_mm, double second_from_ends_mm) const {
    const double sum = first_from_ends_mm + second_from_ends_mm;
    if (alike_) return sum > 0.0 ? first_from_ends_mm / sum : 0.5;
    const double of_sharper = std::clamp(
        (first_is_sharper_ ? first_from_ends_mm : second_from_ends_mm) / kSharpFeatherMm, 0.0, 1.0);
    return first_is_sharper_ ? of_sharper : 1.0 - of_sharper;
  }

 private:
  bool alike_ = true;
  bool first_is_sharper_ = false;
};

std::int16_t joined_hu(const Part& first,
                       const Part& second,
                       const Blend& blend,
                       const Eigen::Vector3d& joined_mm) {
  const Eigen::Vector3d first_mm = first.grid_from_joined * joined_mm;
  const Eigen::Vector3d second_mm = second.grid_from_joined * joined_mm;
  const auto a = internal::sampled_hu(first.volume, first_mm);
  const auto b = internal::sampled_hu(second.volume, second_mm);
  double hu = kAirHu;
  if (a && b) {
    // Beyond its round field of view a scanner writes the least HU: there the other one measured.
    const bool only_second = *a <= kAirHu && *b > kAirHu;
    const bool only_first = *b <= kAirHu && *a > kAirHu;
    const double share =
        blend.first_share(first.from_its_ends_mm(first_mm), second.from_its_ends_mm(second_mm));
    hu = only_second ? *b : only_first ? *a : share * *a + (1.0 - share) * *b;
  } else if (a || b) {
    hu = a ? *a : *b;
  }
  return static_cast<std::int16_t>(std::lround(hu));
}

}  // namespace

Result<Volume> join_volumes(const Volume& first,
                            const Volume& second,
                            const Eigen::Isometry3d& first_from_second,
                            const Progress& progress) {
  constexpr const char* kStage = "join series";
  if (progress) progress(kStage, 0.0);
  const Eigen::Isometry3d second_from_first_grid =
      second.ct_from_grid.inverse() * first_from_second.inverse() * first.ct_from_grid;
  Part first_part = {first, Eigen::Isometry3d::Identity()};
  Part second_part = {second, second_from_first_grid};
  const double gap = gap_mm(first_part, second_part);
  const double most_gap = 1.5 * std::max(first.spacing_mm.z(), second.spacing_mm.z());
  if (gap > most_gap) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("the series lie {:.1f} mm apart along the body, more than {:.1f} mm are not "
                    "bridged",
                    gap,
                    most_gap));
  }
  MOR_TRY(Volume joined, joined_grid(first, second, second_part));
  const Eigen::Isometry3d first_from_joined = first.ct_from_grid.inverse() * joined.ct_from_grid;
  first_part.grid_from_joined = first_from_joined;
  second_part.grid_from_joined = second_from_first_grid * first_from_joined;
  const Blend blend(first, second);
  joined.hu.resize(static_cast<std::size_t>(joined.size[0]) *
                   static_cast<std::size_t>(joined.size[1]) *
                   static_cast<std::size_t>(joined.size[2]));
  tbb::parallel_for(0, joined.size[2], [&](int z) {
    for (int y = 0; y < joined.size[1]; ++y) {
      for (int x = 0; x < joined.size[0]; ++x) {
        const Eigen::Vector3d mm = Eigen::Vector3d(x, y, z).cwiseProduct(joined.spacing_mm);
        joined.hu[joined.index(x, y, z)] = joined_hu(first_part, second_part, blend, mm);
      }
    }
  });
  if (progress) progress(kStage, 1.0);
  return joined;
}

}  // namespace mor
