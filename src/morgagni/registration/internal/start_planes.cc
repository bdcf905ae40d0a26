// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_planes.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <Eigen/Eigenvalues>

#include "morgagni/registration/internal/sensor_points.h"

namespace mor::internal {
namespace {

constexpr float kLargePlane = 0.12F;  ///< Share of the picture's surface.
constexpr std::size_t kMaxPlanes = 4;
constexpr float kMinShare = 0.02F;
constexpr int kNumSamplesWide = 54;      ///< A row of samples.
constexpr std::size_t kMaxTrials = 240;  ///< Samples whose own plane is tried.
constexpr float kNormalRadiusMm = 25.0F;
constexpr float kLevelCosine = 0.97F;  ///< A plane within 14 degrees of level may be a table.
constexpr float kAlikeCosine = 0.9F;   ///< Between the normals of a plane and of a point on it.
/// So much of its height a body shows at least and, with a table found too low, at most.
constexpr float kLeastShown = 0.3F;
constexpr float kMostShown = 1.2F;
constexpr float kLeastBelowMm = 10.0F;
constexpr std::size_t kMaxSupposed = 24;
constexpr std::size_t kHighest = 50;  ///< One reading in so many may be higher than the body.

struct Sample {
  Eigen::Vector3f point;
  Eigen::Vector3f normal;
  float area;      ///< Of the surface it stands for, up to a factor.
  float reach_mm;  ///< A plane nearer than this may be its own.
};

std::vector<Sample> take_samples(const StartPicture& picture) {
  std::vector<Sample> samples;
  const int step = std::max(1, picture.z_mm.width() / kNumSamplesWide);
  for (int y = step / 2; y < picture.z_mm.height(); y += step) {
    for (int x = step / 2; x < picture.z_mm.width(); x += step) {
      const auto normal = picture.normal(x, y, kNormalRadiusMm);
      if (!normal) continue;
      const Eigen::Vector3f point = picture.point(x, y);
      const float z_m = 1e-3F * point.z();
      samples.push_back({point, *normal, z_m * z_m, 4.0F + 1.5F * axial_noise_mm(point.z())});
    }
  }
  return samples;
}

float area_on(const StartPlane& plane, const std::vector<Sample>& samples) {
  float area = 0.0F;
  for (const auto& sample : samples) {
    if (std::abs(plane.height_mm(sample.point)) < sample.reach_mm) area += sample.area;
  }
  return area;
}

/// The plane of least squares through the samples near `plane`; itself where they are few.
StartPlane refit(const StartPlane& plane, const std::vector<Sample>& samples, float reach) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  double total = 0.0;
  for (const auto& sample : samples) {
    if (std::abs(plane.height_mm(sample.point)) > reach * sample.reach_mm ||
        plane.normal.dot(sample.normal) < kAlikeCosine) {
      continue;
    }
    const Eigen::Vector3d p = sample.point.cast<double>();
    mean += sample.area * p;
    moments += sample.area * p * p.transpose();
    total += sample.area;
  }
  if (!(total > 0.0)) return plane;
  mean /= total;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(moments / total -
                                                            mean * mean.transpose());
  Eigen::Vector3d normal = axes.eigenvectors().col(0);
  if (normal.dot(mean) > 0.0) normal = -normal;  // The camera, at the origin, is above.
  StartPlane fitted = plane;
  fitted.normal = normal.cast<float>();
  fitted.offset_mm = static_cast<float>(normal.dot(mean));
  return fitted;
}

}  // namespace

std::vector<StartPlane> find_planes(const StartPicture& picture,
                                    const std::optional<Eigen::Vector3f>& up) {
  std::vector<Sample> samples = take_samples(picture);
  float total_area = 0.0F;
  for (const auto& sample : samples) total_area += sample.area;
  std::vector<StartPlane> planes;
  while (planes.size() < kMaxPlanes && !samples.empty()) {
    StartPlane best;
    const std::size_t step = std::max<std::size_t>(1, samples.size() / kMaxTrials);
    for (std::size_t i = 0; i < samples.size(); i += step) {
      StartPlane plane{samples[i].normal, samples[i].normal.dot(samples[i].point)};
      if (up && up->dot(plane.normal) < kLevelCosine) continue;
      plane.share = area_on(plane, samples) / total_area;
      if (plane.share > best.share) best = plane;
    }
    if (best.share < kMinShare) break;
    for (const float reach : {2.0F, 1.0F, 1.0F}) best = refit(best, samples, reach);
    best.share = area_on(best, samples) / total_area;
    if (best.share >= kMinShare) planes.push_back(best);
    std::erase_if(samples, [&best](const Sample& sample) {
      return std::abs(best.height_mm(sample.point)) < 2.0F * sample.reach_mm;
    });
  }
  std::stable_sort(planes.begin(), planes.end(), [](const StartPlane& a, const StartPlane& b) {
    return a.share > b.share;
  });
  return planes;
}

bool is_in_large_plane(const std::vector<StartPlane>& planes,
                       const Eigen::Vector3f& p,
                       float reach_mm) {
  return std::any_of(planes.begin(), planes.end(), [&](const StartPlane& plane) {
    return plane.share >= kLargePlane && std::abs(plane.height_mm(p)) < reach_mm;
  });
}

float share_below(const StartPicture& picture, const StartPlane& plane, float reach_mm) {
  int num_readings = 0;
  int num_below = 0;
  for (int y = 0; y < picture.z_mm.height(); ++y) {
    for (int x = 0; x < picture.z_mm.width(); ++x) {
      if (picture.z_mm(x, y) <= 0.0F) continue;
      ++num_readings;
      const float below_mm = -plane.height_mm(picture.point(x, y));
      const float least_mm = kLeastBelowMm + 3.0F * axial_noise_mm(picture.z_mm(x, y));
      if (below_mm > least_mm && below_mm < reach_mm) ++num_below;
    }
  }
  return num_readings == 0 ? 0.0F
                           : static_cast<float>(num_below) / static_cast<float>(num_readings);
}

std::vector<StartPlane> suppose_planes(const StartPicture& picture,
                                       const Eigen::Vector3f& up,
                                       float body_height_mm,
                                       float step_mm) {
  std::vector<float> heights_mm;
  const int step_px = std::max(1, picture.z_mm.width() / kNumSamplesWide);
  for (int y = step_px / 2; y < picture.z_mm.height(); y += step_px) {
    for (int x = step_px / 2; x < picture.z_mm.width(); x += step_px) {
      if (picture.z_mm(x, y) > 0.0F) heights_mm.push_back(up.dot(picture.point(x, y)));
    }
  }
  if (heights_mm.empty()) return {};
  const auto high = heights_mm.begin() + static_cast<std::ptrdiff_t>(heights_mm.size() / kHighest);
  std::nth_element(heights_mm.begin(), high, heights_mm.end(), std::greater<>());
  std::vector<StartPlane> planes;
  for (float shown_mm = kLeastShown * body_height_mm;
       shown_mm <= kMostShown * body_height_mm && planes.size() < kMaxSupposed;
       shown_mm += step_mm) {
    planes.push_back({up, *high - shown_mm, 0.0F, true});
  }
  return planes;
}

}  // namespace mor::internal
