// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/uncovering.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include <tbb/parallel_for.h>

#include "morgagni/ct/internal/foreign_matter.h"
#include "morgagni/ct/internal/peeling.h"

namespace mor::internal {
namespace {

constexpr double kAirHu = -1000.0;
constexpr double kMostAirHu = -700.0;
/// Skin is that dense at most; what is denser beneath it is bone.
constexpr double kMostSkinHu = 60.0;
/// Beneath a denser cover, where the skin itself holds some of it and what lies deeper is fat or
/// bone.
constexpr double kLeastUnderDenseHu = 20.0;
constexpr double kMostUnderDenseHu = 35.0;
/// What is less dense is no skin, but more of the cover or air.
constexpr double kLeastSkinHu = -120.0;
/// Skin is at least so much denser, or less dense, than what it can be told from.
constexpr double kLeastStepHu = 60.0;
/// Where the step is smaller, noise would place the skin: neighbours are looked at, too.
constexpr double kNoisyStepHu = 250.0;
/// Skin lies within this distance of the cover that touches it.
constexpr double kSkinMm = 2.2;
/// A cover's HU is its mean over about three of these.
constexpr double kCellMm = 5.0;

/// What a cover's HU is, from place to place.
class CoverHu {
 public:
  explicit CoverHu(double hu) : everywhere_hu_(hu) {}

  CoverHu(const Volume& volume, const BitMask& cover) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double spacing_mm = volume.spacing_mm[static_cast<Eigen::Index>(axis)];
      voxels_[axis] = std::max(1, static_cast<int>(std::lround(kCellMm / spacing_mm)));
      size_[axis] = (volume.size[axis] + voxels_[axis] - 1) / voxels_[axis];
    }
    cells_.resize(index(0, 0, size_[2]));
    // The outermost voxels hold skin or air, too; but a thin cover has no others.
    const BitMask inner = eroded(cover, 1.0, Eigen::Vector3d::Ones());
    tbb::parallel_for(0, size_[2], [&](int cell_z) {
      const int end_z = std::min(volume.size[2], (cell_z + 1) * voxels_[2]);
      for (int z = cell_z * voxels_[2]; z < end_z; ++z) {
        add_slice(volume, cover, 1, z);
        add_slice(volume, inner, kInnerWeight, z);
      }
    });
  }

  [[nodiscard]] std::optional<double> at(int x, int y, int z) const {
    if (everywhere_hu_) return everywhere_hu_;
    const std::array<int, 3> middle = {x / voxels_[0], y / voxels_[1], z / voxels_[2]};
    Cell sum;
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const int cx = middle[0] + dx;
          const int cy = middle[1] + dy;
          const int cz = middle[2] + dz;
          if (cx < 0 || cy < 0 || cz < 0 || cx >= size_[0] || cy >= size_[1] || cz >= size_[2])
            continue;
          const Cell& cell = cells_[index(cx, cy, cz)];
          sum.hu += cell.hu;
          sum.weight += cell.weight;
        }
      }
    }
    if (sum.weight == 0) return std::nullopt;
    return static_cast<double>(sum.hu) / static_cast<double>(sum.weight);
  }

 private:
  static constexpr int kInnerWeight = 50;
  struct Cell {
    std::int64_t hu = 0;
    std::int64_t weight = 0;
  };

  void add_slice(const Volume& volume, const BitMask& mask, int weight, int z) {
    for (int y = 0; y < volume.size[1]; ++y) {
      const auto row = mask.row(y, z);
      if (std::all_of(row.begin(), row.end(), [](auto word) { return word == 0; })) continue;
      for (int x = 0; x < volume.size[0]; ++x) {
        if (!mask.test(x, y, z)) continue;
        Cell& cell = cells_[index(x / voxels_[0], y / voxels_[1], z / voxels_[2])];
        cell.hu += weight * volume.hu[volume.index(x, y, z)];
        cell.weight += weight;
      }
    }
  }

  [[nodiscard]] std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size_[1]) +
            static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size_[0]) +
           static_cast<std::size_t>(x);
  }

  std::optional<double> everywhere_hu_;
  std::array<int, 3> voxels_{};
  std::array<int, 3> size_{};
  std::vector<Cell> cells_;
};

