// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/internal/frame_look.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace mor::internal {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;
using Eigen::Vector4f;

constexpr int kEdgePx = 2;        ///< So near to an outline a colour may be the other side's.
constexpr float kJumpMm = 22.0F;  ///< Within kEdgePx, more than skin seen at 70 degrees.
constexpr int kEvidencePx = 3;    ///< Readings within so many pixels speak for a place.
constexpr float kEvidenceShare = 0.25F;
constexpr float kSoftMm = 6.0F;  ///< Radius of each of two boxes: details below 12 mm go.

/// Least and greatest of the depths within kEdgePx; the least is 0 where there is none.
struct DepthRange {
  Image<float> least;
  Image<float> most;
};

DepthRange depth_range(const Image<float>& depth) {
  const int width = depth.width();
  const int height = depth.height();
  DepthRange across{Image<float>(width, height), Image<float>(width, height)};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      float least = depth(x, y);
      float most = least;
      for (int i = std::max(0, x - kEdgePx); i <= std::min(width - 1, x + kEdgePx); ++i) {
        least = std::min(least, depth(i, y));
        most = std::max(most, depth(i, y));
      }
      across.least(x, y) = least;
      across.most(x, y) = most;
    }
  }
  DepthRange range{across.least, across.most};
  for (int y = 0; y < height; ++y) {
    for (int i = std::max(0, y - kEdgePx); i <= std::min(height - 1, y + kEdgePx); ++i) {
      const float* least = across.least.view().row(i);
      const float* most = across.most.view().row(i);
      float* to_least = range.least.view().row(y);
      float* to_most = range.most.view().row(y);
      for (int x = 0; x < width; ++x) {
        to_least[x] = std::min(to_least[x], least[x]);
        to_most[x] = std::max(to_most[x], most[x]);
      }
    }
  }
  return range;
}

/// Sums of an image over boxes (Crow, "Summed-area tables", 1984).
class BoxSums {
 public:
  explicit BoxSums(const Image<std::uint8_t>& image)
      : width_(image.width()),
        height_(image.height()),
        sums_(image.width() + 1, image.height() + 1) {
    for (int y = 0; y < height_; ++y) {
      std::uint32_t row = 0;
      for (int x = 0; x < width_; ++x) {
        row += image(x, y);
        sums_(x + 1, y + 1) = sums_(x + 1, y) + row;
      }
    }
  }
  [[nodiscard]] std::uint32_t around(int x, int y, int radius) const {
    const int left = std::max(0, x - radius);
    const int right = std::min(width_, x + radius + 1);
    const int top = std::max(0, y - radius);
    const int bottom = std::min(height_, y + radius + 1);
    return sums_(right, bottom) - sums_(left, bottom) - sums_(right, top) + sums_(left, top);
  }

 private:
  int width_;
  int height_;
  Image<std::uint32_t> sums_;
};

Vector4f between(const Image<Vector4f>& image, float x, float y) {
  const float in_x = std::clamp(x, 0.0F, static_cast<float>(image.width() - 1) - 1e-3F);
  const float in_y = std::clamp(y, 0.0F, static_cast<float>(image.height() - 1) - 1e-3F);
  const int column = std::min(static_cast<int>(in_x), image.width() - 2);
  const int row = std::min(static_cast<int>(in_y), image.height() - 2);
  const float tx = in_x - static_cast<float>(column);
  const float ty = in_y - static_cast<float>(row);
  const Vector4f above = (1.0F - tx) * image(column, row) + tx * image(column + 1, row);
  const Vector4f below = (1.0F - tx) * image(column, row + 1) + tx * image(column + 1, row + 1);
  return (1.0F - ty) * above + ty * below;
}

Vector3f to_vector(const Rgb8& color) {
  return {static_cast<float>(color.r), static_cast<float>(color.g), static_cast<float>(color.b)};
}

/// One pass of a box along rows or columns, by running sums.
void box_blur(Image<Vector4f>& image, int radius, bool along_rows) {
  const int length = along_rows ? image.width() : image.height();
  const int lines = along_rows ? image.height() : image.width();
  const auto stride = along_rows ? std::ptrdiff_t{1} : std::ptrdiff_t{image.width()};
  std::vector<Vector4f> line(static_cast<std::size_t>(length));
  const float share = 1.0F / static_cast<float>(2 * radius + 1);
  for (int i = 0; i < lines; ++i) {
    Vector4f* first = along_rows ? &image(0, i) : &image(i, 0);
    for (int at = 0; at < length; ++at) line[static_cast<std::size_t>(at)] = first[at * stride];
    Vector4f sum = Vector4f::Zero();
    for (int at = 0; at < std::min(radius, length); ++at) sum += line[static_cast<std::size_t>(at)];
    for (int at = 0; at < length; ++at) {
      if (at + radius < length) sum += line[static_cast<std::size_t>(at + radius)];
      if (at - radius > 0) sum -= line[static_cast<std::size_t>(at - radius - 1)];
      first[at * stride] = share * sum;
    }
  }
}

}  // namespace

