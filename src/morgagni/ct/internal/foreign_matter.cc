// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/foreign_matter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include <tbb/parallel_for.h>

#include "morgagni/ct/internal/components.h"

namespace mor::internal {
namespace {

/// Means of blocks of about this side are looked at: noise does not count there.
constexpr double kBlockMm = 2.0;
constexpr double kAirHu = -700.0;
constexpr double kLeastCoverHu = -800.0;  ///< Cloth with half a voxel of air in it.
constexpr double kThinnestHu = -300.0;    ///< Of what counts as matter at all.
constexpr double kLightestSkinHu = -160.0;
/// What is lighter in the mean, and thick, is no fat, which has about -100 HU.
constexpr double kLightestThickHu = -128.0;
constexpr std::array kDenseLimitsHu = {100.0, 150.0, 250.0};
constexpr double kLeastCastHu = 150.0;
constexpr double kFleshHu = 30.0;
constexpr double kFatHu = -95.0;
/// Within a piece noise must reach so far towards the flesh to be taken for it.
constexpr double kInnerShare = 0.35;
/// Air within passages narrower than twice this is not the air outside.
constexpr double kPassageMm = 6.0;
/// Share of a piece's surroundings that must be air outside.
constexpr double kLeastOpen = 0.2;
constexpr double kMostUneven = 0.3;  ///< Standard deviation by mean.
constexpr double kAlike = 0.25;  ///< Share of the median by which light stuff may differ from it.
constexpr double kLeastAlike = 0.5;
/// A body is flesh and fat for more than this; a figure, a phantom and dry bones are not.
constexpr double kLeastFlesh = 0.45;
constexpr double kLeastMm3 = 5000.0;

/// The volume in blocks.
class Blocks {
 public:
  explicit Blocks(const Volume& volume) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double spacing_mm = volume.spacing_mm[static_cast<Eigen::Index>(axis)];
      voxels_[axis] = std::max(1, static_cast<int>(std::lround(kBlockMm / spacing_mm)));
      means_.size[axis] = (volume.size[axis] + voxels_[axis] - 1) / voxels_[axis];
      means_.spacing_mm[static_cast<Eigen::Index>(axis)] = spacing_mm * voxels_[axis];
    }
    size_ = volume.size;
    means_.hu.resize(means_.index(0, 0, means_.size[2]));
    tbb::parallel_for(0, means_.size[2], [&](int z) { average_layer(volume, z); });
    smooth_ = smoothed();
  }

  [[nodiscard]] const Volume& means() const { return means_; }
  /// Each block with its six neighbours: the noise of a folded blanket must not count.
  [[nodiscard]] const Volume& smooth() const { return smooth_; }
  [[nodiscard]] const Eigen::Vector3d& spacing_mm() const { return means_.spacing_mm; }
  [[nodiscard]] double side_mm() const { return means_.spacing_mm.maxCoeff(); }

  [[nodiscard]] BitMask voxels_of(const BitMask& mask) const {
    BitMask voxels(size_);
    tbb::parallel_for(0, size_[2], [&](int z) {
      for (int y = 0; y < size_[1]; ++y)
        for (int x = 0; x < mask.size()[0]; ++x)
          if (mask.test(x, y / voxels_[1], z / voxels_[2]))
            voxels.set_run(y, z, x * voxels_[0], std::min(size_[0], (x + 1) * voxels_[0]));
    });
    return voxels;
  }

  /// Calls visit(x, y, z) for each voxel of the blocks in `mask`.
  template <class Visit>
  void for_each_voxel(const BitMask& mask, const Visit& visit) const {
    internal::for_each_voxel(mask, [&](const std::array<int, 3>& block) {
      std::array<int, 3> end{};
      for (std::size_t axis = 0; axis < 3; ++axis)
        end[axis] = std::min(size_[axis], (block[axis] + 1) * voxels_[axis]);
      for (int z = block[2] * voxels_[2]; z < end[2]; ++z)
        for (int y = block[1] * voxels_[1]; y < end[1]; ++y)
          for (int x = block[0] * voxels_[0]; x < end[0]; ++x) visit(x, y, z);
    });
  }

