// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/internal/atlas_picture.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "morgagni/evaluation/internal/color_difference.h"
#include "morgagni/geometry/depth_raster.h"

namespace mor::internal {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr int kPatchRadius = 8;
constexpr int kPatchStep = 8;
constexpr double kFewSlopes = 1500.0;  ///< Least eigenvalue of a patch's gradient matrix.
constexpr float kFarthestPx = 6.0F;

float brightness(const Vector3f& color) {
  return 0.3F * color.x() + 0.59F * color.y() + 0.11F * color.z();
}

float turn(const Vector2f& u, const Vector2f& v) {
  return u.x() * v.y() - u.y() * v.x();
}

Vector3f to_vector(const Rgb8& color) {
  return {static_cast<float>(color.r), static_cast<float>(color.g), static_cast<float>(color.b)};
}

Vector3f color_between(const Image<Rgb8>& image, const Vector2f& at) {
  const int x = std::clamp(static_cast<int>(at.x()), 0, image.width() - 2);
  const int y = std::clamp(static_cast<int>(at.y()), 0, image.height() - 2);
  const float tx = at.x() - static_cast<float>(x);
  const float ty = at.y() - static_cast<float>(y);
  return (1.0F - ty) * ((1.0F - tx) * to_vector(image(x, y)) + tx * to_vector(image(x + 1, y))) +
         ty * ((1.0F - tx) * to_vector(image(x, y + 1)) + tx * to_vector(image(x + 1, y + 1)));
}

double median_of(std::vector<float>& values) {
  if (values.empty()) return 1.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

/// What brings `picture` to `truth`, a channel.
Vector3f gains_to(const AtlasPicture& picture, const AtlasPicture& truth) {
  Vector3f gains;
  for (int channel = 0; channel < 3; ++channel) {
    std::vector<float> ratios;
    for (std::size_t i = 0; i < picture.color.size(); ++i) {
      const float value = picture.color.data()[i][channel];
      if (picture.quality.data()[i] <= 0.0F || truth.quality.data()[i] <= 0.0F || value < 1.0F) {
        continue;
      }
      ratios.push_back(truth.color.data()[i][channel] / value);
    }
    gains[channel] = static_cast<float>(median_of(ratios));
  }
  return gains;
}

/// Shifts of the patch around a texel, until it lies on the truth.
class PatchMatch {
 public:
  PatchMatch(const Image<float>& picture, const Image<float>& truth, const AtlasPicture& has_truth)
      : picture_(picture), truth_(truth), has_truth_(has_truth) {}

  /// None where there is too little to match, or it does not come to rest.
  [[nodiscard]] std::optional<double> shift_px(int x, int y, const AtlasPicture& has) const {
    for (int dy = -kPatchRadius; dy <= kPatchRadius; ++dy) {
      for (int dx = -kPatchRadius; dx <= kPatchRadius; ++dx) {
        if (!has.has(x + dx, y + dy) || !has_truth_.has(x + dx, y + dy)) return std::nullopt;
      }
    }
    Vector2f shift = Vector2f::Zero();
    for (int iteration = 0; iteration < 20; ++iteration) {
      const auto step = step_at(x, y, shift);
      if (!step) return std::nullopt;
      shift += *step;
      if (shift.norm() > kFarthestPx) return std::nullopt;
      if (step->norm() < 0.01F) return static_cast<double>(shift.norm());
    }
    return std::nullopt;
  }

 private:
  [[nodiscard]] std::optional<float> truth_at(float x, float y) const {
    const int column = static_cast<int>(std::floor(x));
    const int row = static_cast<int>(std::floor(y));
    for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
      if (!truth_.view().contains(column + dx, row + dy) ||
          !has_truth_.has(column + dx, row + dy)) {
        return std::nullopt;
      }
    }
    const float tx = x - static_cast<float>(column);
    const float ty = y - static_cast<float>(row);
    return (1 - ty) * ((1 - tx) * truth_(column, row) + tx * truth_(column + 1, row)) +
           ty * ((1 - tx) * truth_(column, row + 1) + tx * truth_(column + 1, row + 1));
  }

  [[nodiscard]] std::optional<Vector2f> step_at(int x, int y, const Vector2f& shift) const {
    Eigen::Matrix2d matrix = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    double offset = 0.0;
    double slope_x = 0.0;
    double slope_y = 0.0;
    std::size_t count = 0;
    for (int dy = -kPatchRadius; dy <= kPatchRadius; ++dy) {
      for (int dx = -kPatchRadius; dx <= kPatchRadius; ++dx) {
        const float at_x = static_cast<float>(x + dx) + shift.x();
        const float at_y = static_cast<float>(y + dy) + shift.y();
        const auto here = truth_at(at_x, at_y);
        const auto left = truth_at(at_x - 1, at_y);
        const auto more_right = truth_at(at_x + 1, at_y);
        const auto above = truth_at(at_x, at_y - 1);
        const auto below = truth_at(at_x, at_y + 1);
        if (!here || !left || !more_right || !above || !below) continue;
        const Eigen::Vector2d slope(0.5 * (*more_right - *left), 0.5 * (*below - *above));
        const double difference = picture_(x + dx, y + dy) - *here;
        matrix += slope * slope.transpose();
        right += difference * slope;
        offset += difference;
        slope_x += slope.x();
        slope_y += slope.y();
        ++count;
      }
    }
    if (count < 100) return std::nullopt;
    // The patch's mean brightness may differ: it is eliminated.
    const auto n = static_cast<double>(count);
    const Eigen::Vector2d mean(slope_x / n, slope_y / n);
    matrix -= n * mean * mean.transpose();
    right -= offset * mean;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(matrix);
    if (eigen.eigenvalues().x() < kFewSlopes) return std::nullopt;
    return Vector2f(matrix.ldlt().solve(right).cast<float>());
  }

  const Image<float>& picture_;
  const Image<float>& truth_;
  const AtlasPicture& has_truth_;
};

Image<float> brightness_of(const AtlasPicture& picture, const Vector3f& gains) {
  Image<float> result(picture.color.width(), picture.color.height(), 0.0F);
  for (std::size_t i = 0; i < result.size(); ++i) {
    result.data()[i] = brightness(picture.color.data()[i].cwiseProduct(gains));
  }
  return result;
}

}  // namespace