FrameLook::FrameLook(const RgbdFrame& frame,
                     const TriangleMesh& skin,
                     const Eigen::Isometry3d& color_from_ct,
                     const Options& options)
    : frame_(frame),
      color_camera_(frame.calibration->color),
      color_from_ct_(color_from_ct.cast<float>()),
      options_(options) {
  const double scale =
      std::min(1.0, frame.calibration->depth.focal_x_px / color_camera_.focal_x_px);
  look_camera_ = color_camera_.scaled(scale);
  look_camera_.distortion = {};
  look_camera_.width_px = std::max(look_camera_.width_px, 4);
  look_camera_.height_px = std::max(look_camera_.height_px, 4);
  color_scale_ = color_camera_.focal_x_px / look_camera_.focal_x_px;
  raster_ = rasterize_depth(skin, look_camera_, color_from_ct);
  is_skin_ = Image<std::uint8_t>(look_camera_.width_px, look_camera_.height_px, 0);
  compare_depth(frame, options);
  if (skin_share_ == 0.0) return;
  soften(frame);
}

void FrameLook::compare_depth(const RgbdFrame& frame, const Options& options) {
  const auto& calibration = *frame.calibration;
  const auto range = depth_range(raster_.depth_mm);
  const int width = look_camera_.width_px;
  const int height = look_camera_.height_px;
  Image<std::uint8_t> on_skin(width, height, 0);
  Image<std::uint8_t> before(width, height, 0);
  Image<std::uint8_t> behind(width, height, 0);
  const Eigen::Isometry3f color_from_depth = calibration.color_from_depth.cast<float>();
  const auto fx = static_cast<float>(look_camera_.focal_x_px);
  const auto fy = static_cast<float>(look_camera_.focal_y_px);
  const auto cx = static_cast<float>(look_camera_.center_x_px);
  const auto cy = static_cast<float>(look_camera_.center_y_px);
  const bool is_bent = calibration.depth.has_distortion();
  const auto tolerance = static_cast<float>(options.depth_tolerance_mm);
  for (int y = 0; y < frame.depth_mm.height(); ++y) {
    const float row_y =
        static_cast<float>((y - calibration.depth.center_y_px) / calibration.depth.focal_y_px);
    for (int x = 0; x < frame.depth_mm.width(); ++x) {
      const std::uint16_t reading = frame.depth_mm(x, y);
      if (reading == 0) continue;
      const Vector2f ray = is_bent
                               ? Vector2f(calibration.depth.ray({x, y}).cast<float>())
                               : Vector2f(static_cast<float>((x - calibration.depth.center_x_px) /
                                                             calibration.depth.focal_x_px),
                                          row_y);
      const auto z = static_cast<float>(reading);
      const Vector3f p = color_from_depth * Vector3f(z * ray.x(), z * ray.y(), z);
      if (p.z() < 1.0F) continue;
      const int u = static_cast<int>(std::lround(fx * p.x() / p.z() + cx));
      const int v = static_cast<int>(std::lround(fy * p.y() / p.z() + cy));
      if (u < 0 || v < 0 || u >= width || v >= height || raster_.depth_mm(u, v) <= 0.0F) continue;
      // The sensor's noise and steps grow with the distance.
      const float slack = tolerance + 0.004F * p.z();
      const float least = range.least(u, v) > 0.0F ? range.least(u, v) : raster_.depth_mm(u, v);
      if (p.z() < least - slack) {
        before(u, v) = 1;
      } else if (p.z() > range.most(u, v) + slack) {
        behind(u, v) = 1;
      } else {
        on_skin(u, v) = 1;
      }
    }
  }
  const BoxSums skin_sums(on_skin);
  const BoxSums before_sums(before);
  const BoxSums behind_sums(behind);
  constexpr std::uint32_t kEnough =
      static_cast<std::uint32_t>(kEvidenceShare * (2 * kEvidencePx + 1) * (2 * kEvidencePx + 1));
  // Lone readings out of place are noise.
  constexpr std::uint32_t kFewReadings = 3;
  double sum_mm = 0.0;
  std::size_t count = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float z = raster_.depth_mm(x, y);
      const float least = range.least(x, y);
      if (z <= 0.0F || least <= 0.0F || range.most(x, y) - least > kJumpMm) continue;
      const auto margin_px = static_cast<int>(
          std::ceil(options.clutter_margin_mm * look_camera_.focal_x_px / static_cast<double>(z)));
      const std::uint32_t num_on = skin_sums.around(x, y, kEvidencePx);
      if (num_on < kEnough || behind_sums.around(x, y, kEvidencePx) > num_on ||
          before_sums.around(x, y, margin_px) >= kFewReadings) {
        continue;
      }
      is_skin_(x, y) = 1;
      sum_mm += static_cast<double>(z);
      ++count;
    }
  }
  skin_share_ = static_cast<double>(count) / static_cast<double>(is_skin_.size());
  middle_distance_mm_ = count > 0 ? sum_mm / static_cast<double>(count) : 0.0;
}

