// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/scene/table.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "morgagni/camera/internal/random.h"

namespace mor::internal {
namespace {

constexpr float kTableWidthMm = 760.0F;
constexpr float kTableLengthMm = 1900.0F;
constexpr float kPlankMm = 126.0F;

float lattice(int x, int y, int z, std::uint64_t seed) {
  const auto key = static_cast<std::uint64_t>((x & 255) | (y & 255) << 8 | (z & 255) << 16);
  return static_cast<float>(to_unit(scramble(seed ^ (key << 20U))));
}

/// Smooth noise in the plane, from lattice values that are drawn once.
class PlaneNoise {
 public:
  explicit PlaneNoise(std::uint64_t seed) : values_(std::size_t{kSide} * kSide) {
    for (std::size_t i = 0; i < values_.size(); ++i) {
      values_[i] = static_cast<float>(to_unit(scramble(seed * 0x10001U + i)));
    }
  }

  [[nodiscard]] float at(float x, float y) const {
    const int ix = static_cast<int>(x);  // Never negative here.
    const int iy = static_cast<int>(y);
    const float tx = eased(x - static_cast<float>(ix));
    const float ty = eased(y - static_cast<float>(iy));
    const float above = value(ix, iy) + tx * (value(ix + 1, iy) - value(ix, iy));
    const float below = value(ix, iy + 1) + tx * (value(ix + 1, iy + 1) - value(ix, iy + 1));
    return above + ty * (below - above);
  }

 private:
  static constexpr int kSide = 256;
  static float eased(float t) { return t * t * (3.0F - 2.0F * t); }
  [[nodiscard]] float value(int x, int y) const {
    return values_[static_cast<std::size_t>((y & (kSide - 1)) * kSide + (x & (kSide - 1)))];
  }
  std::vector<float> values_;
};

float eased(float t) {
  return t * t * (3.0F - 2.0F * t);
}

std::uint8_t to_byte(float value) {
  return static_cast<std::uint8_t>(std::clamp(value, 0.0F, 255.0F));
}

/// Shadow is cast by what is near above the table; a grid of cells holds how near the skin comes.
class Occlusion {
 public:
  static constexpr float kCellMm = 8.0F;
  static constexpr float kReachMm = 110.0F;

  Occlusion(int width, int height) : shade_(width, height, 0.0F) {}

  void add(float x_mm, float z_mm, float above_mm) {
    const int x = static_cast<int>(x_mm / kCellMm);
    const int z = static_cast<int>(z_mm / kCellMm);
    if (x_mm < 0.0F || z_mm < 0.0F || !shade_.view().contains(x, z)) return;
    shade_(x, z) = std::max(shade_(x, z), std::clamp(1.0F - above_mm / kReachMm, 0.0F, 1.0F));
  }

  /// Three passes of a box come close to a Gaussian.
  void blur() {
    for (int pass = 0; pass < 3; ++pass) {
      shade_ = blurred(shade_, 1, 0);
      shade_ = blurred(shade_, 0, 1);
    }
  }

  [[nodiscard]] float at(float x_mm, float z_mm) const {
    const float x = std::clamp(x_mm / kCellMm - 0.5F, 0.0F, static_cast<float>(shade_.width() - 2));
    const float z =
        std::clamp(z_mm / kCellMm - 0.5F, 0.0F, static_cast<float>(shade_.height() - 2));
    const int column = static_cast<int>(x);
    const int row = static_cast<int>(z);
    const float tx = x - static_cast<float>(column);
    const float tz = z - static_cast<float>(row);
    return std::lerp(std::lerp(shade_(column, row), shade_(column + 1, row), tx),
                     std::lerp(shade_(column, row + 1), shade_(column + 1, row + 1), tx),
                     tz);
  }

 private:
  /// The rim, which no shadow reaches, stays clear.
  static Image<float> blurred(const Image<float>& image, int step_x, int step_y) {
    constexpr int kRadius = 2;
    Image<float> result(image.width(), image.height(), 0.0F);
    for (int y = kRadius; y < image.height() - kRadius; ++y) {
      for (int x = kRadius; x < image.width() - kRadius; ++x) {
        float sum = 0.0F;
        for (int i = -kRadius; i <= kRadius; ++i) sum += image(x + i * step_x, y + i * step_y);
        result(x, y) = sum / (2 * kRadius + 1);
      }
    }
    return result;
  }

