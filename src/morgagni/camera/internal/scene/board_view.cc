// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/scene/board_view.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "morgagni/camera/internal/random.h"

namespace mor::internal {
namespace {

constexpr double kBackgroundMm = 2400.0;
constexpr double kBoardThicknessMm = 3.0;
constexpr float kWallBrightness = 190.0F;
constexpr int kRaysASide = 3;

Image<float> halved(const Image<float>& image) {
  Image<float> half(std::max(1, image.width() / 2), std::max(1, image.height() / 2));
  const auto at = [&](int x, int y) {
    return image(std::min(x, image.width() - 1), std::min(y, image.height() - 1));
  };
  for (int y = 0; y < half.height(); ++y) {
    for (int x = 0; x < half.width(); ++x) {
      half(x, y) = 0.25F * (at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) + at(2 * x, 2 * y + 1) +
                            at(2 * x + 1, 2 * y + 1));
    }
  }
  return half;
}

float bilinear(const Image<float>& image, double x, double y) {
  const double cx = std::clamp(x, 0.0, image.width() - 1.001);
  const double cy = std::clamp(y, 0.0, image.height() - 1.001);
  const int x0 = static_cast<int>(cx);
  const int y0 = static_cast<int>(cy);
  const auto fx = static_cast<float>(cx - x0);
  const auto fy = static_cast<float>(cy - y0);
  const int x1 = std::min(x0 + 1, image.width() - 1);
  const int y1 = std::min(y0 + 1, image.height() - 1);
  const float above = image(x0, y0) + fx * (image(x1, y0) - image(x0, y0));
  const float below = image(x0, y1) + fx * (image(x1, y1) - image(x0, y1));
  return above + fy * (below - above);
}

/// A Gaussian, along rows and then along columns.
void blur(Image<float>& image, double sd_px) {
  if (!(sd_px > 0.05)) return;
  const int reach = static_cast<int>(std::ceil(3.0 * sd_px));
  std::vector<float> weights;
  float sum = 0.0F;
  for (int k = -reach; k <= reach; ++k) {
    weights.push_back(static_cast<float>(std::exp(-0.5 * k * k / (sd_px * sd_px))));
    sum += weights.back();
  }
  for (float& weight : weights) weight /= sum;
  const auto pass = [&](int step_x, int step_y) {
    Image<float> result(image.width(), image.height());
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        float value = 0.0F;
        for (int k = -reach; k <= reach; ++k) {
          value += weights[static_cast<std::size_t>(k + reach)] *
                   image(std::clamp(x + k * step_x, 0, image.width() - 1),
                         std::clamp(y + k * step_y, 0, image.height() - 1));
        }
        result(x, y) = value;
      }
    }
    image = std::move(result);
  };
  pass(1, 0);
  pass(0, 1);
}

/// The board's plane in a camera: where a ray (x, y, 1) meets it.
struct Plane {
  explicit Plane(const Eigen::Isometry3d& camera_from_board)
      : normal(camera_from_board.linear().col(2)),
        distance_mm(normal.dot(camera_from_board.translation())),
        board_from_camera(camera_from_board.inverse()) {}

  /// Depth along the ray; none where the plane is not before the camera.
  [[nodiscard]] std::optional<double> depth_mm(const Eigen::Vector2d& ray) const {
    const double along = normal.dot(ray.homogeneous());
    const double z_mm = distance_mm / along;
    if (!(std::abs(along) > 1e-6) || !(z_mm > 0.0)) return std::nullopt;
    return z_mm;
  }

  Eigen::Vector3d normal;
  double distance_mm;
  Eigen::Isometry3d board_from_camera;
};

/// Soft stripes, so that what is behind the board is no even grey.
float background(const Eigen::Vector2d& ray) {
  return static_cast<float>(105.0 + 22.0 * std::sin(9.0 * ray.x() + 2.0 * ray.y()) +
                            14.0 * std::sin(23.0 * ray.y()));
}

/// Light that falls from one side, and the lens's fall-off.
float light_at(const Eigen::Vector2d& ray, Draws draw) {
  const double slope_x = draw(-0.25, 0.25);
  const double slope_y = draw(-0.25, 0.25);
  const double level = draw(0.85, 1.05);
  return static_cast<float>(level * (1.0 + slope_x * ray.x() + slope_y * ray.y()) /
                            (1.0 + 0.35 * ray.squaredNorm()));
}

}  // namespace

BoardView::BoardView(BoardPicture board, const PinholeCamera& camera)
    : mm_per_px_(board.mm_per_px),
      first_px_mm_(board.first_px_mm),
      size_mm_(board.mm_per_px * board.brightness.width(),
               board.mm_per_px * board.brightness.height()),
      camera_(camera),
      rays_(camera.width_px + 2, camera.height_px + 2, Eigen::Vector2d::Zero()) {
  Image<float> full(board.brightness.width(), board.brightness.height());
  for (std::size_t i = 0; i < full.size(); ++i) full.data()[i] = board.brightness.data()[i];
  levels_.push_back(std::move(full));
  while (levels_.back().width() > 8 && levels_.back().height() > 8) {
    levels_.push_back(halved(levels_.back()));
  }
  for (int y = 0; y < rays_.height(); ++y) {
    for (int x = 0; x < rays_.width(); ++x) rays_(x, y) = camera.ray({x - 1.0, y - 1.0});
  }
}