AtlasPicture empty_picture(const SkinAtlas& atlas) {
  return {Image<Vector3f>(atlas.width_px, atlas.height_px, Vector3f::Zero()),
          Image<float>(atlas.width_px, atlas.height_px, 0.0F)};
}

std::vector<AtlasPlace> atlas_places(const SkinAtlas& atlas) {
  std::vector<AtlasPlace> places;
  for (std::size_t i = 0; i < atlas.corners_px.size(); ++i) {
    const auto& [a, b, c] = atlas.corners_px[i];
    const float area = turn(b - a, c - a);
    if (area == 0.0F) continue;
    const auto& corners = atlas.mesh.triangles[i];
    const Vector2f low = a.cwiseMin(b).cwiseMin(c);
    const Vector2f high = a.cwiseMax(b).cwiseMax(c);
    for (int y = static_cast<int>(std::ceil(low.y())); y <= high.y(); ++y) {
      for (int x = static_cast<int>(std::ceil(low.x())); x <= high.x(); ++x) {
        const Vector2f p(static_cast<float>(x), static_cast<float>(y));
        const float wa = turn(b - p, c - p) / area;
        const float wb = turn(c - p, a - p) / area;
        const float wc = 1.0F - wa - wb;
        if (wa < 0.0F || wb < 0.0F || wc < 0.0F) continue;
        const auto mix = [&](const std::vector<Vector3f>& of) -> Vector3f {
          return wa * of[corners[0]] + wb * of[corners[1]] + wc * of[corners[2]];
        };
        places.push_back({static_cast<std::uint32_t>(y * atlas.width_px + x),
                          mix(atlas.mesh.vertices),
                          mix(atlas.mesh.normals).normalized()});
      }
    }
  }
  return places;
}

