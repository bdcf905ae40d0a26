// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/body_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mor {
namespace {

constexpr double kMargin = 0.06;      ///< Of the picture, around the body.
constexpr double kAllowanceMm = 6.0;  ///< Behind the skin and still taken for visible.
constexpr int kSamples = 2;           ///< Along each side of a pixel.
constexpr float kInf = std::numeric_limits<float>::infinity();

struct Axes {
  Eigen::Vector3d right;
  Eigen::Vector3d down;
  std::array<std::string_view, 4> letters;
};

/// LPS: x to the left, y to the back, z to the head.
Axes axes_of(BodyView view) {
  const Eigen::Vector3d left = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d back = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d head = Eigen::Vector3d::UnitZ();
  switch (view) {
    case BodyView::kAnterior:
      return {left, -head, {"R", "L", "H", "F"}};
    case BodyView::kPosterior:
      return {-left, -head, {"L", "R", "H", "F"}};
    case BodyView::kLeft:  // The face looks to the picture's left.
      return {back, -head, {"A", "P", "H", "F"}};
    case BodyView::kRight:
      return {-back, -head, {"P", "A", "H", "F"}};
    case BodyView::kHead:
      return {left, -back, {"R", "L", "P", "A"}};
    case BodyView::kFeet:
      return {left, back, {"R", "L", "A", "P"}};
  }
  return {left, -head, {"R", "L", "H", "F"}};
}

/// Fills a finer picture than the one asked for.
class Painter {
 public:
  Painter(const ExportModel& model, const BodyPicture& shape, int width, int height)
      : model_(model),
        color_(width, height, Rgb8{255, 255, 255}),
        depth_(width, height, kInf),
        view_from_ct_(shape.view_from_ct.cast<float>()),
        middle_(shape.middle_ct_mm.cast<float>()),
        px_per_mm_(static_cast<float>(kSamples / shape.mm_per_px)) {}

  void paint() {
    const auto& mesh = model_.skin.mesh;
    places_.reserve(mesh.vertices.size());
    for (const auto& vertex : mesh.vertices) {
      Eigen::Vector3f place = view_from_ct_ * (vertex - middle_);
      place.x() = place.x() * px_per_mm_ + 0.5F * static_cast<float>(color_.width() - 1);
      place.y() = place.y() * px_per_mm_ + 0.5F * static_cast<float>(color_.height() - 1);
      places_.push_back(place);
    }
    for (const auto& triangle : mesh.triangles) paint_triangle(triangle);
  }

  const Image<Rgb8>& color() const { return color_; }
  const Image<float>& depth() const { return depth_; }

 private:
  void paint_triangle(const Triangle& t) {
    const auto &a = places_[t[0]], &b = places_[t[1]], &c = places_[t[2]];
    const float area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    if (area == 0.0F) return;
    const int x0 = std::max(0, static_cast<int>(std::ceil(std::min({a.x(), b.x(), c.x()}))));
    const int y0 = std::max(0, static_cast<int>(std::ceil(std::min({a.y(), b.y(), c.y()}))));
    const int x1 =
        std::min(color_.width() - 1, static_cast<int>(std::floor(std::max({a.x(), b.x(), c.x()}))));
    const int y1 = std::min(color_.height() - 1,
                            static_cast<int>(std::floor(std::max({a.y(), b.y(), c.y()}))));
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const auto px = static_cast<float>(x);
        const auto py = static_cast<float>(y);
        const float v = ((px - a.x()) * (c.y() - a.y()) - (py - a.y()) * (c.x() - a.x())) / area;
        const float w = ((b.x() - a.x()) * (py - a.y()) - (b.y() - a.y()) * (px - a.x())) / area;
        const float u = 1.0F - v - w;
        if (u < 0.0F || v < 0.0F || w < 0.0F) continue;
        const float depth = u * a.z() + v * b.z() + w * c.z();
        if (depth >= depth_(x, y)) continue;
        depth_(x, y) = depth;
        color_(x, y) = shade(t, {u, v, w});
      }
    }
  }

  Rgb8 shade(const Triangle& t, const Eigen::Vector3f& share) const {
    const auto& mesh = model_.skin.mesh;
    const Eigen::Vector3f normal = (share[0] * mesh.normals[t[0]] + share[1] * mesh.normals[t[1]] +
                                    share[2] * mesh.normals[t[2]])
                                       .stableNormalized();
    const float facing = -(view_from_ct_ * normal).z();
    if (facing < 0.0F) return {92, 74, 70};  // The skin from inside, where the CT ends.
    const bool is_textured = !model_.skin.picture_px.empty();
    Rgb8 color = model_.skin.color;
    if (is_textured) {
      const auto& px = model_.skin.picture_px;
      color = sample_picture(model_.picture,
                             share[0] * px[t[0]] + share[1] * px[t[1]] + share[2] * px[t[2]]);
    }
    // A photograph brings its own light; a plain surface needs ours.
    const float light = is_textured ? 0.70F + 0.30F * facing : 0.38F + 0.62F * facing;
    const auto dim = [&](std::uint8_t value) {
      return static_cast<std::uint8_t>(std::lround(static_cast<float>(value) * light));
    };
    return {dim(color.r), dim(color.g), dim(color.b)};
  }

  const ExportModel& model_;
  Image<Rgb8> color_;
  Image<float> depth_;
  Eigen::Matrix3f view_from_ct_;
  Eigen::Vector3f middle_;
  float px_per_mm_;
  std::vector<Eigen::Vector3f> places_;
};