 private:
  /// The means of the blocks of one layer.
  void average_layer(const Volume& volume, int block_z) {
    const std::size_t first = means_.index(0, 0, block_z);
    std::vector<std::int32_t> sums(means_.index(0, 0, 1));
    std::vector<std::int32_t> counts(sums.size());
    const int end_z = std::min(size_[2], (block_z + 1) * voxels_[2]);
    for (int z = block_z * voxels_[2]; z < end_z; ++z) {
      for (int y = 0; y < size_[1]; ++y) {
        const std::int16_t* row = volume.hu.data() + volume.index(0, y, z);
        const std::size_t block_row = means_.index(0, y / voxels_[1], 0);
        for (int block_x = 0; block_x < means_.size[0]; ++block_x) {
          const std::size_t block = block_row + static_cast<std::size_t>(block_x);
          const int end_x = std::min(size_[0], (block_x + 1) * voxels_[0]);
          for (int x = block_x * voxels_[0]; x < end_x; ++x) {
            sums[block] += row[x];
            ++counts[block];
          }
        }
      }
    }
    for (std::size_t i = 0; i < sums.size(); ++i)
      means_.hu[first + i] = static_cast<std::int16_t>(sums[i] / counts[i]);
  }

  [[nodiscard]] Volume smoothed() const {
    Volume smooth = means_;
    const int size_x = means_.size[0];
    const int size_y = means_.size[1];
    const int size_z = means_.size[2];
    const auto at = [&](int x, int y, int z) {
      return std::int32_t{means_.hu[means_.index(std::clamp(x, 0, size_x - 1),
                                                 std::clamp(y, 0, size_y - 1),
                                                 std::clamp(z, 0, size_z - 1))]};
    };
    tbb::parallel_for(0, size_z, [&](int z) {
      for (int y = 0; y < size_y; ++y)
        for (int x = 0; x < size_x; ++x)
          smooth.hu[smooth.index(x, y, z)] = static_cast<std::int16_t>(
              (at(x, y, z) + at(x - 1, y, z) + at(x + 1, y, z) + at(x, y - 1, z) + at(x, y + 1, z) +
               at(x, y, z - 1) + at(x, y, z + 1)) /
              7);
    });
    return smooth;
  }

  std::array<int, 3> voxels_{};  ///< Of a block, along each axis.
  std::array<int, 3> size_{};
  Volume means_;
  Volume smooth_;
};

BitMask air_outside(const Blocks& blocks) {
  const BitMask air = threshold(blocks.means(), -32768.0, kAirHu);
  const Components pockets(opened(air, kPassageMm, blocks.spacing_mm()));
  BitMask outside = pockets.select([&](std::size_t i) { return pockets.parts()[i].at_side; });
  outside = dilated(outside, kPassageMm, blocks.spacing_mm());
  outside &= air;
  return outside;
}

struct Stuff {
  double mean_hu = 0.0;
  bool is_even = false;
  double unevenness = 0.0;  ///< Of dense stuff: standard deviation by mean.
};

/// What a piece is made of. Dense stuff must be more even than bone; light stuff must have one HU
/// for most of it, which the steps between slices far apart, half skin, half air, have not.
Stuff stuff_of(const BitMask& piece, const Volume& means) {
  std::vector<double> all;
  for_each_voxel(piece, [&](const std::array<int, 3>& at) {
    all.push_back(means.hu[means.index(at[0], at[1], at[2])]);
  });
  if (all.empty()) return {};
  const auto num = static_cast<double>(all.size());
  const double mean_hu = std::accumulate(all.begin(), all.end(), 0.0) / num;
  if (mean_hu > 0.0) {
    double squares = 0.0;
    for (const double hu : all) squares += (hu - mean_hu) * (hu - mean_hu);
    const double unevenness = std::sqrt(squares / num) / mean_hu;
    return {mean_hu, unevenness <= kMostUneven, unevenness};
  }
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  const double median_hu = *middle;
  const auto num_alike = std::count_if(all.begin(), all.end(), [&](double hu) {
    return std::abs(hu - median_hu) <= kAlike * std::abs(median_hu);
  });
  return {median_hu, static_cast<double>(num_alike) >= kLeastAlike * num};
}

/// Finds the pieces of one kind of stuff and marks their voxels.
class Search {
 public:
  explicit Search(const Volume& volume)
      : volume_(volume), blocks_(volume), outside_(air_outside(blocks_)), foreign_(volume.size) {}

  [[nodiscard]] bool is_body() const {
    const auto flesh = threshold(blocks_.means(), kLightestSkinHu, kDenseLimitsHu.front()).count();
    const auto all = threshold(blocks_.means(), kThinnestHu, 32767.0).count();
    return static_cast<double>(flesh) > kLeastFlesh * static_cast<double>(all);
  }

