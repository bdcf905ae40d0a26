// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/doubtful_skin.h"

#include <algorithm>
#include <array>
#include <utility>

#include "morgagni/ct/internal/components.h"

namespace mor::internal {
namespace {

/// Surface within twice this distance is one stretch.
constexpr double kJoinedMm = 2.2;
/// Of 19 of 20 places (docs/prepare.md).
constexpr double kUnderCoverMm = 1.5;
constexpr double kUnderLayerMm = 3.0;
constexpr double kLeastCm2 = 3.0;
constexpr std::size_t kMostStretches = 20;

std::string place_of(const Eigen::Vector3d& offset_mm) {
  int axis = 0;
  offset_mm.cwiseAbs().maxCoeff(&axis);
  constexpr std::array<std::array<const char*, 2>, 3> kWords = {
      {{"right", "left"}, {"front", "back"}, {"lower end", "upper end"}}};
  return kWords[static_cast<std::size_t>(axis)][offset_mm[axis] > 0.0 ? 1 : 0];
}

/// The surface of the body, its area and middle.
class Surface {
 public:
  Surface(const BitMask& body, const Volume& volume) : body_(body), volume_(volume), voxels_(body) {
    voxels_.subtract(eroded(body, 1.0, Eigen::Vector3d::Ones()));
    const Components parts(body);
    const auto& part = parts.parts()[parts.largest()];
    middle_mm_ = place_mm({(part.low_x + part.high_x) / 2,
                           (part.low_y + part.high_y) / 2,
                           (part.low_z + part.high_z) / 2});
  }

  [[nodiscard]] BitMask in(BitMask mask) const {
    mask &= voxels_;
    return mask;
  }

  /// Adds the stretches of `skin`; its small ones are left out of it.
  void add(BitMask skin, SkinDoubt::Why why, double up_to_mm, DoubtfulSkin& found) const {
    const BitMask joined = dilated(skin, kJoinedMm, volume_.spacing_mm);
    const Components parts(joined);
    std::vector<Sum> sums(parts.parts().size());
    for_each_voxel(skin, [&](const std::array<int, 3>& voxel) {
      Sum& sum = sums[*parts.part_at(voxel)];
      const double area_mm2 = shown_mm2(voxel);
      sum.area_mm2 += area_mm2;
      sum.place_mm += area_mm2 * place_mm(voxel);
    });
    std::vector<Eigen::Vector3d> middles(sums.size());
    std::vector<double> nearest(sums.size(), 1e18);
    for (std::size_t i = 0; i < sums.size(); ++i)
      middles[i] = sums[i].place_mm / std::max(1e-9, sums[i].area_mm2);
    std::vector<Eigen::Vector3d> seen(sums.size());
    for_each_voxel(skin, [&](const std::array<int, 3>& voxel) {
      const std::size_t i = *parts.part_at(voxel);
      const double off = (place_mm(voxel) - middles[i]).squaredNorm();
      if (off < nearest[i]) {
        nearest[i] = off;
        seen[i] = place_mm(voxel);
      }
    });
    const auto is_large = [&](std::size_t i) { return sums[i].area_mm2 >= 100.0 * kLeastCm2; };
    for (std::size_t i = 0; i < sums.size(); ++i)
      if (is_large(i))
        found.stretches.push_back(
            {why, place_of(middles[i] - middle_mm_), 0.01 * sums[i].area_mm2, up_to_mm, seen[i]});
    skin &= parts.select(is_large);
    found.where |= skin;
  }

 private:
  struct Sum {
    double area_mm2 = 0.0;
    Eigen::Vector3d place_mm = Eigen::Vector3d::Zero();
  };

  [[nodiscard]] Eigen::Vector3d place_mm(const std::array<int, 3>& voxel) const {
    return volume_.ct_from_grid *
           Eigen::Vector3d(voxel[0], voxel[1], voxel[2]).cwiseProduct(volume_.spacing_mm);
  }

  /// As much surface as a voxel shows, by its sides that are open.
  [[nodiscard]] double shown_mm2(const std::array<int, 3>& voxel) const {
    const Eigen::Vector3d side_mm2 = volume_.spacing_mm.prod() * volume_.spacing_mm.cwiseInverse();
    Eigen::Vector3d open_mm2 = Eigen::Vector3d::Zero();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const int step : {-1, 1}) {
        auto beside = voxel;
        beside[axis] += step;
        if (beside[axis] < 0 || beside[axis] >= volume_.size[axis]) continue;
        const auto i = static_cast<Eigen::Index>(axis);
        if (!body_.test(beside[0], beside[1], beside[2])) open_mm2[i] = side_mm2[i];
      }
    }
    return open_mm2.norm();
  }

  const BitMask& body_;
  const Volume& volume_;
  BitMask voxels_;
  Eigen::Vector3d middle_mm_;
};

}  // namespace

DoubtfulSkin doubtful_skin(const BareCt& bare, const BitMask& body, const Volume& volume) {
  DoubtfulSkin found = {{}, BitMask(volume.size)};
  if (bare.cover.size() != volume.size) return found;
  const Surface surface(body, volume);
  BitMask layer = surface.in(bare.layer);
  BitMask cover = surface.in(bare.cover);
  cover.subtract(layer);
  BitMask unknown = surface.in(bare.unknown);
  unknown.subtract(layer);
  unknown.subtract(cover);
  BitMask asked = layer;
  asked &= bare.asked;
  layer.subtract(asked);
  surface.add(std::move(asked), SkinDoubt::Why::kTakenOff, kUnderLayerMm, found);
  surface.add(std::move(layer), SkinDoubt::Why::kLayerTaken, kUnderLayerMm, found);
  surface.add(std::move(cover), SkinDoubt::Why::kCoverTaken, kUnderCoverMm, found);
  surface.add(std::move(unknown), SkinDoubt::Why::kLayerLeft, bare.most_unknown_mm, found);
  std::sort(found.stretches.begin(),
            found.stretches.end(),
            [](const SkinDoubt& a, const SkinDoubt& b) { return a.area_cm2 > b.area_cm2; });
  found.stretches.resize(std::min(found.stretches.size(), kMostStretches));
  found.where = dilated(found.where, 1.8, Eigen::Vector3d::Ones());
  return found;
}

}  // namespace mor::internal
