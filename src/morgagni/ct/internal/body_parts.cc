// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/body_parts.h"

#include <algorithm>
#include <array>

#include "morgagni/ct/internal/components.h"

namespace mor::internal {
namespace {

constexpr double kLeastMl = 1.0;
constexpr std::size_t kMostParts = 20;
constexpr std::size_t kMarksPerPart = 5;

std::string place_of(const Eigen::Vector3d& offset_mm) {
  int axis = 0;
  offset_mm.cwiseAbs().maxCoeff(&axis);
  constexpr std::array<std::array<const char*, 2>, 3> kWords = {
      {{"right of", "left of"}, {"in front of", "behind"}, {"below", "above"}}};
  return kWords[static_cast<std::size_t>(axis)][offset_mm[axis] > 0.0 ? 1 : 0];
}

Eigen::Vector3d middle_of(const Components::Part& part, const Volume& volume) {
  const Eigen::Vector3d low(part.low_x, part.low_y, part.low_z);
  const Eigen::Vector3d high(part.high_x, part.high_y, part.high_z);
  return 0.5 * (low + high).cwiseProduct(volume.spacing_mm);
}

}  // namespace

std::vector<CutPart> parts_of(const BitMask& mask, const BitMask& body, const Volume& volume) {
  const Components parts(mask);
  const Components body_parts(body);
  if (body_parts.parts().empty()) return {};
  const Eigen::Vector3d body_middle = middle_of(body_parts.parts()[body_parts.largest()], volume);
  const double voxel_ml = volume.spacing_mm.prod() / 1000.0;
  std::vector<CutPart> found;
  for (std::size_t i = 0; i < parts.parts().size(); ++i) {
    const auto& part = parts.parts()[i];
    const double volume_ml = static_cast<double>(part.num_voxels) * voxel_ml;
    if (volume_ml < kLeastMl) continue;
    const Eigen::Vector3d offset_mm =
        volume.ct_from_grid.linear() * (middle_of(part, volume) - body_middle);
    const Eigen::Vector3d size_mm = Eigen::Vector3d(part.high_x - part.low_x + 1,
                                                    part.high_y - part.low_y + 1,
                                                    part.high_z - part.low_z + 1)
                                        .cwiseProduct(volume.spacing_mm);
    found.push_back({place_of(offset_mm), volume_ml, size_mm});
    for (const auto& voxel : parts.samples(i, kMarksPerPart)) {
      const Eigen::Vector3d at(voxel[0], voxel[1], voxel[2]);
      found.back().marks_mm.emplace_back(volume.ct_from_grid * at.cwiseProduct(volume.spacing_mm));
    }
  }
  std::sort(found.begin(), found.end(), [](const CutPart& a, const CutPart& b) {
    return a.volume_ml > b.volume_ml;
  });
  found.resize(std::min(found.size(), kMostParts));
  return found;
}

std::vector<CutPart> cut_parts(const Volume& volume, const BodyMask& body) {
  BitMask rest = body.matter;
  rest.subtract(body.body);
  return parts_of(rest, body.body, volume);
}

}  // namespace mor::internal