/// Half-resolution means over the skin alone, twice through a box: what is beside it stays out.
void FrameLook::soften(const RgbdFrame& frame) {
  const int width = std::max(2, look_camera_.width_px / 2);
  const int height = std::max(2, look_camera_.height_px / 2);
  Image<Vector4f> sums(width, height, Vector4f::Zero());
  const bool is_bent = color_camera_.has_distortion();
  for (int y = 0; y < 2 * height; ++y) {
    for (int x = 0; x < 2 * width; ++x) {
      if (!is_skin_.view().contains(x, y) || is_skin_(x, y) == 0) continue;
      Vector2f at((static_cast<float>(x) + 0.5F) * static_cast<float>(color_scale_) - 0.5F,
                  (static_cast<float>(y) + 0.5F) * static_cast<float>(color_scale_) - 0.5F);
      if (is_bent) {
        const Eigen::Vector2d ray = look_camera_.ray({x, y});
        const auto bent = color_camera_.project({ray.x(), ray.y(), 1.0});
        if (!bent) continue;
        at = bent->cast<float>();
      }
      const int column = static_cast<int>(std::lround(at.x()));
      const int row = static_cast<int>(std::lround(at.y()));
      if (!frame.color.view().contains(column, row)) continue;
      Vector4f value;
      value << to_vector(frame.color(column, row)), 1.0F;
      sums(x / 2, y / 2) += 0.25F * value;
    }
  }
  const double radius_px = kSoftMm * look_camera_.focal_x_px / middle_distance_mm_ / 2.0;
  const int radius = std::clamp(static_cast<int>(std::lround(radius_px)), 1, 40);
  for (int pass = 0; pass < 2; ++pass) {
    box_blur(sums, radius, true);
    box_blur(sums, radius, false);
  }
  soft_ = std::move(sums);
}

std::optional<SkinSight> FrameLook::sight(const Vector3f& at_ct, const Vector3f& normal) const {
  const Vector3f p = color_from_ct_ * at_ct;
  if (p.z() < 1.0F) return std::nullopt;
  const float inverse_z = 1.0F / p.z();
  SkinSight sight;
  sight.look_px = {static_cast<float>(look_camera_.focal_x_px) * p.x() * inverse_z +
                       static_cast<float>(look_camera_.center_x_px),
                   static_cast<float>(look_camera_.focal_y_px) * p.y() * inverse_z +
                       static_cast<float>(look_camera_.center_y_px)};
  const int x = static_cast<int>(sight.look_px.x() + 0.5F);
  const int y = static_cast<int>(sight.look_px.y() + 0.5F);
  if (!(sight.look_px.x() >= 0.0F && sight.look_px.y() >= 0.0F) ||
      !is_skin_.view().contains(x, y) || is_skin_(x, y) == 0) {
    return std::nullopt;
  }
  sight.distance_mm = p.norm();
  sight.cosine = -(color_from_ct_.linear() * normal).dot(p) / sight.distance_mm;
  if (sight.cosine < options_.least_cosine) return std::nullopt;
  // Jumps are not skin, so that what is hidden here lies far behind.
  const float pixel_mm = p.z() / static_cast<float>(look_camera_.focal_x_px);
  if (p.z() > raster_.depth_mm(x, y) + 4.0F + 2.0F * pixel_mm / sight.cosine) return std::nullopt;
  if (color_camera_.has_distortion()) {
    const auto bent = color_camera_.project(p.cast<double>());
    if (!bent) return std::nullopt;
    sight.color_px = bent->cast<float>();
  } else {
    const auto scale = static_cast<float>(color_scale_);
    sight.color_px = (sight.look_px + Vector2f::Constant(0.5F)) * scale - Vector2f::Constant(0.5F);
  }
  if (!(sight.color_px.x() >= 1.0F && sight.color_px.y() >= 1.0F &&
        sight.color_px.x() <= static_cast<float>(frame_.color.width() - 2) &&
        sight.color_px.y() <= static_cast<float>(frame_.color.height() - 2))) {
    return std::nullopt;
  }
  sight.px_per_mm = static_cast<float>(color_camera_.focal_x_px) / sight.distance_mm * sight.cosine;
  return sight;
}

Vector3f FrameLook::color(const SkinSight& sight) const {
  const int column = static_cast<int>(sight.color_px.x());
  const int row = static_cast<int>(sight.color_px.y());
  const float tx = sight.color_px.x() - static_cast<float>(column);
  const float ty = sight.color_px.y() - static_cast<float>(row);
  const Rgb8* above = frame_.color.view().row(row) + column;
  const Rgb8* below = frame_.color.view().row(row + 1) + column;
  return (1.0F - ty) * ((1.0F - tx) * to_vector(above[0]) + tx * to_vector(above[1])) +
         ty * ((1.0F - tx) * to_vector(below[0]) + tx * to_vector(below[1]));
}

Vector4f FrameLook::soft_color(const SkinSight& sight) const {
  Vector4f sum =
      between(soft_, 0.5F * (sight.look_px.x() - 0.5F), 0.5F * (sight.look_px.y() - 0.5F));
  if (sum.w() < 0.02F) return Vector4f::Zero();
  sum.head<3>() /= sum.w();
  return sum;
}

}  // namespace mor::internal