/// Slices in parallel. Calls visit(x, y, z).
template <class Visit>
void visit_all(const BitMask& mask, const Visit& visit) {
  tbb::parallel_for(0, mask.size()[2], [&](int slice) {
    for_each_voxel_in_slice(
        mask, slice, [&](const std::array<int, 3>& voxel) { visit(voxel[0], voxel[1], voxel[2]); });
  });
}

class Uncovering {
 public:
  Uncovering(const Volume& volume, const BitMask& cover, std::optional<double> cover_hu)
      : volume_(volume),
        cover_(cover),
        cover_hu_(cover_hu ? CoverHu(*cover_hu) : CoverHu(volume, cover)),
        smooth_(std::make_unique_for_overwrite<std::int16_t[]>(volume.num_voxels())) {
    for (int axis = 0; axis < 3; ++axis)
      reach_[static_cast<std::size_t>(axis)] =
          std::max(1, static_cast<int>(std::lround(kSkinMm / volume.spacing_mm[axis])));
  }

  Volume run() {
    const Eigen::Vector3d ones = Eigen::Vector3d::Ones();
    constexpr double kBesideVoxels = 1.5;
    const BitMask beside = dilated(cover_, kBesideVoxels, ones);
    edge_ = beside;
    edge_.subtract(eroded(cover_, kBesideVoxels, ones));
    smooth_around(edge_);
    uncovered_ = known_;
    uncovered_.subtract(cover_);
    beyond_edge_ = uncovered_;
    beyond_edge_.subtract(edge_);
    Volume result = volume_;
    visit_all(cover_, [&](int x, int y, int z) {
      result.hu[result.index(x, y, z)] = static_cast<std::int16_t>(kAirHu);
    });
    visit_all(edge_, [&](int x, int y, int z) {
      const std::size_t i = result.index(x, y, z);
      if (const auto hu = bare_hu(x, y, z)) result.hu[i] = *hu;
    });
    return result;
  }

 private:
  [[nodiscard]] bool is_in(int x, int y, int z) const {
    return x >= 0 && y >= 0 && z >= 0 && x < volume_.size[0] && y < volume_.size[1] &&
           z < volume_.size[2];
  }

  /// Of a voxel, and of the six beside it as much again.
  [[nodiscard]] std::int16_t smoothed_hu(int x, int y, int z) const {
    int sum = 6 * volume_.hu[volume_.index(x, y, z)];
    int num = 6;
    const auto add = [&](int at_x, int at_y, int at_z) {
      if (!is_in(at_x, at_y, at_z)) return;
      sum += volume_.hu[volume_.index(at_x, at_y, at_z)];
      ++num;
    };
    for (const int step : {-1, 1}) {
      add(x + step, y, z);
      add(x, y + step, z);
      add(x, y, z + step);
    }
    return static_cast<std::int16_t>(sum / num);
  }

  void smooth_around(const BitMask& edge) {
    const BitMask around =
        dilated(edge, kSkinMm + 0.5 * volume_.spacing_mm.maxCoeff(), volume_.spacing_mm);
    BitMask box = dilated(around, 1.8, Eigen::Vector3d::Ones());
    visit_all(box,
              [&](int x, int y, int z) { smooth_[volume_.index(x, y, z)] = smoothed_hu(x, y, z); });
    known_ = std::move(box);
  }

  /// The densest around here within `skin`.
  [[nodiscard]] double skin_hu(int x, int y, int z, const BitMask& skin) const {
    const auto& size = volume_.size;
    const int first_x = std::max(0, x - reach_[0]);
    const int last_x = std::min(size[0] - 1, x + reach_[0]);
    double most_hu = kAirHu;
    for (int at_z = std::max(0, z - reach_[2]); at_z <= std::min(size[2] - 1, z + reach_[2]);
         ++at_z)
      for (int at_y = std::max(0, y - reach_[1]); at_y <= std::min(size[1] - 1, y + reach_[1]);
           ++at_y)
        for (int at_x = first_x; at_x <= last_x; ++at_x)
          if (skin.test(at_x, at_y, at_z))
            most_hu = std::max<double>(most_hu, smooth_[volume_.index(at_x, at_y, at_z)]);
    return std::min(most_hu, kMostSkinHu);
  }

