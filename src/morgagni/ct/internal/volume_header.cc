// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/volume_header.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/SVD>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/printable_text.h"

namespace mor::internal {
namespace {

constexpr double kMinSpacingMm = 0.01;
constexpr double kMaxSpacingMm = 50.0;
constexpr double kMaxOriginMm = 1e5;
constexpr double kAxesTolerance = 1e-3;

Result<void> check_size(const ImportHeader& header) {
  std::int64_t num_bytes = sizeof(std::int16_t);
  for (int axis = 0; axis < 3; ++axis) {
    const int side = header.size[static_cast<std::size_t>(axis)];
    if (side < 2 || side > kMaxVolumeSide) {
      return make_error(ErrorCode::kInvalidArgument,
                        "the CT has " + std::to_string(side) + " voxels along " + "xyz"[axis] +
                            ", the limits are 2 and " + std::to_string(kMaxVolumeSide));
    }
    num_bytes *= side;
  }
  if (num_bytes > kMaxVolumeBytes) {
    return make_error(ErrorCode::kInvalidArgument,
                      "the CT takes " + std::to_string(num_bytes >> 20) + " MiB, the limit is " +
                          std::to_string(kMaxVolumeBytes >> 20) + " MiB");
  }
  return {};
}

Result<void> check_numbers(const ImportHeader& header) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double spacing_mm = header.spacing_mm[axis];
    if (!(spacing_mm >= kMinSpacingMm && spacing_mm <= kMaxSpacingMm)) {
      return make_error(ErrorCode::kInvalidArgument,
                        std::string("the voxel spacing along ") + "xyz"[axis] + " is " +
                            fmt::format("{:g}", spacing_mm) +
                            " mm, it must be between 0.01 and 50 mm: mend the file's header");
    }
    if (!(std::abs(header.origin_mm[axis]) <= kMaxOriginMm)) {
      return make_error(ErrorCode::kInvalidArgument,
                        fmt::format("the CT's origin is {:g} mm away along {}, not within 100 m",
                                    header.origin_mm[axis],
                                    "xyz"[axis]));
    }
  }
  return {};
}

}  // namespace

Result<Volume> volume_from_header(const ImportHeader& header) {
  if (header.magic != kImportMagic)
    return make_error(ErrorCode::kIo, "the import process gave no volume");
  MOR_CHECK(check_size(header));
  MOR_CHECK(check_numbers(header));
  const Eigen::Matrix3d axes = Eigen::Map<const Eigen::Matrix3d>(header.axes.data());
  const double skew = (axes.transpose() * axes - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(skew <= kAxesTolerance)) {
    return make_error(ErrorCode::kUnsupported,
                      fmt::format("the CT's axes are not at right angles of length 1 (off by {:g}, "
                                  "the limit is {:g}): resample it onto a right-angled grid",
                                  skew,
                                  kAxesTolerance));
  }
  Volume volume;
  std::copy_n(header.size.begin(), 3, volume.size.begin());
  volume.spacing_mm = Eigen::Map<const Eigen::Vector3d>(header.spacing_mm.data());
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(axes, Eigen::ComputeFullU | Eigen::ComputeFullV);
  volume.ct_from_grid.linear() = svd.matrixU() * svd.matrixV().transpose();
  volume.ct_from_grid.translation() = Eigen::Map<const Eigen::Vector3d>(header.origin_mm.data());
  const auto end = std::find(header.description.begin(), header.description.end(), '\0');
  volume.description = printable_text({header.description.begin(), end});
  return volume;
}

void make_right_handed(Volume& volume) {
  Eigen::Matrix3d axes = volume.ct_from_grid.linear();
  if (axes.determinant() > 0.0) return;
  const auto slice = static_cast<std::ptrdiff_t>(volume.size[0]) * volume.size[1];
  for (int low = 0, high = volume.size[2] - 1; low < high; ++low, --high) {
    std::swap_ranges(volume.hu.begin() + low * slice,
                     volume.hu.begin() + (low + 1) * slice,
                     volume.hu.begin() + high * slice);
  }
  const double depth_mm = (volume.size[2] - 1) * volume.spacing_mm.z();
  volume.ct_from_grid.translation() += axes.col(2) * depth_mm;
  axes.col(2) *= -1.0;
  volume.ct_from_grid.linear() = axes;
}

}  // namespace mor::internal
