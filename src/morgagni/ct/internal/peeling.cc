// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/peeling.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>

#include "morgagni/ct/internal/cloth.h"
#include "morgagni/ct/internal/components.h"
#include "morgagni/ct/internal/skin_profiles.h"
#include "morgagni/ct/internal/thin_layers.h"
#include "morgagni/ct/internal/tubes.h"
#include "morgagni/ct/internal/volume_sample.h"

namespace mor::internal {
namespace {

constexpr double kEdgeHu = SkinProfile::kEdgeHu;
constexpr double kAirHu = -1000.0;
constexpr double kSkinHuPerMm = 700.0;
constexpr double kNoLimitHu = 32767.0;

/// Everything that air from the sides does not reach.
BitMask solid_of(const Volume& volume) {
  const Components air(threshold(volume, -32768.0, kEdgeHu - 0.5));
  BitMask solid = air.select([&](std::size_t i) { return air.parts()[i].at_side; });
  solid.invert();
  return solid;
}

/// The profiles near to a slice's voxels, row by row; none where no layer is near.
class NearInSlice {
 public:
  NearInSlice(const SkinProfiles& profiles, const std::vector<float>& thick_mm)
      : profiles_(profiles), thick_mm_(thick_mm) {}

  const NearProfiles& from(const Eigen::Vector3f& place_mm) {
    const auto cell = SkinProfiles::cell_of(place_mm);
    if (cell[1] != cell_y_) row_.clear();
    cell_y_ = cell[1];
    auto found = row_.find(cell[0]);
    if (found == row_.end()) {
      auto near = profiles_.near(cell);
      if (std::none_of(near.begin(), near.end(), [&](auto i) { return thick_mm_[i] > 0.0F; }))
        near.clear();
      found = row_.try_emplace(cell[0], profiles_, std::move(near)).first;
    }
    found->second.look_from(place_mm);
    return found->second;
  }

 private:
  const SkinProfiles& profiles_;
  const std::vector<float>& thick_mm_;
  int cell_y_ = -1;
  std::unordered_map<int, NearProfiles> row_;  ///< By the cell's x.
};

/// A voxel that becomes less dense.
struct Change {
  std::array<int, 3> voxel;
  double most_hu;
};

/// Makes the surface lie deeper: air down to there, then as steep as skin is.
class Carving {
 public:
  Carving(const Volume& volume, const SkinProfiles& profiles, const ThinLayers& layers)
      : volume_(volume), profiles_(profiles), layers_(layers), sheet_mm_(layers.thick_mm) {
    for (std::size_t i = 0; i < sheet_mm_.size(); ++i)
      if (layers.is_sheet[i] == 0) sheet_mm_[i] = 0.0F;
  }

  /// What becomes less dense, slice by slice.
  [[nodiscard]] std::vector<std::vector<Change>> run() const {
    const BitMask around = surroundings();
    std::vector<std::vector<Change>> changes(static_cast<std::size_t>(volume_.size[2]));
    tbb::parallel_for(0, volume_.size[2], [&](int slice) {
      NearInSlice near(profiles_, layers_.thick_mm);
      for_each_voxel_in_slice(around, slice, [&](const std::array<int, 3>& voxel) {
        const double hu = volume_.hu[volume_.index(voxel[0], voxel[1], voxel[2])];
        if (hu < 0.9 * kAirHu) return;
        const Eigen::Vector3d place =
            Eigen::Vector3d(voxel[0], voxel[1], voxel[2]).cwiseProduct(volume_.spacing_mm);
        const double most_hu = most_hu_at(place, near.from(place.cast<float>()));
        if (hu > most_hu) changes[static_cast<std::size_t>(slice)].push_back({voxel, most_hu});
      });
    });
    return changes;
  }