  Image<float> shade_;
};

}  // namespace

float smooth_noise(float x, float y, float z, std::uint64_t seed) {
  const int ix = static_cast<int>(std::floor(x));
  const int iy = static_cast<int>(std::floor(y));
  const int iz = static_cast<int>(std::floor(z));
  const float tx = eased(x - static_cast<float>(ix));
  const float ty = eased(y - static_cast<float>(iy));
  const float tz = eased(z - static_cast<float>(iz));
  const auto along_x = [&](int y_at, int z_at) {
    return std::lerp(lattice(ix, y_at, z_at, seed), lattice(ix + 1, y_at, z_at, seed), tx);
  };
  return std::lerp(std::lerp(along_x(iy, iz), along_x(iy + 1, iz), ty),
                   std::lerp(along_x(iy, iz + 1), along_x(iy + 1, iz + 1), ty),
                   tz);
}

Table::Table(const TriangleMesh& skin, std::uint64_t seed, double uneven_mm)
    : picture_(static_cast<int>(kTableWidthMm * kTexelsPerMm),
               static_cast<int>(kTableLengthMm * kTexelsPerMm)) {
  const auto bounds = skin.bounds();
  top_mm_ = bounds.max().y();
  left_mm_ = bounds.center().x() - 0.5F * kTableWidthMm;
  foot_mm_ = bounds.center().z() - 0.5F * kTableLengthMm;
  paint_wood(seed);
  paint_shadow(skin);
  if (uneven_mm > 0.0) bend(uneven_mm, seed);
}

void Table::bend(double uneven_mm, std::uint64_t seed) {
  constexpr int kWaves = 8;
  constexpr float kNodeMm = kTexelsANode / kTexelsPerMm;
  heights_mm_ = Image<float>(static_cast<int>(kTableWidthMm / kNodeMm) + 2,
                             static_cast<int>(kTableLengthMm / kNodeMm) + 2,
                             0.0F);
  Draws draw(scramble(seed ^ 0x5441424CU));
  for (int wave = 0; wave < kWaves; ++wave) {
    const double length_mm = draw(400.0, 1600.0);
    const double direction_rad = draw(0.0, std::numbers::pi);
    const double phase_rad = draw(0.0, 2.0 * std::numbers::pi);
    const double per_node = 2.0 * std::numbers::pi * static_cast<double>(kNodeMm) / length_mm;
    for (int z = 0; z < heights_mm_.height(); ++z) {
      for (int x = 0; x < heights_mm_.width(); ++x) {
        const double along = x * std::cos(direction_rad) + z * std::sin(direction_rad);
        heights_mm_(x, z) += static_cast<float>(std::sin(per_node * along + phase_rad));
      }
    }
  }
  double squares = 0.0;
  for (std::size_t i = 0; i < heights_mm_.size(); ++i) {
    squares += static_cast<double>(heights_mm_.data()[i] * heights_mm_.data()[i]);
  }
  const double rms = std::sqrt(squares / static_cast<double>(heights_mm_.size()));
  for (std::size_t i = 0; i < heights_mm_.size(); ++i) {
    heights_mm_.data()[i] *= static_cast<float>(uneven_mm / rms);
  }
}

float Table::height_mm(float column, float row) const {
  const float x = column / kTexelsANode;
  const float z = row / kTexelsANode;
  const int left = static_cast<int>(x);
  const int foot = static_cast<int>(z);
  const float share_x = x - static_cast<float>(left);
  return std::lerp(std::lerp(heights_mm_(left, foot), heights_mm_(left + 1, foot), share_x),
                   std::lerp(heights_mm_(left, foot + 1), heights_mm_(left + 1, foot + 1), share_x),
                   z - static_cast<float>(foot));
}

/// Planks along the body, each of its own tone, with grain that is stretched along it.
void Table::paint_wood(std::uint64_t seed) {
  const PlaneNoise waves(seed + 1);
  const PlaneNoise fibers(seed + 2);
  for (int row = 0; row < picture_.height(); ++row) {
    const float z_mm = static_cast<float>(row) / kTexelsPerMm;
    for (int column = 0; column < picture_.width(); ++column) {
      const float x_mm = static_cast<float>(column) / kTexelsPerMm;
      const float plank = std::floor(x_mm / kPlankMm);
      const float in_plank_mm = x_mm - plank * kPlankMm;
      const float own = lattice(static_cast<int>(plank), 7, 3, seed);
      const float wave = waves.at(x_mm / 60.0F, z_mm / 260.0F + 9.0F * own);
      const float grain = fibers.at(x_mm / 5.0F + 14.0F * wave, z_mm / 190.0F + 31.0F * plank);
      const float fiber = fibers.at(x_mm / 1.6F, z_mm / 45.0F + 57.0F * plank);
      const float seam_mm = std::min(in_plank_mm, kPlankMm - in_plank_mm);
      const float seam = seam_mm < 1.3F ? 0.55F : 1.0F;
      const float tone = seam * (0.74F + 0.14F * own + 0.16F * grain + 0.07F * fiber);
      picture_(column, row) = {
          to_byte(168.0F * tone), to_byte(124.0F * tone), to_byte(84.0F * tone)};
    }
  }
}

void Table::paint_shadow(const TriangleMesh& skin) {
  Occlusion occlusion(static_cast<int>(kTableWidthMm / Occlusion::kCellMm),
                      static_cast<int>(kTableLengthMm / Occlusion::kCellMm));
  for (const auto& vertex : skin.vertices) {
    occlusion.add(vertex.x() - left_mm_, vertex.z() - foot_mm_, top_mm_ - vertex.y());
  }
  occlusion.blur();
  for (int row = 0; row < picture_.height(); ++row) {
    for (int column = 0; column < picture_.width(); ++column) {
      const float shade = occlusion.at(static_cast<float>(column) / kTexelsPerMm,
                                       static_cast<float>(row) / kTexelsPerMm);
      auto& color = picture_(column, row);
      const float light = 1.0F - 0.62F * std::min(1.0F, 1.25F * shade);
      color = {to_byte(light * color.r), to_byte(light * color.g), to_byte(light * color.b)};
    }
  }
}

}  // namespace mor::internal
