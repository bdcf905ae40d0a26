// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/block_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <tuple>

#include <tbb/parallel_for.h>

#include "morgagni/ct/internal/body_block.h"

namespace mor::internal {
namespace {

constexpr double kLeastOverlapMm = 40.0;
constexpr std::size_t kMostStarts = 5;
constexpr double kApartMm = 16.0;
constexpr int kTissueHu = kLeastTissueHu + 10;

/// As it lies, turned over, feet first, both; on either side.
std::array<Eigen::Matrix3d, 6> turns() {
  const auto about = [](double angle_rad, const Eigen::Vector3d& axis) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
    return Eigen::Matrix3d(turn.array().round());
  };
  constexpr double kPi = std::numbers::pi;
  return {Eigen::Matrix3d::Identity(),
          about(kPi, Eigen::Vector3d::UnitZ()),
          about(kPi, Eigen::Vector3d::UnitX()),
          about(kPi, Eigen::Vector3d::UnitY()),
          about(0.5 * kPi, Eigen::Vector3d::UnitZ()),
          about(-0.5 * kPi, Eigen::Vector3d::UnitZ())};
}

/// A block turned about the origin of its frame, on cubes along LPS again.
Volume turned(const Volume& block, const Eigen::Matrix3d& turn) {
  const double cube_mm = block.spacing_mm.x();
  const Eigen::Vector3d first = turn * block.ct_from_grid.translation();
  const Eigen::Vector3d sides =
      turn * Eigen::Vector3d(block.size[0] - 1, block.size[1] - 1, block.size[2] - 1);
  Volume result;
  result.spacing_mm = block.spacing_mm;
  result.ct_from_grid.translation() = first + cube_mm * sides.cwiseMin(0.0);
  for (int axis = 0; axis < 3; ++axis)
    result.size[static_cast<std::size_t>(axis)] = 1 + static_cast<int>(std::abs(sides[axis]));
  result.hu.resize(block.hu.size());
  const Eigen::Vector3d offset = -sides.cwiseMin(0.0);
  for (int z = 0; z < block.size[2]; ++z) {
    for (int y = 0; y < block.size[1]; ++y) {
      for (int x = 0; x < block.size[0]; ++x) {
        const Eigen::Vector3i at =
            (turn * Eigen::Vector3d(x, y, z) + offset).array().round().cast<int>();
        result.hu[result.index(at.x(), at.y(), at.z())] = block.hu[block.index(x, y, z)];
      }
    }
  }
  return result;
}

/// How much tissue each slice has, and where its middle is, in cubes.
struct SliceMass {
  double mass = 0.0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
};

std::vector<SliceMass> masses_of(const Volume& block) {
  std::vector<SliceMass> slices(static_cast<std::size_t>(block.size[2]));
  for (int z = 0; z < block.size[2]; ++z) {
    auto& slice = slices[static_cast<std::size_t>(z)];
    for (int y = 0; y < block.size[1]; ++y) {
      for (int x = 0; x < block.size[0]; ++x) {
        const double mass = block.hu[block.index(x, y, z)] - kLeastTissueHu;
        slice.mass += mass;
        slice.moment += mass * Eigen::Vector2d(x, y);
      }
    }
  }
  return slices;
}

struct Candidate {
  double correlation = -1.0;
  Eigen::Vector3i shift = Eigen::Vector3i::Zero();  ///< Cubes of the first from the second's.
};

/// Sums for a correlation.
struct Sums {
  double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  void add(double x, double y) {
    n += 1;
    a += x;
    b += y;
    aa += x * x;
    bb += y * y;
    ab += x * y;
  }
  [[nodiscard]] double correlation() const {
    const double spread = (n * aa - a * a) * (n * bb - b * b);
    return spread > 0.0 ? (n * ab - a * b) / std::sqrt(spread) : -1.0;
  }
};

/// @param z_shift  First slice z lies on second slice z - z_shift.
Candidate correlated(const Volume& first,
                     const Volume& second,
                     const std::vector<SliceMass>& first_mass,
                     const std::vector<SliceMass>& second_mass,
                     int z_shift) {
  const int begin = std::max(0, z_shift);
  const int end = std::min(first.size[2], second.size[2] + z_shift);
  SliceMass in_first;
  SliceMass in_second;
  for (int z = begin; z < end; ++z) {
    const auto& a = first_mass[static_cast<std::size_t>(z)];
    const auto& b = second_mass[static_cast<std::size_t>(z - z_shift)];
    in_first.mass += a.mass;
    in_first.moment += a.moment;
    in_second.mass += b.mass;
    in_second.moment += b.moment;
  }
  Candidate candidate;
  if (!(in_first.mass > 0.0 && in_second.mass > 0.0)) return candidate;
  const Eigen::Vector2d apart = in_first.moment / in_first.mass - in_second.moment / in_second.mass;
  candidate.shift = {
      static_cast<int>(std::lround(apart.x())), static_cast<int>(std::lround(apart.y())), z_shift};
  Sums sums;
  constexpr int kStride = 2;
  for (int z = begin; z < end; ++z) {
    for (int y = 0; y < first.size[1]; y += kStride) {
      for (int x = 0; x < first.size[0]; x += kStride) {
        const int bx = x - candidate.shift.x();
        const int by = y - candidate.shift.y();
        if (bx < 0 || by < 0 || bx >= second.size[0] || by >= second.size[1]) continue;
        const int a = first.hu[first.index(x, y, z)];
        const int b = second.hu[second.index(bx, by, z - z_shift)];
        if (a > kTissueHu || b > kTissueHu) sums.add(a, b);
      }
    }
  }
  if (sums.n > 100.0) candidate.correlation = sums.correlation();
  return candidate;
}

std::vector<Candidate> all_shifts(const Volume& first, const Volume& second) {
  const auto first_mass = masses_of(first);
  const auto second_mass = masses_of(second);
  const int least = static_cast<int>(kLeastOverlapMm / first.spacing_mm.z());
  const int from = least - second.size[2];
  const int to = first.size[2] - least;
  std::vector<Candidate> candidates(static_cast<std::size_t>(std::max(0, to - from + 1)));
  tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t i) {
    candidates[i] = correlated(first, second, first_mass, second_mass, from + static_cast<int>(i));
  });
  return candidates;
}

}  // namespace