void project_onto(const RgbdFrame& frame,
                  const Eigen::Isometry3d& color_from_ct,
                  const SkinAtlas& atlas,
                  const std::vector<AtlasPlace>& places,
                  AtlasPicture& picture) {
  constexpr float kLeastCosine = 0.342F;
  constexpr float kHiddenMm = 5.0F;
  const auto& camera = frame.calibration->color;
  const auto raster = rasterize_depth(atlas.mesh, camera, color_from_ct);
  const Eigen::Isometry3f to_camera = color_from_ct.cast<float>();
  for (const auto& place : places) {
    const Vector3f p = to_camera * place.at_mm;
    const auto seen = camera.project(p.cast<double>());
    if (!seen) continue;
    const Vector2f at = seen->cast<float>();
    const int x = static_cast<int>(std::lround(at.x()));
    const int y = static_cast<int>(std::lround(at.y()));
    if (x < 1 || y < 1 || x + 1 >= camera.width_px || y + 1 >= camera.height_px) continue;
    const float distance_mm = p.norm();
    const float cosine = -(to_camera.linear() * place.normal).dot(p) / distance_mm;
    if (cosine < kLeastCosine || raster.depth_mm(x, y) <= 0.0F ||
        p.z() > raster.depth_mm(x, y) + kHiddenMm) {
      continue;
    }
    const float quality = static_cast<float>(camera.focal_x_px) / distance_mm * cosine;
    if (quality <= picture.quality.data()[place.pixel]) continue;
    picture.quality.data()[place.pixel] = quality;
    picture.color.data()[place.pixel] = color_between(frame.color, at);
  }
}

AtlasPicture as_picture(const SkinTexture& texture) {
  auto picture = empty_picture(*texture.atlas);
  for (std::size_t i = 0; i < picture.color.size(); ++i) {
    const auto& source = texture.sources.data()[i];
    if (source.frame == TexelSource::kNeverSeen) continue;
    picture.color.data()[i] = to_vector(texture.color.data()[i]);
    picture.quality.data()[i] = source.px_per_mm;
  }
  return picture;
}

AtlasComparison compare_pictures(const AtlasPicture& picture, const AtlasPicture& truth) {
  AtlasComparison result;
  const Vector3f gains = gains_to(picture, truth);
  for (std::size_t i = 0; i < picture.color.size(); ++i) {
    if (picture.quality.data()[i] <= 0.0F || truth.quality.data()[i] <= 0.0F) continue;
    ++result.num_texels;
    const Vector3f leveled = picture.color.data()[i].cwiseProduct(gains);
    result.color_difference.push_back(
        ciede2000(lab_from_srgb(leveled.cast<double>()),
                  lab_from_srgb(truth.color.data()[i].cast<double>())));
  }
  const Image<float> of_picture = brightness_of(picture, gains);
  const Image<float> of_truth = brightness_of(truth, Vector3f::Ones());
  const PatchMatch match(of_picture, of_truth, truth);
  for (int y = kPatchRadius; y + kPatchRadius < of_truth.height(); y += kPatchStep) {
    for (int x = kPatchRadius; x + kPatchRadius < of_truth.width(); x += kPatchStep) {
      if (const auto shift = match.shift_px(x, y, picture)) {
        result.misplacement_px.push_back(*shift);
      }
    }
  }
  return result;
}

GradientEnergy gradient_energy(const AtlasPicture& a, const AtlasPicture& b, float least_quality) {
  std::vector<float> ratios;
  for (std::size_t i = 0; i < a.color.size(); ++i) {
    const float of_b = brightness(b.color.data()[i]);
    if (a.quality.data()[i] <= 0.0F || b.quality.data()[i] < least_quality || of_b < 1.0F) continue;
    ratios.push_back(brightness(a.color.data()[i]) / of_b);
  }
  const double gain = median_of(ratios);
  GradientEnergy energy;
  const auto add_step = [&](int x, int y, int to_x, int to_y) {
    const auto is_good = [&](int at_x, int at_y) {
      return a.has(at_x, at_y) && b.has(at_x, at_y) && b.quality(at_x, at_y) >= least_quality;
    };
    if (!is_good(x, y) || !is_good(to_x, to_y)) return;
    const double in_a = brightness(a.color(to_x, to_y)) - brightness(a.color(x, y));
    const double in_b = gain * (brightness(b.color(to_x, to_y)) - brightness(b.color(x, y)));
    energy.of_a += in_a * in_a;
    energy.of_b += in_b * in_b;
    ++energy.num_steps;
  };
  for (int y = 0; y + 1 < a.color.height(); ++y) {
    for (int x = 0; x + 1 < a.color.width(); ++x) {
      add_step(x, y, x + 1, y);
      add_step(x, y, x, y + 1);
    }
  }
  return energy;
}

}  // namespace mor::internal