bool BoardView::is_on_board(double x_mm, double y_mm) const {
  const double x = x_mm - first_px_mm_.x() + 0.5 * mm_per_px_;
  const double y = y_mm - first_px_mm_.y() + 0.5 * mm_per_px_;
  return x >= 0.0 && y >= 0.0 && x <= size_mm_.x() && y <= size_mm_.y();
}

/// @param px_mm  What a ray covers on the board.
float BoardView::brightness(double x_mm, double y_mm, double px_mm) const {
  const double level = std::log2(std::max(1.0, px_mm / mm_per_px_));
  const auto i = std::min(static_cast<std::size_t>(level), levels_.size() - 1);
  const double scale = std::exp2(-static_cast<double>(i));
  // Pixel centres of a level lie between those of the one above.
  const double x = ((x_mm - first_px_mm_.x()) / mm_per_px_ + 0.5) * scale - 0.5;
  const double y = ((y_mm - first_px_mm_.y()) / mm_per_px_ + 0.5) * scale - 0.5;
  return bilinear(levels_[i], x, y);
}

Image<float> BoardView::drawn(const Eigen::Isometry3d& camera_from_board, bool is_on_wall) const {
  const Plane plane(camera_from_board);
  Image<float> seen(camera_.width_px, camera_.height_px);
  for (int y = 0; y < camera_.height_px; ++y) {
    for (int x = 0; x < camera_.width_px; ++x) {
      const Eigen::Vector2d& center = rays_(x + 1, y + 1);
      const Eigen::Vector2d along_x = 0.5 * (rays_(x + 2, y + 1) - rays_(x, y + 1));
      const Eigen::Vector2d along_y = 0.5 * (rays_(x + 1, y + 2) - rays_(x + 1, y));
      float sum = 0.0F;
      for (int k = 0; k < kRaysASide * kRaysASide; ++k) {
        const double dx = (k % kRaysASide + 0.5) / kRaysASide - 0.5;
        const double dy = (k / kRaysASide + 0.5) / kRaysASide - 0.5;
        const Eigen::Vector2d ray = center + dx * along_x + dy * along_y;
        const auto z_mm = plane.depth_mm(ray);
        const Eigen::Vector3d place =
            z_mm ? Eigen::Vector3d(plane.board_from_camera * (*z_mm * ray.homogeneous()))
                 : Eigen::Vector3d::Zero();
        if (z_mm && is_on_board(place.x(), place.y())) {
          sum += brightness(place.x(), place.y(), *z_mm / (kRaysASide * camera_.focal_x_px));
        } else {
          sum += is_on_wall ? kWallBrightness : background(ray);
        }
      }
      seen(x, y) = sum / (kRaysASide * kRaysASide);
    }
  }
  return seen;
}

Image<Rgb8> BoardView::picture(Image<float> seen, const BoardLook& look, double contrast) const {
  static const NormalTable kNormal;
  const Draws light(scramble(look.seed));
  for (int y = 0; y < camera_.height_px; ++y) {
    for (int x = 0; x < camera_.width_px; ++x) seen(x, y) *= light_at(rays_(x + 1, y + 1), light);
  }
  blur(seen, look.blur_px);
  Image<Rgb8> picture(camera_.width_px, camera_.height_px);
  for (int y = 0; y < camera_.height_px; ++y) {
    RowRandom random(look.seed, 0, static_cast<std::uint64_t>(y));
    for (int x = 0; x < camera_.width_px; ++x) {
      const float grain = static_cast<float>(look.grain) * kNormal(random.next() >> 20U);
      const float value = 20.0F + static_cast<float>(contrast) * 0.9F * seen(x, y) + grain;
      const auto level = static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
      picture(x, y) = {level, level, level};
    }
  }
  return picture;
}

IdealDepth BoardView::depth(const Eigen::Isometry3d& camera_from_board, bool is_on_wall) const {
  const Plane plane(camera_from_board);
  IdealDepth ideal{Image<float>(camera_.width_px, camera_.height_px),
                   Image<std::uint8_t>(camera_.width_px, camera_.height_px)};
  for (int y = 0; y < camera_.height_px; ++y) {
    for (int x = 0; x < camera_.width_px; ++x) {
      const Eigen::Vector2d& ray = rays_(x + 1, y + 1);
      const Eigen::Vector3d direction = ray.homogeneous().normalized();
      auto z_mm = plane.depth_mm(ray);
      bool is_plane = false;
      if (z_mm) {
        const Eigen::Vector3d place = plane.board_from_camera * (*z_mm * ray.homogeneous());
        is_plane = is_on_board(place.x(), place.y());
      }
      if (z_mm && is_on_wall && !is_plane) {
        z_mm = *z_mm * (1.0 + kBoardThicknessMm / plane.distance_mm);
        is_plane = true;
      }
      ideal.z_mm(x, y) = static_cast<float>(is_plane ? *z_mm : is_on_wall ? 0.0 : kBackgroundMm);
      const double facing = is_plane ? std::abs(plane.normal.dot(direction)) : direction.z();
      ideal.facing(x, y) = static_cast<std::uint8_t>(255.0 * facing);
    }
  }
  return ideal;
}

}  // namespace mor::internal