 private:
  [[nodiscard]] BitMask surroundings() const {
    std::vector<std::size_t> covered;
    float most_mm = 0.0F;
    for (std::size_t i = 0; i < layers_.thick_mm.size(); ++i) {
      if (layers_.thick_mm[i] <= 0.0F) continue;
      covered.push_back(i);
      most_mm = std::max(most_mm, layers_.thick_mm[i]);
    }
    return dilated(profiles_.voxels_of(covered, volume_), most_mm + 0.5, volume_.spacing_mm);
  }

  /// What a voxel may have at most when the layer above it is air.
  [[nodiscard]] double most_hu_at(const Eigen::Vector3d& place, const NearProfiles& near) const {
    constexpr float kBesideMm = 2.2F;  // Half a cell's diagonal.
    auto profile = near.over(kBesideMm, layers_.thick_mm);
    if (!profile) profile = near.nearest();
    if (!profile || layers_.thick_mm[*profile] <= 0.0F) return most_hu_in_rim(place, near);
    const double thick_mm = layers_.thick_mm[*profile];
    const Eigen::Vector3d inwards = profiles_.all()[*profile].inwards.cast<double>();
    const auto depth = depth_mm(place, inwards, thick_mm);
    // Beside where a sheet comes down, what lies beneath its lifted places may be skin.
    if (depth && layers_.is_lifted[*profile] != 0 &&
        !is_air_beneath(place, inwards, thick_mm - *depth))
      return kNoLimitHu;
    return depth ? kEdgeHu + kSkinHuPerMm * (*depth - thick_mm) : kNoLimitHu;
  }

  /// Where a sheet ends or has an edge its surface faces elsewhere, but it goes on as deep.
  [[nodiscard]] double most_hu_in_rim(const Eigen::Vector3d& place,
                                      const NearProfiles& near) const {
    constexpr float kRimMm = 4.5F;
    const auto profile = near.over(kRimMm, sheet_mm_);
    if (!profile) return kNoLimitHu;
    const auto& over = profiles_.all()[*profile];
    const double depth_mm = (place - over.place_mm.cast<double>()).dot(over.inwards.cast<double>());
    return kEdgeHu + kSkinHuPerMm * (depth_mm - sheet_mm_[*profile]);
  }

  /// How deep a place lies beneath the outermost surface above it; negative: so far outside.
  [[nodiscard]] std::optional<double> depth_mm(const Eigen::Vector3d& place,
                                               const Eigen::Vector3d& inwards,
                                               double thick_mm) const {
    constexpr double kSeekMm = 0.4;
    constexpr double kBeyondMm = 2.0;
    double before_hu = kAirHu;
    for (double above_mm = thick_mm + kBeyondMm; above_mm > -kBeyondMm; above_mm -= kSeekMm) {
      const double hu = sampled_hu(volume_, place - above_mm * inwards).value_or(kAirHu);
      if (hu >= kEdgeHu)
        return above_mm + kSeekMm * std::min(1.0, (hu - kEdgeHu) / std::max(1.0, hu - before_hu));
      before_hu = hu;
    }
    return std::nullopt;
  }

  [[nodiscard]] bool is_air_beneath(const Eigen::Vector3d& place,
                                    const Eigen::Vector3d& inwards,
                                    double within_mm) const {
    constexpr double kSeekMm = 0.5;
    constexpr double kBeyondMm = 1.0;
    for (double mm = 0.0; mm <= within_mm + kBeyondMm; mm += kSeekMm)
      if (sampled_hu(volume_, place + mm * inwards).value_or(kAirHu) < kEdgeHu) return true;
    return false;
  }