  [[nodiscard]] bool touches_air(int x, int y, int z) const {
    for (const int step : {-1, 1})
      for (const auto& [dx, dy, dz] : {std::array{step, 0, 0}, {0, step, 0}, {0, 0, step}})
        if (is_in(x + dx, y + dy, z + dz) &&
            volume_.hu[volume_.index(x + dx, y + dy, z + dz)] < kMostAirHu)
          return true;
    return false;
  }

  /// None where a voxel stays what it is.
  [[nodiscard]] std::optional<std::int16_t> bare_hu(int x, int y, int z) const {
    const auto cover_hu = cover_hu_.at(x, y, z);
    if (!cover_hu) return std::nullopt;
    const bool is_cover = cover_.test(x, y, z);
    const double hu = volume_.hu[volume_.index(x, y, z)];
    if (!is_cover && (hu < kMostAirHu || touches_air(x, y, z))) return std::nullopt;
    double skin = skin_hu(x, y, z, *cover_hu > kMostSkinHu ? beyond_edge_ : uncovered_);
    if (skin < kLeastSkinHu) return std::nullopt;
    if (*cover_hu > kMostSkinHu) skin = std::clamp(skin, kLeastUnderDenseHu, kMostUnderDenseHu);
    if (std::abs(skin - *cover_hu) < kLeastStepHu) return std::nullopt;
    const double seen =
        std::abs(skin - *cover_hu) < kNoisyStepHu ? smooth_[volume_.index(x, y, z)] : hu;
    const double share = std::clamp((skin - seen) / (skin - *cover_hu), 0.0, 1.0);
    const double bare = hu - share * (*cover_hu - kAirHu);
    return static_cast<std::int16_t>(std::lround(std::clamp(bare, kAirHu, std::max(hu, skin))));
  }

  const Volume& volume_;
  const BitMask& cover_;
  CoverHu cover_hu_;
  std::unique_ptr<std::int16_t[]> smooth_;  ///< Where `known_` is.
  BitMask known_;
  BitMask edge_;         ///< Around the cover's surface, on both sides.
  BitMask uncovered_;    ///< Of `known_`.
  BitMask beyond_edge_;  ///< ... and not of `edge_`.
  std::array<int, 3> reach_{};
};

}  // namespace

Volume uncovered(const Volume& volume, const BitMask& cover, std::optional<double> cover_hu) {
  return Uncovering(volume, cover, cover_hu).run();
}

BareCt bare_ct(const Volume& volume,
               const std::vector<Eigen::Vector3d>& take_off_mm,
               const std::function<void(double)>& report) {
  constexpr double kForeignShare = 0.15;
  constexpr double kUncoveredShare = 0.25;
  const auto done = [&](double fraction) {
    if (report) report(fraction);
  };
  const auto covers = foreign_matter(volume);
  if (!covers) return {};
  done(kForeignShare);
  BareCt bare;
  Volume peeled = covers->count() > 0 ? uncovered(volume, *covers) : volume;
  done(kUncoveredShare);
  auto layers = peel(peeled, *covers, take_off_mm, [&](double fraction) {
    done(kUncoveredShare + (1.0 - kUncoveredShare) * fraction);
  });
  constexpr double kAskedMm = 6.0;  // The surface lies deeper now.
  bare.asked = dilated(layers.asked, kAskedMm, volume.spacing_mm);
  bare.unknown = dilated(layers.unknown, kSkinMm, volume.spacing_mm);
  bare.most_unknown_mm = layers.most_unknown_mm;
  bare.cover = dilated(*covers, kSkinMm, volume.spacing_mm);
  bare.tube = dilated(layers.tube, kSkinMm, volume.spacing_mm);
  bare.layer = dilated(layers.taken, kSkinMm, volume.spacing_mm);
  if (layers.found_any || covers->count() > 0) bare.volume = std::move(peeled);
  return bare;
}

}  // namespace mor::internal
