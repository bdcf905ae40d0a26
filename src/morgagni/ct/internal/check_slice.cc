// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/check_slice.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

#include "morgagni/ct/internal/outline_colors.h"

namespace mor::internal {
namespace {

/// From black to white: what lies on the body is seen as well as what is in it.
constexpr double kLowHu = -1000.0;
constexpr double kHighHu = 400.0;

/// A value between the eight voxels around a place; places outside are at the nearest voxel.
template <class Value>
double between_voxels(const std::array<int, 3>& size,
                      const Eigen::Vector3d& voxel,
                      const Value& value) {
  std::array<int, 3> low{};
  std::array<int, 3> high{};
  Eigen::Vector3d share;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double at = std::clamp(voxel[static_cast<int>(axis)], 0.0, size[axis] - 1.0);
    low[axis] = static_cast<int>(at);
    high[axis] = std::min(low[axis] + 1, size[axis] - 1);
    share[static_cast<int>(axis)] = at - low[axis];
  }
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1.0;
    std::array<int, 3> at{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool is_high = (corner >> axis & 1) != 0;
      at[axis] = is_high ? high[axis] : low[axis];
      weight *= is_high ? share[static_cast<int>(axis)] : 1.0 - share[static_cast<int>(axis)];
    }
    if (weight > 0.0) sum += weight * value(at);
  }
  return sum;
}

Rgb8 tinted(std::uint8_t grey, Rgb8 color, double share) {
  const auto mixed = [&](std::uint8_t channel) {
    return static_cast<std::uint8_t>(std::lround(grey + share * (channel - grey)));
  };
  return {mixed(color.r), mixed(color.g), mixed(color.b)};
}

double hu_at(const Volume& volume, const Eigen::Vector3d& mm) {
  return between_voxels(
      volume.size, mm.cwiseQuotient(volume.spacing_mm), [&](const std::array<int, 3>& at) {
        return static_cast<double>(volume.hu[volume.index(at[0], at[1], at[2])]);
      });
}

/// Share of the body around a place.
double body_at(const CheckedBody& body, const Eigen::Vector3d& mm) {
  return between_voxels(
      body.grid.size, mm.cwiseQuotient(body.grid.spacing_mm), [&](const std::array<int, 3>& at) {
        return body.body.test(at[0], at[1], at[2]) ? 1.0 : 0.0;
      });
}

/// The nearest voxel of the grid.
std::array<int, 3> voxel_at(const CheckedBody& body, const Eigen::Vector3d& mm) {
  std::array<int, 3> at{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    at[i] = std::clamp(static_cast<int>(std::lround(mm[axis] / body.grid.spacing_mm[axis])),
                       0,
                       body.grid.size[i] - 1);
  }
  return at;
}

/// The part that the nearest voxel is of.
const BodyPart* part_at(const CheckedBody& body, const Eigen::Vector3d& mm) {
  const auto at = voxel_at(body, mm);
  const std::uint8_t label = body.labels[body.grid.index(at[0], at[1], at[2])];
  return label == 0 ? nullptr : &body.parts[label - 1U];
}

Rgb8 color_of(const CheckedBody& body,
              double hu,
              std::uint8_t grey,
              bool is_inside,
              const Eigen::Vector3d& mm) {
  constexpr double kKeptTint = 0.3;
  constexpr double kCutTint = 0.75;
  constexpr Rgb8 kLoose = {170, 70, 70};  // Cut, and too small to be listed.
  const BodyPart* part = part_at(body, mm);
  if (is_inside)
    return part != nullptr && part->is_kept ? tinted(grey, part->color, kKeptTint)
                                            : Rgb8{grey, grey, grey};
  if (hu < body.threshold_hu || hu > body.upper_hu) return {grey, grey, grey};
  return tinted(grey, part != nullptr ? part->color : kLoose, kCutTint);
}