  const Volume& volume_;
  const SkinProfiles& profiles_;
  const ThinLayers& layers_;
  std::vector<float> sheet_mm_;  ///< Of the layers that are sheets.
};

void apply(const std::vector<std::vector<Change>>& changes, Volume& volume, BitMask& taken) {
  for (const auto& slice : changes) {
    for (const auto& [voxel, most_hu] : slice) {
      const auto& [x, y, z] = voxel;
      auto& hu = volume.hu[volume.index(x, y, z)];
      if (hu >= kEdgeHu && most_hu < kEdgeHu) taken.set_run(y, z, x, x + 1);
      hu = static_cast<std::int16_t>(std::lround(std::max(kAirHu, most_hu)));
    }
  }
}

void make_air(const BitMask& where, Volume& volume) {
  for_each_voxel(where, [&](const std::array<int, 3>& at) {
    volume.hu[volume.index(at[0], at[1], at[2])] = static_cast<std::int16_t>(kAirHu);
  });
}

/// Nothing is taken off where `settled` is.
void leave(const BitMask& settled,
           const SkinProfiles& profiles,
           const Volume& volume,
           ThinLayers& layers) {
  for (std::size_t i = 0; i < layers.thick_mm.size(); ++i) {
    const Eigen::Vector3i at = volume.nearest_voxel(profiles.all()[i].place_mm.cast<double>());
    if (settled.test(at.x(), at.y(), at.z())) layers.thick_mm[i] = 0.0F;
  }
}

void note_unknown(const SkinProfiles& profiles,
                  const std::vector<float>& unknown_mm,
                  const Volume& volume,
                  Peeled& peeled) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < unknown_mm.size(); ++i) {
    if (unknown_mm[i] <= 0.0F) continue;
    places.push_back(i);
    peeled.most_unknown_mm = std::max<double>(peeled.most_unknown_mm, unknown_mm[i]);
  }
  peeled.unknown |= profiles.voxels_of(places, volume);
}

/// Whether there were any.
bool take_tubes_out(const SkinProfiles& profiles,
                    const BitMask& settled,
                    Volume& volume,
                    BitMask& taken) {
  const auto tubes = find_tubes(volume, profiles, settled);
  if (tubes.empty()) return false;
  const Volume before = volume;
  for (const Tube& tube : tubes) take_out(tube, before, volume, taken);
  return true;
}

}  // namespace

Peeled peel(Volume& volume,
            const BitMask& cover,
            const std::vector<Eigen::Vector3d>& take_off_mm,
            const std::function<void(double)>& report) {
  constexpr int kMostLayers = 2;
  constexpr double kNearMm = 3.0;
  const BitMask settled = dilated(cover, kNearMm, volume.spacing_mm);
  const BitMask nothing(volume.size);
  Peeled peeled = {false, nothing, nothing, nothing, nothing};
  std::vector<Eigen::Vector3f> asked_mm;
  const Eigen::Isometry3d grid_from_ct = volume.ct_from_grid.inverse();
  for (const auto& place_mm : take_off_mm)
    asked_mm.emplace_back((grid_from_ct * place_mm).cast<float>());
  peeled.taken = take_cloth_off(volume, settled);
  peeled.found_any = peeled.taken.count() > 0;
  for (int layer = 0; layer < kMostLayers; ++layer) {
    const auto done = [&](double share) { report((layer + share) / kMostLayers); };
    SkinProfiles profiles(volume, solid_of(volume));
    // First: a tube's wall beside the skin looks like a layer that may go on.
    if (layer == 0 && take_tubes_out(profiles, settled, volume, peeled.tube)) {
      peeled.found_any = true;
      peeled.taken |= peeled.tube;
      profiles = SkinProfiles(volume, solid_of(volume));
    }
    done(0.3);
    ThinLayers layers = thin_layers(volume, profiles, asked_mm);
    peeled.asked |= profiles.voxels_of(layers.asked, volume);
    asked_mm = std::move(layers.not_found_mm);  // They may be of the layer beneath.
    leave(settled, profiles, volume, layers);
    done(0.5);
    note_unknown(profiles, layers.unknown_mm, volume, peeled);
    if (std::all_of(
            layers.thick_mm.begin(), layers.thick_mm.end(), [](float mm) { return mm == 0.0F; }))
      break;
    peeled.found_any = true;
    apply(Carving(volume, profiles, layers).run(), volume, peeled.taken);
    make_air(layers.foam, volume);  // Or the next layer would be its cover, too.
    done(1.0);
  }
  return peeled;
}

}  // namespace mor::internal