  void look_for_light() { look_for(blocks_.smooth(), kAirHu, kLightestThickHu); }
  /// Above several limits: where bone lies close beneath, plaster is a piece of its own above some.
  void look_for_dense() {
    for (const double limit_hu : kDenseLimitsHu) look_for(blocks_.means(), limit_hu, 32767.0);
  }

  /// A cast around bone that lies so close beneath the skin that the blocks do not tell them apart:
  /// dense, without flesh between it and the air, as far as a few steps lead into it.
  void look_for_casts() {
    constexpr double kOneVoxel = 1.0;
    constexpr int kNumCrustSteps = 2;
    constexpr double kMostUnevenCast = 0.38;  // Its crust counts; of bone near the air it is 0.5.
    constexpr int kNumSteps = 5;
    BitMask dense = opened(threshold(volume_, kLeastCastHu, 32767.0), kOneVoxel, ones());
    BitMask reached = blocks_.voxels_of(outside_);
    for (int i = 0; i < kNumCrustSteps; ++i) reached = dilated(reached, 1.0, ones());
    reached |= threshold(volume_, -32768.0, kAirHu);
    for (int i = 0; i < kNumSteps; ++i) {
      BitMask next = dilated(reached, 1.0, ones());
      next &= dense;
      reached |= next;
    }
    dense &= reached;
    const Components pieces(dense);
    const auto least = static_cast<std::size_t>(kLeastMm3 / volume_.spacing_mm.prod());
    for (std::size_t i = 0; i < pieces.parts().size(); ++i) {
      if (pieces.parts()[i].num_voxels < least) continue;
      const BitMask piece = pieces.select([&](std::size_t k) { return k == i; });
      const Stuff stuff = stuff_of(piece, volume_);
      if (stuff.unevenness > kMostUnevenCast) continue;
      foreign_ |= piece;
      grow(kFleshHu + 0.5 * (stuff.mean_hu - kFleshHu));
    }
  }

  [[nodiscard]] BitMask found() && {
    foreign_ &= threshold(volume_, kLeastCoverHu, 32767.0);
    return std::move(foreign_);
  }

 private:
  static constexpr double kBesideVoxels = 1.5;
  static Eigen::Vector3d ones() { return Eigen::Vector3d::Ones(); }

  void look_for(const Volume& means, double low_hu, double high_hu) {
    const BitMask band = threshold(means, low_hu, high_hu);
    // What lies between flesh and air in the mean is up to two blocks thick.
    const bool is_dense = low_hu > 0.0;
    const double thick_mm = (is_dense ? 1.01 : 1.6) * blocks_.side_mm();
    const BitMask cores = opened(band, thick_mm, blocks_.spacing_mm());
    const Components pieces(cores);
    const auto least = static_cast<std::size_t>(kLeastMm3 / blocks_.spacing_mm().prod());
    for (std::size_t i = 0; i < pieces.parts().size(); ++i) {
      if (pieces.parts()[i].num_voxels < least) continue;
      const BitMask core = pieces.select([&](std::size_t k) { return k == i; });
      const Stuff stuff = stuff_of(core, means);
      BitMask piece = dilated(core, thick_mm, blocks_.spacing_mm());
      piece &= band;
      if (stuff.is_even && (is_dense || is_throughout(core)) && is_open(piece))
        mark(piece, stuff.mean_hu);
    }
  }

  /// Whether light stuff is what the voxels are, not only what flesh and air make in the mean.
  [[nodiscard]] bool is_throughout(const BitMask& core) const {
    constexpr double kNoiseHu = 120.0;
    constexpr double kLeastShare = 0.85;
    double num_voxels = 0.0;
    double num_light = 0.0;
    blocks_.for_each_voxel(core, [&](int x, int y, int z) {
      const double hu = volume_.hu[volume_.index(x, y, z)];
      ++num_voxels;
      if (hu > kAirHu - kNoiseHu && hu < kLightestThickHu + kNoiseHu) ++num_light;
    });
    return num_light >= kLeastShare * num_voxels;
  }

  [[nodiscard]] bool is_open(const BitMask& piece) const {
    const double side_mm = 1.01 * blocks_.side_mm();
    const BitMask near = dilated(piece, side_mm, blocks_.spacing_mm());
    BitMask around = dilated(near, side_mm, blocks_.spacing_mm());
    around.subtract(near);
    const auto num_around = static_cast<double>(around.count());
    around &= outside_;
    return static_cast<double>(around.count()) > kLeastOpen * num_around;
  }

