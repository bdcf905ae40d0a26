// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/tracking/skin_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace mor {
namespace {

/// Cosine between normal and ray. Skin seen at a flatter angle is left out: near the outline a pose
/// that is right to a millimetre still puts it beside the body.
constexpr float kMinFacing = 0.45F;

/// A patch of the picture: 3 pixels to each side of a Kinect's, as wide in others; readings of one
/// surface, from most of it.
constexpr double kPatchPerFocal = 3.0 / 525.0;
constexpr float kPatchStepMm = 15.0F;
constexpr float kMinPatchShare = 0.6F;
/// Seen flatter than this, a patch's average says little.
constexpr float kMinPatchFacing = 0.6F;
/// Across the surface, of a Kinect up to 800 mm: averages of a patch scatter by 0.4 mm there.
/// Beyond it, and with a coarser picture, the steps of the disparity count: they grow as z^2 /
/// focal.
constexpr float kBehindMm = 1.5F;
constexpr float kBehindFocalPx = 525.0F;
constexpr float kBehindDistanceMm = 800.0F;

float behind_limit_mm(float z_mm, float focal_px) {
  const float distances = z_mm / kBehindDistanceMm;
  return kBehindMm * std::max(1.0F, distances * distances * kBehindFocalPx / focal_px);
}

double share(int part, int whole) {
  return whole > 0 ? static_cast<double>(part) / whole : 0.0;
}

/// The nearest of the readings two pixels away in each direction. 0 where there is none.
float nearest_around(ImageView<const std::uint16_t> depth_mm, int x, int y) {
  constexpr int kReachPx = 2;
  float nearest_mm = std::numeric_limits<float>::infinity();
  const auto look = [&](int at_x, int at_y) {
    if (at_x < 0 || at_y < 0 || at_x >= depth_mm.width() || at_y >= depth_mm.height()) return;
    const float reading_mm = depth_mm(at_x, at_y);
    if (reading_mm > 0.0F) nearest_mm = std::min(nearest_mm, reading_mm);
  };
  look(x - kReachPx, y);
  look(x + kReachPx, y);
  look(x, y - kReachPx);
  look(x, y + kReachPx);
  return std::isfinite(nearest_mm) ? nearest_mm : 0.0F;
}

/// The mean of the readings around a pixel; none at an edge of the surface or the picture.
std::optional<float> patch_average(ImageView<const std::uint16_t> depth_mm,
                                   int x,
                                   int y,
                                   int reach_px) {
  if (x < reach_px || y < reach_px || x + reach_px >= depth_mm.width() ||
      y + reach_px >= depth_mm.height()) {
    return std::nullopt;
  }
  const float center_mm = depth_mm(x, y);
  float sum = 0.0F;
  float count = 0.0F;
  for (int row = y - reach_px; row <= y + reach_px; ++row) {
    const std::uint16_t* readings = depth_mm.row(row);
    for (int column = x - reach_px; column <= x + reach_px; ++column) {
      const float reading_mm = readings[column];
      if (!(std::abs(reading_mm - center_mm) <= kPatchStepMm)) continue;
      sum += reading_mm;
      count += 1.0F;
    }
  }
  const auto side = static_cast<float>(2 * reach_px + 1);
  if (count < kMinPatchShare * side * side) return std::nullopt;
  return sum / count;
}

}  // namespace

double SkinEvidence::seen_fraction() const {
  return share(num_seen, num_expected);
}

double SkinEvidence::behind_fraction() const {
  return share(num_behind, num_patches);
}

double SkinEvidence::seen_share() const {
  return share(num_seen, num_samples);
}

double SkinEvidence::floating_fraction() const {
  return share(num_floating, num_seen + num_floating);
}

SkinSamples::SkinSamples(const TriangleMesh& skin, std::size_t count) {
  const std::size_t stride = std::max<std::size_t>(1, skin.vertices.size() / count);
  for (std::size_t i = 0; i < skin.vertices.size(); i += stride) {
    points_.push_back(skin.vertices[i]);
    normals_.push_back(skin.normals[i]);
  }
}

SkinEvidence SkinSamples::compare(ImageView<const std::uint16_t> depth_mm,
                                  const PinholeCamera& camera,
                                  const Eigen::Isometry3d& ct_from_depth,
                                  double tolerance_mm) const {
  const Eigen::Matrix3f rotation = ct_from_depth.linear().transpose().cast<float>();
  const Eigen::Vector3f eye_ct = ct_from_depth.translation().cast<float>();
  const auto tolerance = static_cast<float>(tolerance_mm);
  const auto focal_px = static_cast<float>(camera.focal_x_px);
  const int patch_px =
      std::max(1, static_cast<int>(std::lround(kPatchPerFocal * camera.focal_x_px)));
  SkinEvidence evidence;
  evidence.num_samples = static_cast<int>(points_.size());
  Eigen::Vector3f seen_sum = Eigen::Vector3f::Zero();
  float seen_sum_sq = 0.0F;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Eigen::Vector3f ray = points_[i] - eye_ct;
    const float facing = -normals_[i].dot(ray) / ray.norm();
    if (!(facing >= kMinFacing)) continue;
    const Eigen::Vector3f point = rotation * ray;
    const auto pixel = camera.project(point.cast<double>());
    // Compared before the cast: a pixel far outside has no integer.
    if (!pixel || !(pixel->x() > -0.5 && pixel->y() > -0.5 && pixel->x() < camera.width_px - 0.5 &&
                    pixel->y() < camera.height_px - 0.5)) {
      continue;
    }
    const int x = static_cast<int>(std::lround(pixel->x()));
    const int y = static_cast<int>(std::lround(pixel->y()));
    const float reading_mm = depth_mm(x, y);
    if (reading_mm == 0.0F) continue;
    ++evidence.num_expected;
    if (reading_mm < point.z() - tolerance) {
      ++evidence.num_covered;
    } else if (reading_mm > point.z() + tolerance) {
      // At an outline the skin is there a pixel further.
      if (nearest_around(depth_mm, x, y) > point.z() + tolerance) ++evidence.num_floating;
    } else {
      ++evidence.num_seen;
      const Eigen::Vector3f seen = points_[i] - points_[0];
      seen_sum += seen;
      seen_sum_sq += seen.squaredNorm();
      if (facing < kMinPatchFacing) continue;
      if (const auto patch_mm = patch_average(depth_mm, x, y, patch_px)) {
        ++evidence.num_patches;
        const float behind_mm = facing * (*patch_mm - point.z());
        if (behind_mm > behind_limit_mm(point.z(), focal_px)) ++evidence.num_behind;
      }
    }
  }
  if (evidence.num_seen > 0) {
    const auto count = static_cast<float>(evidence.num_seen);
    const Eigen::Vector3f mean = seen_sum / count;
    evidence.seen_center_mm = (points_[0] + mean).cast<double>();
    evidence.seen_radius_mm =
        static_cast<double>(std::sqrt(std::max(0.0F, seen_sum_sq / count - mean.squaredNorm())));
  }
  return evidence;
}

}  // namespace mor
