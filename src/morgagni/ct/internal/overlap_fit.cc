// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/overlap_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include "morgagni/ct/internal/body_block.h"
#include "morgagni/ct/internal/volume_sample.h"

namespace mor::internal {
namespace {

constexpr double kTissueHu = kLeastTissueHu + 10.0;
constexpr double kHuberHu = 100.0;
constexpr std::size_t kMostCubes = 40000;

double huber_weight(double residual_hu) {
  const double size = std::abs(residual_hu);
  return size <= kHuberHu ? 1.0 : kHuberHu / size;
}

double median_of(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::optional<OverlapFit::Slope> OverlapFit::slope_at(const Eigen::Vector3d& place_mm) const {
  const Eigen::Vector3d grid_mm = place_mm - second_.ct_from_grid.translation();
  const auto here = sampled_hu(second_, grid_mm);
  if (!here) return std::nullopt;
  Slope slope;
  slope.hu = *here;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = Eigen::Vector3d::Unit(axis) * second_.spacing_mm[axis];
    const auto before = sampled_hu(second_, grid_mm - step);
    const auto behind = sampled_hu(second_, grid_mm + step);
    if (!before || !behind) return std::nullopt;
    slope.per_mm[axis] = (*behind - *before) / (2.0 * second_.spacing_mm[axis]);
  }
  return slope;
}

std::vector<OverlapFit::Cube> OverlapFit::cubes_in(const Cell& first,
                                                   const Cell& end,
                                                   int stride) const {
  std::vector<Cube> cubes;
  for (int z = first.z; z < std::min(end.z, first_.size[2]); z += 1) {
    for (int y = first.y; y < std::min(end.y, first_.size[1]); y += stride) {
      for (int x = first.x; x < std::min(end.x, first_.size[0]); x += stride) {
        const double hu = first_.hu[first_.index(x, y, z)];
        if (hu <= kTissueHu) continue;
        cubes.push_back(
            {first_.ct_from_grid * Eigen::Vector3d(x, y, z).cwiseProduct(first_.spacing_mm), hu});
      }
    }
  }
  return cubes;
}

Eigen::Isometry3d OverlapFit::refined(const Eigen::Isometry3d& first_from_second) const {
  constexpr int kMostSteps = 20;
  constexpr double kSmallStep = 1e-3;
  const Cell end = {first_.size[0], first_.size[1], first_.size[2]};
  auto cubes = cubes_in({}, end, 1);
  Eigen::Isometry3d second_from_first = first_from_second.inverse();
  // Only what may be seen in both: the rest would be asked for in vain at each step.
  constexpr double kMarginMm = 30.0;
  const Eigen::Vector3d low = second_.ct_from_grid.translation().array() - kMarginMm;
  const Eigen::Vector3d sides = Eigen::Vector3d(second_.size[0], second_.size[1], second_.size[2])
                                    .cwiseProduct(second_.spacing_mm)
                                    .array() +
                                2.0 * kMarginMm;
  std::erase_if(cubes, [&](const Cube& cube) {
    const Eigen::Vector3d at = second_from_first * cube.place_mm - low;
    return at.minCoeff() < 0.0 || ((sides - at).minCoeff() < 0.0);
  });
  const std::size_t stride = std::max<std::size_t>(1, cubes.size() / kMostCubes);
  for (int step = 0; step < kMostSteps; ++step) {
    Eigen::Matrix<double, 6, 6> gram = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    std::vector<std::pair<Eigen::Vector3d, std::pair<Slope, double>>> seen;
    for (std::size_t i = 0; i < cubes.size(); i += stride) {
      const Eigen::Vector3d place = second_from_first * cubes[i].place_mm;
      const auto slope = slope_at(place);
      if (!slope) continue;
      seen.push_back({place, {*slope, slope->hu - cubes[i].hu}});
      middle += place;
    }
    if (seen.size() < 100) break;
    middle /= static_cast<double>(seen.size());
    for (const auto& [place, what] : seen) {
      const auto& [slope, residual] = what;
      Eigen::Matrix<double, 6, 1> row;
      row << (place - middle).cross(slope.per_mm), slope.per_mm;
      const double weight = huber_weight(residual);
      gram += weight * row * row.transpose();
      right -= weight * residual * row;
    }
    gram.diagonal() *= 1.0 + 1e-4;
    const Eigen::Matrix<double, 6, 1> move = gram.ldlt().solve(right);
    if (!move.allFinite()) break;
    Eigen::Isometry3d update = Eigen::Isometry3d::Identity();
    const Eigen::Vector3d turn = move.head<3>();
    if (turn.norm() > 0.0)
      update.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    update.translation() = middle - update.linear() * middle + move.tail<3>();
    second_from_first = update * second_from_first;
    if (100.0 * turn.norm() + move.tail<3>().norm() < kSmallStep) break;
  }
  return second_from_first.inverse();
}

std::optional<double> OverlapFit::offset_of(const std::vector<Cube>& piece,
                                            const Eigen::Isometry3d& second_from_first) const {
  constexpr int kMostSteps = 10;
  constexpr double kFarthestMm = 15.0;
  constexpr double kLeastSlopeHuPerMm = 4.0;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  for (int step = 0; step < kMostSteps; ++step) {
    Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    std::size_t num_seen = 0;
    for (const auto& cube : piece) {
      const auto slope = slope_at(second_from_first * cube.place_mm + offset);
      if (!slope) continue;
      ++num_seen;
      const double residual = slope->hu - cube.hu;
      const double weight = huber_weight(residual);
      gram += weight * slope->per_mm * slope->per_mm.transpose();
      right -= weight * residual * slope->per_mm;
    }
    if (2 * num_seen < piece.size()) return std::nullopt;
    if (step == 0) {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(gram);
      const double weakest =
          std::sqrt(std::max(0.0, eigen.eigenvalues()[0]) / static_cast<double>(num_seen));
      if (weakest < kLeastSlopeHuPerMm) return std::nullopt;
    }
    const Eigen::Vector3d move = gram.ldlt().solve(right);
    if (!move.allFinite()) return kFarthestMm;
    offset += move;
    if (offset.norm() > kFarthestMm) return kFarthestMm;
    if (move.norm() < 0.01) break;
  }
  return offset.norm();
}

OverlapQuality OverlapFit::quality(const Eigen::Isometry3d& first_from_second) const {
  constexpr double kPieceMm = 30.0;
  constexpr double kFlatHuPerMm = 8.0;
  const Eigen::Isometry3d second_from_first = first_from_second.inverse();
  const int side = std::max(2, static_cast<int>(std::lround(kPieceMm / first_.spacing_mm.x())));
  OverlapQuality quality;
  std::vector<double> offsets_mm;
  std::vector<double> differences_hu;
  double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  double lowest_mm = std::numeric_limits<double>::infinity();
  double highest_mm = -lowest_mm;
  for (int z = 0; z < first_.size[2]; z += side) {
    for (int y = 0; y < first_.size[1]; y += side) {
      for (int x = 0; x < first_.size[0]; x += side) {
        const auto piece = cubes_in({x, y, z}, {x + side, y + side, z + side}, 1);
        if (piece.size() < static_cast<std::size_t>(side * side * side / 4)) continue;
        for (const auto& cube : piece) {
          const auto slope = slope_at(second_from_first * cube.place_mm);
          if (!slope) continue;
          n += 1;
          a += cube.hu;
          b += slope->hu;
          aa += cube.hu * cube.hu;
          bb += slope->hu * slope->hu;
          ab += cube.hu * slope->hu;
          lowest_mm = std::min(lowest_mm, cube.place_mm.z());
          highest_mm = std::max(highest_mm, cube.place_mm.z());
          if (slope->per_mm.norm() < kFlatHuPerMm && std::abs(cube.hu) < 150.0)
            differences_hu.push_back(slope->hu - cube.hu);
        }
        if (const auto offset = offset_of(piece, second_from_first)) offsets_mm.push_back(*offset);
      }
    }
  }
  if (n < 100.0) return quality;
  quality.overlap_mm = highest_mm - lowest_mm + first_.spacing_mm.z();
  const double spread = (n * aa - a * a) * (n * bb - b * b);
  quality.correlation = spread > 0.0 ? (n * ab - a * b) / std::sqrt(spread) : 0.0;
  quality.num_pieces = static_cast<int>(offsets_mm.size());
  quality.hu_difference = median_of(differences_hu);
  if (offsets_mm.empty()) return quality;
  std::sort(offsets_mm.begin(), offsets_mm.end());
  quality.median_offset_mm = offsets_mm[offsets_mm.size() / 2];
  quality.p90_offset_mm = offsets_mm[offsets_mm.size() * 9 / 10];
  return quality;
}

}  // namespace mor::internal