  /// Within the piece what is not flesh (an ear may be wrapped in it), at its edge what is nearer
  /// to its HU than to the flesh's; and the crust between it and the air.
  void mark(const BitMask& piece, double mean_hu) {
    const bool is_dense = mean_hu > 0.0;
    const double side_mm = 1.01 * blocks_.side_mm();
    const BitMask inner = eroded(piece, side_mm, blocks_.spacing_mm());
    BitMask crust = dilated(piece, side_mm, blocks_.spacing_mm());
    BitMask edge = dilated(piece, (is_dense ? 1.0 : 2.0) * side_mm, blocks_.spacing_mm());
    crust &= dilated(outside_, 2.0 * side_mm, blocks_.spacing_mm());
    if (!is_dense && is_skin(crust)) return;
    edge.subtract(inner);
    const auto towards = [&](double share) { return kFleshHu + share * (mean_hu - kFleshHu); };
    take(inner, towards(kInnerShare), is_dense);
    take(
        edge, is_dense ? towards(0.5) : std::min(towards(0.5), 0.5 * (mean_hu + kFatHu)), is_dense);
    blocks_.for_each_voxel(crust, [&](int x, int y, int z) { foreign_.set_run(y, z, x, x + 1); });
    if (mean_hu > kDenseLimitsHu.back()) grow(towards(0.5));
  }

  /// Into what is as dense and joined to it: where bone lies close beneath, a cast's own pieces end
  /// early. Skin keeps it from the bone.
  void grow(double limit_hu) {
    constexpr int kNumSteps = 12;
    const BitMask dense = threshold(volume_, limit_hu, 32767.0);
    BitMask grown = foreign_;
    grown &= dense;
    for (int i = 0; i < kNumSteps; ++i) {
      grown = dilated(grown, 1.0, ones());
      grown &= dense;
    }
    BitMask crust = dilated(grown, kBesideVoxels, ones());
    crust &= dilated(threshold(volume_, -32768.0, kAirHu), kBesideVoxels, ones());
    foreign_ |= grown;
    foreign_ |= crust;
  }

  /// Gas in the fat is light, too, but has skin over it.
  [[nodiscard]] bool is_skin(const BitMask& crust) const {
    constexpr double kLeastFleshHu = -60.0;
    constexpr double kLeastShare = 0.3;
    double num_voxels = 0.0;
    double num_flesh = 0.0;
    blocks_.for_each_voxel(crust, [&](int x, int y, int z) {
      const double hu = volume_.hu[volume_.index(x, y, z)];
      ++num_voxels;
      if (hu > kLeastFleshHu) ++num_flesh;
    });
    return num_flesh > kLeastShare * num_voxels;
  }

  /// Of the blocks in `mask` the voxels beyond a limit.
  void take(const BitMask& mask, double limit_hu, bool is_dense) {
    blocks_.for_each_voxel(mask, [&](int x, int y, int z) {
      const double hu = smoothed_hu(x, y, z);
      if (is_dense ? hu > limit_hu : hu < limit_hu) foreign_.set_run(y, z, x, x + 1);
    });
  }

  /// Of a voxel and those around it: the noise of one must not count.
  [[nodiscard]] double smoothed_hu(int x, int y, int z) const {
    const auto& size = volume_.size;
    int sum = 0;
    int num = 0;
    for (int at_z = std::max(0, z - 1); at_z <= std::min(size[2] - 1, z + 1); ++at_z) {
      for (int at_y = std::max(0, y - 1); at_y <= std::min(size[1] - 1, y + 1); ++at_y) {
        for (int at_x = std::max(0, x - 1); at_x <= std::min(size[0] - 1, x + 1); ++at_x) {
          sum += volume_.hu[volume_.index(at_x, at_y, at_z)];
          ++num;
        }
      }
    }
    return static_cast<double>(sum) / num;
  }

  const Volume& volume_;
  Blocks blocks_;
  BitMask outside_;
  BitMask foreign_;
};

}  // namespace

std::optional<BitMask> foreign_matter(const Volume& volume) {
  Search search(volume);
  if (!search.is_body()) return std::nullopt;
  search.look_for_light();
  search.look_for_dense();
  search.look_for_casts();
  return std::move(search).found();
}

}  // namespace mor::internal
