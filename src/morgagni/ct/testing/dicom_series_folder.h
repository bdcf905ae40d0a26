// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "morgagni/ct/testing/dicom_writer.h"
#include "morgagni/ct/testing/import_folder.h"

namespace mor::testing_dicom {

using Body = std::function<double(const Eigen::Vector3d&)>;

/// HU that tell every place from every other and from its mirror image.
inline double slanted_hu(const Eigen::Vector3d& place) {
  return 7.0 * place.x() + 31.0 * place.y() + 113.0 * place.z();
}

/// The slice with what the body has at its pixels.
inline SliceText filled(SliceText slice, const Body& hu_at) {
  const double slope = std::stod(slice.slope);
  const double intercept = std::stod(slice.intercept);
  for (int y = 0; y < slice.rows; ++y) {
    for (int x = 0; x < slice.columns; ++x) {
      const Eigen::Vector3d place = slice.position_mm +
                                    x * slice.column_spacing_mm * slice.along_row +
                                    y * slice.row_spacing_mm * slice.down_column;
      const auto stored = static_cast<int>(std::lround((hu_at(place) - intercept) / slope));
      slice.stored.push_back(static_cast<std::uint16_t>(stored & ((1 << slice.bits_stored) - 1)));
    }
  }
  return slice;
}

inline Eigen::Vector3d place_of(const Volume& volume, int x, int y, int z) {
  return volume.ct_from_grid * Eigen::Vector3d(x, y, z).cwiseProduct(volume.spacing_mm);
}

/// Every voxel has the HU of its place in space.
inline void expect_holds(const Volume& volume, const Body& hu_at, double tolerance_hu = 0.51) {
  EXPECT_NEAR(volume.ct_from_grid.linear().determinant(), 1.0, 1e-9);
  for (int z = 0; z < volume.size[2]; ++z)
    for (int y = 0; y < volume.size[1]; ++y)
      for (int x = 0; x < volume.size[0]; ++x)
        ASSERT_NEAR(
            volume.hu[volume.index(x, y, z)], hu_at(place_of(volume, x, y, z)), tolerance_hu)
            << "voxel " << x << ' ' << y << ' ' << z;
}

class DicomImport : public ImportFolder {
 protected:
  /// Slices at these heights along their normal, named so that their order says nothing.
  void write_series(const SliceText& base,
                    const std::vector<double>& heights_mm,
                    const Body& hu_at = slanted_hu,
                    const std::string& prefix = "") {
    const Eigen::Vector3d normal = base.along_row.cross(base.down_column);
    for (std::size_t k = 0; k < heights_mm.size(); ++k) {
      SliceText slice = base;
      slice.position_mm += heights_mm[k] * normal;
      const auto number = (k * 11 + 3) % heights_mm.size();
      write(prefix + "im" + std::to_string(number), slice_file(filled(slice, hu_at)));
    }
  }

  Result<Volume> read(const std::string& series = {}) {
    return import_volume(folder_, {series}, {});
  }

  /// And what the log says meanwhile.
  std::pair<Result<Volume>, std::string> read_and_hear(const std::string& series = {}) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    auto volume = read(series);
    std::string said = testing::internal::GetCapturedStdout();
    said += testing::internal::GetCapturedStderr();
    return {std::move(volume), said};
  }
};

inline const std::vector<double> kFive = {0, 2, 4, 6, 8};

}  // namespace mor::testing_dicom