std::vector<Eigen::Isometry3d> search_blocks(const Volume& first, const Volume& second) {
  struct Start {
    double correlation;
    std::size_t turn;
    int z_shift;
    Eigen::Isometry3d first_from_second;
  };
  std::vector<Start> starts;
  const auto all_turns = turns();
  for (std::size_t t = 0; t < all_turns.size(); ++t) {
    const Volume block = turned(second, all_turns[t]);
    for (const auto& candidate : all_shifts(first, block)) {
      Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
      pose.linear() = all_turns[t];
      pose.translation() = first.ct_from_grid.translation() - block.ct_from_grid.translation() +
                           first.spacing_mm.cwiseProduct(candidate.shift.cast<double>());
      starts.push_back({candidate.correlation, t, candidate.shift.z(), pose});
    }
  }
  // Not stable_sort: its buffer does not keep to what a pose asks of its alignment.
  std::sort(starts.begin(), starts.end(), [](const Start& a, const Start& b) {
    return std::tuple(-a.correlation, a.turn, a.z_shift) <
           std::tuple(-b.correlation, b.turn, b.z_shift);
  });
  std::vector<Start> chosen;
  for (const auto& start : starts) {
    if (chosen.size() >= kMostStarts || start.correlation <= 0.0) break;
    const bool is_near = std::any_of(chosen.begin(), chosen.end(), [&](const Start& other) {
      return other.turn == start.turn &&
             (other.first_from_second.translation() - start.first_from_second.translation())
                     .norm() < kApartMm;
    });
    if (!is_near) chosen.push_back(start);
  }
  std::vector<Eigen::Isometry3d> poses;
  for (const auto& start : chosen) poses.push_back(start.first_from_second);
  return poses;
}

}  // namespace mor::internal