void average(const Painter& painter, BodyPicture& result) {
  for (int y = 0; y < result.picture.height(); ++y) {
    for (int x = 0; x < result.picture.width(); ++x) {
      std::array<int, 3> sum{};
      float nearest = kInf;
      for (int dy = 0; dy < kSamples; ++dy) {
        for (int dx = 0; dx < kSamples; ++dx) {
          const Rgb8 color = painter.color()(x * kSamples + dx, y * kSamples + dy);
          sum = {sum[0] + color.r, sum[1] + color.g, sum[2] + color.b};
          nearest = std::min(nearest, painter.depth()(x * kSamples + dx, y * kSamples + dy));
        }
      }
      constexpr int kCount = kSamples * kSamples;
      const auto mean = [](int channel) {
        return static_cast<std::uint8_t>((channel + kCount / 2) / kCount);
      };
      result.picture(x, y) = {mean(sum[0]), mean(sum[1]), mean(sum[2])};
      result.depth_mm(x, y) = nearest;
    }
  }
}

}  // namespace

std::string_view to_string(BodyView view) {
  constexpr std::array<std::string_view, 6> kNames = {
      "anterior", "posterior", "left", "right", "head", "feet"};
  return kNames[static_cast<std::size_t>(view)];
}

Eigen::Vector2d BodyPicture::place_px(const Eigen::Vector3d& ct_mm) const {
  const Eigen::Vector3d place = view_from_ct * (ct_mm - middle_ct_mm) / mm_per_px;
  return {place.x() + 0.5 * (picture.width() - 1), place.y() + 0.5 * (picture.height() - 1)};
}

bool BodyPicture::is_visible(const Eigen::Vector3d& ct_mm) const {
  const Eigen::Vector2d place = place_px(ct_mm);
  const int x = static_cast<int>(std::lround(place.x()));
  const int y = static_cast<int>(std::lround(place.y()));
  if (!picture.view().contains(x, y)) return false;
  const double depth = (view_from_ct * (ct_mm - middle_ct_mm)).z();
  return depth <= static_cast<double>(depth_mm(x, y)) + kAllowanceMm;
}

BodyPicture draw_body(const ExportModel& model, BodyView view, int width_px, int height_px) {
  const Axes axes = axes_of(view);
  BodyPicture result;
  result.view_from_ct << axes.right.transpose(), axes.down.transpose(),
      axes.right.cross(axes.down).transpose();
  result.letters = axes.letters;
  const auto box = model.skin.mesh.bounds();
  result.middle_ct_mm = box.center().cast<double>();
  Eigen::Vector3d size_mm =
      (result.view_from_ct * box.sizes().cast<double>()).cwiseAbs().cwiseMax(1.0);
  // One scale for all pictures from the sides.
  if (view != BodyView::kHead && view != BodyView::kFeet)
    size_mm.x() = std::max<double>(box.sizes().x(), box.sizes().y());
  const double room = 1.0 - 2.0 * kMargin;
  result.mm_per_px = std::max(size_mm.x() / (room * width_px), size_mm.y() / (room * height_px));
  result.picture = Image<Rgb8>(width_px, height_px);
  result.depth_mm = Image<float>(width_px, height_px);
  Painter painter(model, result, width_px * kSamples, height_px * kSamples);
  painter.paint();
  average(painter, result);
  return result;
}

}  // namespace mor
