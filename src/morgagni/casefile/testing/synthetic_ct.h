// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "morgagni/core/files.h"

namespace mor::testing_ct {

inline constexpr int kSide = 96;
inline constexpr double kSpacingMm = 2.0;
/// LPS mm of the first voxel.
inline const Eigen::Vector3d kOriginMm(-95.0, -120.0, 40.0);

/// HU of an egg with a nose and two ears, none of them alike, and a bone ball inside; air around.
inline std::int16_t hu_at(const Eigen::Vector3d& p) {
  const auto inside = [&p](const Eigen::Vector3d& center, const Eigen::Vector3d& radii) {
    return (p - center).cwiseQuotient(radii).squaredNorm() < 1.0;
  };
  const Eigen::Vector3d middle =
      kOriginMm + Eigen::Vector3d::Constant(0.5 * kSpacingMm * (kSide - 1));
  if (inside(middle + Eigen::Vector3d(10, 0, 5), {25, 25, 30})) return 900;
  const bool is_body = inside(middle, {55, 65, 75}) ||
                       inside(middle + Eigen::Vector3d(5, -60, 0), {14, 22, 16}) ||
                       inside(middle + Eigen::Vector3d(55, 5, 12), {14, 12, 20}) ||
                       inside(middle + Eigen::Vector3d(-52, 15, -15), {18, 16, 12});
  return is_body ? 40 : -1000;
}

/// Writes it as a MetaImage file.
inline void write_synthetic_ct(const std::filesystem::path& path) {
  std::vector<std::int16_t> voxels;
  voxels.reserve(kSide * kSide * kSide);
  for (int z = 0; z < kSide; ++z) {
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x)
        voxels.push_back(hu_at(kOriginMm + kSpacingMm * Eigen::Vector3d(x, y, z)));
    }
  }
  std::string file =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
      "CompressedData = False\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = -95 -120 40\n"
      "ElementSpacing = 2 2 2\nDimSize = 96 96 96\nElementType = MET_SHORT\nElementDataFile = "
      "LOCAL\n";
  const auto bytes = std::as_bytes(std::span(voxels));
  file.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!write_file(path, file)) std::abort();
}

}  // namespace mor::testing_ct
