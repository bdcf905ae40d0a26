// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <tbb/parallel_for.h>

#include "morgagni/core/image.h"
#include "morgagni/registration/internal/lanes.h"

namespace mor::internal {
namespace {

constexpr int kNumYaws = 72;
constexpr std::size_t kPeaksPerYaw = 24;
constexpr double kYawStepRad = 2.0 * std::numbers::pi / kNumYaws;

/// A search point on the volume's grid, the body not yet moved.
struct GridPoint {
  int x, y, z;
};

struct Peak {
  int score = 0;
  int yaw = 0;
  int x = 0;  ///< Shift of the points, in nodes.
  int y = 0;
};

constexpr int kPolishYaws = 3;  ///< Finer turns to either side, up to half a yaw step.
/// Shifts to either side, in nodes of the fine volume: one and a half of the coarse one.
constexpr int kPolishReach = 3;
constexpr std::size_t kPolishPoints = 800;

/// The worth at each shift of a polish: a row of lanes for each along y, a lane for each along x.
constexpr int kPolishSide = 2 * kPolishReach + 1;
static_assert(kPolishSide < kLanes);
using PolishSums = std::array<IntLanes, kPolishSide>;

Eigen::Isometry3d turned(double yaw_rad) {
  return Eigen::Isometry3d(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
}

/// Every shift's score at one yaw. Each point adds the volume's layer at its height once, moved:
/// whole rows in vector instructions.
class Correlation {
 public:
  Correlation(const StartScene& scene, const StartVolume& volume, double yaw_rad)
      : volume_(volume) {
    const Eigen::Isometry3f turn = turned(yaw_rad).cast<float>();
    int max_x = INT32_MIN;
    int max_y = INT32_MIN;
    for (const auto& point : scene.search_points) {
      const Eigen::Vector3f grid = (turn * point - volume.origin_mm) / volume.spacing_mm;
      const GridPoint at{static_cast<int>(std::lround(grid.x())),
                         static_cast<int>(std::lround(grid.y())),
                         static_cast<int>(std::lround(grid.z()))};
      if (at.z < 0 || at.z >= volume.size[2]) continue;
      points_.push_back(at);
      min_x_ = std::min(min_x_, at.x);
      min_y_ = std::min(min_y_, at.y);
      max_x = std::max(max_x, at.x);
      max_y = std::max(max_y, at.y);
    }
    if (points_.empty()) return;
    // Shift s puts point p on node p + s: s runs from -max to size - min.
    first_x_ = -max_x;
    first_y_ = -max_y;
    sums_ = Image<std::int16_t>(
        volume.stride + max_x - min_x_, volume.size[1] + max_y - min_y_, std::int16_t{0});
    width_ = volume.size[0] + max_x - min_x_;
    for (const auto& point : points_) add(point);
  }

  [[nodiscard]] std::vector<Peak> peaks(int yaw) const {
    std::vector<Peak> peaks;
    for (int y = 1; y + 1 < sums_.height(); ++y) {
      for (int x = 1; x + 1 < width_; ++x) {
        if (sums_(x, y) > 0 && is_peak(x, y)) {
          peaks.push_back({sums_(x, y), yaw, x + first_x_, y + first_y_});
        }
      }
    }
    const auto is_better = [](const Peak& a, const Peak& b) { return a.score > b.score; };
    std::stable_sort(peaks.begin(), peaks.end(), is_better);
    if (peaks.size() > kPeaksPerYaw) peaks.resize(kPeaksPerYaw);
    return peaks;
  }

 private:
  void add(const GridPoint& point) {
    constexpr int kStep = StartVolume::kRowStep;
    for (int y = 0; y < volume_.size[1]; ++y) {
      const std::int8_t* worth = volume_.row(y, point.z);
      std::int16_t* sums = sums_.view().row(y - point.y - first_y_) - point.x - first_x_;
      for (int first = 0; first < volume_.stride; first += kStep, sums += kStep, worth += kStep) {
        for (int i = 0; i < kStep; ++i) sums[i] = static_cast<std::int16_t>(sums[i] + worth[i]);
      }
    }
  }

  [[nodiscard]] bool is_peak(int x, int y) const {
    const int here = sums_(x, y);
    for (int v = -1; v <= 1; ++v) {
      for (int u = -1; u <= 1; ++u) {
        if (u == 0 && v == 0) continue;
        // Of equal neighbours the first counts.
        const bool is_before = v < 0 || (v == 0 && u < 0);
        const int there = sums_(x + u, y + v);
        if (there > here || (is_before && there == here)) return false;
      }
    }
    return true;
  }

  const StartVolume& volume_;
  std::vector<GridPoint> points_;
  int min_x_ = INT32_MAX;
  int min_y_ = INT32_MAX;
  int first_x_ = 0;
  int first_y_ = 0;
  int width_ = 0;  ///< Of the sums that mean something.
  Image<std::int16_t> sums_;
};

/// Whether a better peak of a like yaw is near.
bool is_shadowed(const Peak& peak, const std::vector<Peak>& better) {
  constexpr int kNearNodes = 3;
  constexpr int kNearYaws = 2;
  return std::any_of(better.begin(), better.end(), [&peak](const Peak& other) {
    const int turn = std::abs(peak.yaw - other.yaw);
    return std::min(turn, kNumYaws - turn) <= kNearYaws &&
           std::abs(peak.x - other.x) <= kNearNodes && std::abs(peak.y - other.y) <= kNearNodes;
  });
}

/// The scene's dense points, frame table, that are near the body where the candidate puts it.
std::vector<Eigen::Vector3f> points_near(const StartScene& scene,
                                         const StartVolume& volume,
                                         const StartCandidate& candidate,
                                         double margin_mm) {
  const Eigen::Isometry3f pose = candidate.lying_from_table().cast<float>();
  const auto margin = static_cast<float>(margin_mm);
  Eigen::AlignedBox3f box(
      volume.origin_mm - Eigen::Vector3f::Constant(margin),
      volume.origin_mm +
          volume.spacing_mm * Eigen::Vector3f(static_cast<float>(volume.size[0]),
                                              static_cast<float>(volume.size[1]),
                                              static_cast<float>(volume.size[2])) +
          Eigen::Vector3f::Constant(margin));
  std::vector<Eigen::Vector3f> near;
  for (const auto& point : scene.dense_points) {
    if (box.contains(pose * point)) near.push_back(point);
  }
  if (near.size() <= kPolishPoints) return near;
  std::vector<Eigen::Vector3f> some;
  for (std::size_t i = 0; i < kPolishPoints; ++i)
    some.push_back(near[i * near.size() / kPolishPoints]);
  return some;
}

/// The shift that turns the candidate to `yaw_rad` about the middle of the body.
Eigen::Vector2d shift_about_body(const StartVolume& volume,
                                 const StartCandidate& candidate,
                                 double yaw_rad) {
  const Eigen::Vector2d middle = volume.origin_mm.head<2>().cast<double>() +
                                 0.5 * static_cast<double>(volume.spacing_mm) *
                                     Eigen::Vector2d(volume.size[0], volume.size[1]);
  const Eigen::Rotation2Dd turn(yaw_rad - candidate.yaw_rad);
  return middle + turn * (candidate.shift_mm - middle);
}

/// Each point's worth at all shifts.
PolishSums sum_of_windows(const std::vector<Eigen::Vector3f>& points,
                          const StartVolume& volume,
                          const StartCandidate& candidate) {
  const Eigen::Isometry3f pose = candidate.lying_from_table().cast<float>();
  const auto [nx, ny, nz] = volume.size;
  PolishSums sums{};
  for (const auto& point : points) {
    const Eigen::Vector3f grid = (pose * point - volume.origin_mm) / volume.spacing_mm;
    const int x = static_cast<int>(std::floor(grid.x() + 0.5F)) - kPolishReach;
    const int y = static_cast<int>(std::floor(grid.y() + 0.5F)) - kPolishReach;
    const int z = static_cast<int>(std::floor(grid.z() + 0.5F));
    if (z < 0 || z >= nz) continue;
    const bool is_inside = x >= 0 && x + kLanes <= nx;
    for (int v = std::max(0, -y); v < std::min(kPolishSide, ny - y); ++v) {
      const std::int8_t* worth = volume.row(y + v, z) + x;
      IntLanes& sum = sums[static_cast<std::size_t>(v)];
      if (is_inside) {
        for (int u = 0; u < kLanes; ++u) sum[u] += worth[u];
      } else {
        for (int u = std::max(0, -x); u < std::min(kPolishSide, nx - x); ++u) sum[u] += worth[u];
      }
    }
  }
  return sums;
}

}  // namespace

std::vector<StartCandidate> search_on_plane(const StartScene& scene,
                                            const StartVolume& volume,
                                            std::size_t max_candidates) {
  if (scene.search_points.empty()) return {};
  std::vector<std::vector<Peak>> by_yaw(kNumYaws);
  tbb::parallel_for(0, kNumYaws, [&](int yaw) {
    by_yaw[static_cast<std::size_t>(yaw)] =
        Correlation(scene, volume, yaw * kYawStepRad).peaks(yaw);
  });
  std::vector<Peak> all;
  for (const auto& peaks : by_yaw) all.insert(all.end(), peaks.begin(), peaks.end());
  std::stable_sort(
      all.begin(), all.end(), [](const Peak& a, const Peak& b) { return a.score > b.score; });
  std::vector<Peak> best;
  for (const auto& peak : all) {
    if (best.size() == max_candidates) break;
    if (!is_shadowed(peak, best)) best.push_back(peak);
  }
  const double most = StartVolume::kMostWorth * static_cast<double>(scene.search_points.size());
  std::vector<StartCandidate> candidates;
  for (const auto& peak : best) {
    candidates.push_back({peak.yaw * kYawStepRad,
                          static_cast<double>(volume.spacing_mm) * Eigen::Vector2d(peak.x, peak.y),
                          peak.score / most});
  }
  return candidates;
}

StartCandidate polish_on_plane(const StartScene& scene,
                               const StartVolume& fine_volume,
                               const StartCandidate& candidate,
                               double step_mm) {
  const std::vector<Eigen::Vector3f> points = points_near(scene, fine_volume, candidate, step_mm);
  StartCandidate best = candidate;
  int most = INT32_MIN;
  for (int turn = -kPolishYaws; turn <= kPolishYaws; ++turn) {
    StartCandidate turned_candidate = candidate;
    turned_candidate.yaw_rad += turn * 0.75 * kYawStepRad / kPolishYaws;
    // About the middle of the body, not of the points' frame.
    turned_candidate.shift_mm = shift_about_body(fine_volume, candidate, turned_candidate.yaw_rad);
    const PolishSums sums = sum_of_windows(points, fine_volume, turned_candidate);
    for (int v = 0; v < kPolishSide; ++v) {
      for (int u = 0; u < kPolishSide; ++u) {
        const int sum = sums[static_cast<std::size_t>(v)][u];
        if (sum <= most) continue;
        most = sum;
        best = turned_candidate;
        best.shift_mm += static_cast<double>(fine_volume.spacing_mm) *
                         Eigen::Vector2d(u - kPolishReach, v - kPolishReach);
      }
    }
  }
  best.score = most / static_cast<double>(StartVolume::kMostWorth);
  return best;
}

}  // namespace mor::internal