/// Two pixels wide: one on either side.
template <class ColorAt>
void draw_outline(const Image<char>& inside, Image<Rgb8>& picture, const ColorAt& color_at) {
  const auto is_inside = [&](int x, int y) {
    return inside(std::clamp(x, 0, inside.width() - 1), std::clamp(y, 0, inside.height() - 1)) != 0;
  };
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const bool here = is_inside(x, y);
      if (is_inside(x - 1, y) != here || is_inside(x + 1, y) != here ||
          is_inside(x, y - 1) != here || is_inside(x, y + 1) != here)
        picture(x, y) = color_at(x, y);
    }
  }
}

}  // namespace

SliceFrame::SliceFrame(const Volume& volume, BodyPlane plane) : spacing_mm_(volume.spacing_mm) {
  // LPS axes across, down and through; whether each runs against LPS in the picture.
  struct Hanging {
    std::array<int, 3> lps;
    std::array<bool, 3> against;
  };
  constexpr std::array<Hanging, 3> kHangings = {{{{0, 1, 2}, {false, false, false}},
                                                 {{0, 2, 1}, {false, true, false}},
                                                 {{1, 2, 0}, {false, true, false}}}};
  const Hanging& hanging = kHangings[static_cast<std::size_t>(plane)];
  const Eigen::Matrix3d& axes = volume.ct_from_grid.linear();
  for (std::size_t i = 0; i < 3; ++i) {
    const int lps = hanging.lps[i];
    axes.row(lps).cwiseAbs().maxCoeff(&axis_[i]);
    flipped_[i] = (axes(lps, axis_[i]) < 0.0) != hanging.against[i];
    size_mm_[static_cast<int>(i)] =
        volume.size[static_cast<std::size_t>(axis_[i])] * volume.spacing_mm[axis_[i]];
  }
}

Eigen::Vector3d SliceFrame::grid_mm(const Eigen::Vector3d& shares) const {
  Eigen::Vector3d place;
  for (std::size_t i = 0; i < 3; ++i) {
    const double share = shares[static_cast<int>(i)];
    place[axis_[i]] = (flipped_[i] ? 1.0 - share : share) * size_mm_[static_cast<int>(i)] -
                      0.5 * spacing_mm_[axis_[i]];
  }
  return place;
}

double SliceFrame::share_through(const Eigen::Vector3d& grid_mm) const {
  const int axis = axis_[2];
  const double share = (grid_mm[axis] + 0.5 * spacing_mm_[axis]) / size_mm_.z();
  return std::clamp(flipped_[2] ? 1.0 - share : share, 0.0, 1.0);
}

Image<Rgb8> draw_check_slice(const Volume& volume,
                             BodyPlane plane,
                             double position,
                             int height_px,
                             const CheckedBody* body) {
  const SliceFrame frame(volume, plane);
  const double width = height_px * frame.size_mm().x() / frame.size_mm().y();
  const int width_px = std::clamp(static_cast<int>(std::lround(width)), 1, 4 * height_px);
  Image<Rgb8> picture(width_px, height_px);
  Image<char> inside(width_px, height_px, 0);
  const auto place_mm = [&](int x, int y) {
    return frame.grid_mm({(x + 0.5) / width_px, (y + 0.5) / height_px, position});
  };
  tbb::parallel_for(0, height_px, [&](int y) {
    for (int x = 0; x < width_px; ++x) {
      const Eigen::Vector3d mm = place_mm(x, y);
      const double hu = hu_at(volume, mm);
      const auto grey = static_cast<std::uint8_t>(
          255.0 * std::clamp((hu - kLowHu) / (kHighHu - kLowHu), 0.0, 1.0));
      picture(x, y) = {grey, grey, grey};
      if (body == nullptr) continue;
      const bool is_inside = body_at(*body, mm) > 0.5;
      inside(x, y) = is_inside ? 1 : 0;
      picture(x, y) = color_of(*body, hu, grey, is_inside, mm);
    }
  });
  if (body == nullptr) return picture;
  draw_outline(inside, picture, [&](int x, int y) {
    const auto at = voxel_at(*body, place_mm(x, y));
    return body->doubtful.test(at[0], at[1], at[2]) ? kDoubtful : kOutline;
  });
  return picture;
}

}  // namespace mor::internal
